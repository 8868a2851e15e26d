"""Loads, starts, stops and runs controllers, with the semantics of ros_control's manager.

One thread, the control loop, calls `ControllerManager.update`. All other methods may be called
from any number of other threads. A switch is prepared in the calling thread, carried out by the
loop at the end of one cycle, and only its caller, and whoever wants the next switch, waits for it:
listing, loading and unloading do not. A paused simulation goes on calling `apply_switch`.
"""

from __future__ import annotations

import enum
import importlib
import logging
import math
import sys
import threading
import time as wall
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Set, Tuple

from ..common.params import ConfigError
from ..controllers import controller_class
from ..controllers import type_names as builtin_types
from ..hardware.hardware_interface import (
    ControllerInfo,
    HardwareInterfaceError,
    RobotHW,
    SwitchState,
)
from ..ros.node_handle import NodeHandle
from .controller import Controller, ControllerInitError, ControllerState, LoadedController

BASE_CLASS = "controller_interface::ControllerBase"

_GIVE_UP_MARGIN = 1.0
"""Wall time (s) beyond its timeout for which a switch waits for the control loop."""

_TAKE_BACK_TIME = 0.2
"""Wall time (s) that the loop gets to answer a switch that is given up, as it may just begin it."""


class Strictness(enum.IntEnum):
    """What happens to a switch that cannot be carried out in every detail."""

    BEST_EFFORT = 1
    STRICT = 2


class _Switch:
    """A switch on its way through the control loop.

    The caller prepares it and waits for `done`; from `begun_at` on, the rest is the loop's.
    """

    def __init__(
        self,
        start: List[LoadedController],
        stop: List[LoadedController],
        start_asap: bool,
        timeout: float,
    ) -> None:
        self.start = start
        self.stop = stop
        self.start_asap = start_asap
        self.timeout = timeout
        self.begun_at: Optional[float] = None
        self.pending = list(start)
        self.failed = False
        self.given_up = False
        self.done = threading.Event()

    def concerns(self, loaded: LoadedController) -> bool:
        """Whether it starts or stops this controller."""
        return loaded in self.start or loaded in self.stop


class ControllerManager:
    """The controllers of one robot.

    Parameters
    ----------
    root : NodeHandle
        The robot's namespace; controller ``x`` has its parameters and topics in ``x`` inside it.
    """

    def __init__(self, hw: RobotHW, root: NodeHandle) -> None:
        self._hw = hw
        self._root = root
        self._log = logging.getLogger("rosout")
        # Replaced as a whole, never changed: the loop reads it without a lock.
        self._controllers: Tuple[LoadedController, ...] = ()
        self._switch: Optional[_Switch] = None
        # Held while controllers are loaded, unloaded, or a switch is planned; never while one
        # waits for the loop. Listing takes no lock.
        self._changes = threading.Lock()
        # One switch at a time; taken before `_changes`.
        self._switching = threading.Lock()
        self._closing = threading.Event()
        self._modules: Set[str] = set()
        self._user_types: Set[str] = set()

    # --- the control loop's side -------------------------------------------------------------

    def update(self, time: float, period: float, reset_controllers: bool = False) -> None:
        """Run one cycle: every running controller in load order, then a pending switch.

        Parameters
        ----------
        time, period : float
            Time of the cycle, and since the last one (s).
        reset_controllers : bool
            Stop and start every running controller first, as after an emergency stop.
        """
        if reset_controllers:
            self.restart_running(time)
        for loaded in self._controllers:
            if loaded.state is not ControllerState.RUNNING:
                continue
            try:
                loaded.controller.update(time, period)
            except (Exception, SystemExit):  # whatever a user's controller raises
                self._log.exception(
                    "controller '%s' raised an exception and is stopped", loaded.name
                )
                self._stop_failed(loaded, time)
        if self._switch is not None:
            self.apply_switch(time)

    def restart_running(self, time: float) -> None:
        """Stop and start every running controller at `time` (s): it holds what is measured."""
        for loaded in self._controllers:
            if _is_running(loaded.state) and self._guarded(loaded.stop, loaded, time):
                self._guarded(loaded.start, loaded, time)

    def interrupt(self, time: float) -> None:
        """Let every running controller forget at `time` (s) what it was commanded."""
        for loaded in self._controllers:
            if _is_running(loaded.state):
                self._guarded(loaded.controller.interrupt, loaded, time)

    def reset(self, time: float) -> None:
        """Let every running controller begin anew at `time` (s), as when the world is reset.

        A controller that was stopped because it raised is started again, unless another has its
        joints by now, or a switch is under way that may give them to another.
        """
        for loaded in self._controllers:
            if _is_running(loaded.state):
                self._guarded(loaded.controller.reset, loaded, time)
        for loaded in self._controllers:
            if not loaded.failed or self._switch is not None:
                continue
            running = [c.info for c in self._controllers if _is_running(c.state)]
            if self._hw.check_for_conflict([*running, loaded.info]) is None:
                self._hw.do_switch([loaded.info], [])
                self._guarded(loaded.start, loaded, time)

    def save_state(self) -> Dict[LoadedController, Any]:
        """Return the state of every running controller; it does not change any more."""
        return {
            loaded: loaded.controller.save_state()
            for loaded in self._controllers
            if loaded.state is ControllerState.RUNNING
        }

    def restore_running(self, saved: Dict[LoadedController, Any], time: float) -> None:
        """Have the controllers run at `time` (s) that ran in a state, and no others.

        What was unloaded since then stays so.

        Parameters
        ----------
        saved : dict
            What `save_state` returned.
        """
        running = [each for each in self._controllers if each.state is ControllerState.RUNNING]
        stop = [each for each in running if each not in saved]
        start = [each for each in self._controllers if each in saved and each not in running]
        for loaded in stop:
            self._guarded(loaded.stop, loaded, time)
        if start or stop:
            self._hw.do_switch([each.info for each in start], [each.info for each in stop])
        for loaded in start:
            self._guarded(loaded.start, loaded, time)

    def restore_state(
        self, saved: Dict[LoadedController, Any], time: float, elapsed: float
    ) -> None:
        """Let the controllers that run take a state up again, `elapsed` (s) after it was saved.

        To be called at `time` (s), once the hardware has its state again. A controller that
        declares no state is stopped and started.
        """
        for loaded in self._controllers:
            if loaded not in saved or loaded.state is not ControllerState.RUNNING:
                continue
            if not loaded.controller.has_state():
                if self._guarded(loaded.stop, loaded, time):
                    self._guarded(loaded.start, loaded, time)
                continue

            def restore(_: float, loaded: LoadedController = loaded) -> None:
                loaded.controller.restore_state(saved[loaded], elapsed)

            self._guarded(restore, loaded, time)

    def apply_switch(self, time: float) -> None:
        """Advance a pending switch at `time` (s). Part of `update`; called alone while paused."""
        switch = self._switch
        if switch is None:
            return
        if switch.begun_at is None:
            if switch.given_up:
                switch.failed = True
                self._finish(switch)
                return
            switch.begun_at = time
            if not self._change_modes(switch):
                self._finish(switch)
                return
            for loaded in switch.stop:
                if not self._guarded(loaded.stop, loaded, time):
                    loaded.failed = False  # somebody wanted it stopped, and so it stays
        self._start_pending(switch, time)
        if not switch.pending:
            self._finish(switch)

    def _change_modes(self, switch: _Switch) -> bool:
        """Let the hardware change the joints' modes; when it cannot, nothing is switched."""
        # A reset may have started a controller again after the switch was planned.
        if self._conflict(switch.start, switch.stop):
            switch.failed = True
            return False
        try:
            self._hw.do_switch([c.info for c in switch.start], [c.info for c in switch.stop])
        except Exception:
            self._log.exception("Could not switch controllers: the hardware raised an exception")
            switch.failed = True
        return not switch.failed

    def _finish(self, switch: _Switch) -> None:
        self._switch = None
        switch.done.set()

    def _start_pending(self, switch: _Switch, time: float) -> None:
        overall = self._hw.switch_result()
        assert switch.begun_at is not None
        late = switch.given_up or 0.0 < switch.timeout < time - switch.begun_at
        for loaded in list(switch.pending):
            result = self._hw.switch_result(loaded.info) if switch.start_asap else overall
            if result is SwitchState.DONE:
                switch.failed |= not self._guarded(loaded.start, loaded, time)
            elif result is SwitchState.ERROR or late:
                loaded.state = ControllerState.ABORTED
                switch.failed = True
                self._hw.do_switch([], [loaded.info])
            else:
                loaded.state = ControllerState.WAITING
                continue
            switch.pending.remove(loaded)

    def _guarded(
        self, action: Callable[[float], None], loaded: LoadedController, time: float
    ) -> bool:
        try:
            action(time)
        except (Exception, SystemExit):  # as in update
            self._log.exception(
                "controller '%s' raised an exception while it was switched", loaded.name
            )
            self._stop_failed(loaded, time)
            return False
        return True

    def _stop_failed(self, loaded: LoadedController, time: float) -> None:
        """Stop a controller that raised; its joints must not keep its last command."""
        try:
            loaded.stop(time)
        except (Exception, SystemExit):
            self._log.exception("controller '%s' raised again while it was stopped", loaded.name)
        loaded.state = ControllerState.STOPPED
        loaded.failed = True
        self._hw.do_switch([], [loaded.info])

    # --- the services' side ------------------------------------------------------------------

    @property
    def loaded(self) -> Dict[str, LoadedController]:
        """The controllers that are loaded, by their names."""
        return {each.name: each for each in self._controllers}

    def list_controllers(self) -> List[Tuple[ControllerInfo, ControllerState]]:
        """All loaded controllers in load order, and their states. Never blocks."""
        return [(loaded.info, loaded.state) for loaded in self._controllers]

    def controller(self, name: str) -> Controller:
        """Return a loaded controller. Never blocks.

        Raises
        ------
        KeyError
            None of that name is loaded.
        """
        loaded = self._find(name)
        if loaded is None:
            raise KeyError(f"no controller '{name}' is loaded")
        return loaded.controller

    def list_controller_types(self) -> List[Tuple[str, str]]:
        """Type name and base class of the controllers of this package, and of users' so far."""
        return [(name, BASE_CLASS) for name in sorted({*builtin_types(), *self._user_types})]

    def load_controller(self, name: str) -> bool:
        """Load and initialise the controller whose parameters stand under `name`.

        Returns
        -------
        bool
            False, with the reason in the log, when it cannot be loaded.
        """
        with self._changes:
            if not name:
                self._log.error("Could not load a controller: its name is empty")
                return False
            if self._find(name) is not None:
                self._log.error(
                    "A controller named '%s' was already loaded inside the controller manager",
                    name,
                )
                return False
            node = self._root.child(name)
            loaded = self._construct(name, node)
            if loaded is None or not self._init(loaded):
                node.shutdown()
                return False
            self._controllers = (*self._controllers, loaded)
            return True

    def _construct(self, name: str, node: NodeHandle) -> Optional[LoadedController]:
        type_name = node.find_param("type", None)
        if not isinstance(type_name, str):
            self._log.error(
                "Could not load controller '%s' because the type was not specified. Did you load "
                "the controller configuration on the parameter server (namespace: '%s')?",
                name,
                node.namespace,
            )
            return None
        try:
            kind = controller_class(type_name)
        except ControllerInitError as error:
            self._log.error(
                "Could not load controller '%s' because controller type '%s' does not exist.",
                name,
                type_name,
            )
            self._log.error("%s", error)
            return None
        self._modules.add(kind.__module__)
        if type_name not in builtin_types():
            self._user_types.add(type_name)
        try:
            return LoadedController(name, type_name, kind(), node)
        except (Exception, SystemExit):  # a user's class may raise anything
            self._log.exception("Exception thrown while constructing controller '%s'", name)
            return None

    def _init(self, loaded: LoadedController) -> bool:
        self._warn_of_unknown_params(loaded)
        try:
            loaded.init(self._hw, self._root)
        except (ConfigError, HardwareInterfaceError, ControllerInitError) as error:
            self._log.error("Initializing controller '%s' failed: %s", loaded.name, error)
            return False
        except (Exception, SystemExit):  # as above
            self._log.exception("Exception thrown while initializing controller '%s'", loaded.name)
            self._log.error("Initializing controller '%s' failed", loaded.name)
            return False
        return True

    def _warn_of_unknown_params(self, loaded: LoadedController) -> None:
        known = loaded.controller.parameters
        if known is None:
            return
        unknown = sorted(set(loaded.node.params()) - known - {"type"})
        if unknown:
            self._log.warning(
                "controller '%s' does not know its parameter(s) %s; known are %s",
                loaded.name,
                ", ".join(unknown),
                ", ".join(sorted(known)),
            )

    def unload_controller(self, name: str) -> bool:
        """Unload a controller that is not running; False, with the reason in the log, if not."""
        with self._changes:
            return self._unload(name)

    def _unload(self, name: str) -> bool:
        loaded = self._find(name)
        if loaded is None:
            self._log.error(
                "Could not unload controller with name '%s' because no controller with this name "
                "exists",
                name,
            )
            return False
        if _is_running(loaded.state):
            self._log.error(
                "Could not unload controller with name '%s' because it is still running", name
            )
            return False
        switch = self._switch
        if switch is not None and switch.concerns(loaded):
            self._log.error(
                "Could not unload controller with name '%s' because it is being switched", name
            )
            return False
        self._controllers = tuple(c for c in self._controllers if c is not loaded)
        loaded.node.shutdown()
        return True

    def reload_controller_libraries(self, force_kill: bool) -> bool:
        """Import the modules of controller classes anew.

        Parameters
        ----------
        force_kill : bool
            Stop and unload what is loaded; without it, the call fails while anything is loaded.
        """
        if not force_kill and self._controllers:
            self._refuse_reload()
            return False
        running = [info.name for info, state in self.list_controllers() if _is_running(state)]
        if running and not self.switch_controller([], running, Strictness.BEST_EFFORT):
            return False
        with self._changes:
            for loaded in self._controllers:
                self._unload(loaded.name)
            if self._controllers:
                self._refuse_reload()
                return False
            for module in sorted(self._modules):
                try:
                    importlib.reload(sys.modules[module])
                except (Exception, SystemExit):  # as when it was first imported
                    self._log.exception("Could not reload the module %s", module)
                    return False
        return True

    def _refuse_reload(self) -> None:
        self._log.error(
            "Cannot reload controller libraries because there are still %d controllers loaded",
            len(self._controllers),
        )

    def switch_controller(
        self,
        start: Sequence[str],
        stop: Sequence[str],
        strictness: int = Strictness.STRICT,
        start_asap: bool = False,
        timeout: float = 0.0,
    ) -> bool:
        """Stop and start controllers together, in one control cycle.

        Parameters
        ----------
        strictness : int
            STRICT: anything that cannot be done fails the whole switch. BEST_EFFORT: it is left
            out. Conflicts fail the switch in both.
        start_asap : bool
            Start each controller as soon as its own hardware is ready.
        timeout : float
            Time for the hardware to become ready (s); 0 waits without end.

        Returns
        -------
        bool
            Whether the switch was carried out; the log says why not.
        """
        if not math.isfinite(timeout) or timeout < 0.0:
            self._log.error("Could not switch controllers: timeout %s is not 0 or more s", timeout)
            return False
        if strictness not in (Strictness.BEST_EFFORT, Strictness.STRICT):
            self._log.warning(
                "switch_controller: strictness %s is unknown (1 is BEST_EFFORT, 2 is STRICT); "
                "BEST_EFFORT is taken",
                strictness,
            )
            strictness = Strictness.BEST_EFFORT
        with self._switching:
            if self._closing.is_set():
                return False
            with self._changes:
                plan = self._plan(start, stop, strictness == Strictness.STRICT)
                if plan is None:
                    return False
                to_start, to_stop = plan
                if not (to_start or to_stop):
                    return True
                if not self._feasible(to_start, to_stop):
                    return False
                if self._switch is not None:
                    self._log.error(
                        "Could not switch controllers: the control loop has not finished the "
                        "last switch, which was given up"
                    )
                    return False
                switch = _Switch(to_start, to_stop, start_asap, timeout)
                self._switch = switch
            return self._wait_for(switch)

    def close(self) -> None:
        """Let every waiting caller return; the loop will not run again."""
        self._closing.set()

    def _wait_for(self, switch: _Switch) -> bool:
        timeout = switch.timeout + _GIVE_UP_MARGIN if switch.timeout > 0.0 else math.inf
        give_up = wall.monotonic() + timeout
        while not switch.done.wait(0.05):
            if self._closing.is_set():
                return False
            if wall.monotonic() > give_up:
                # The loop takes back what has not started, now or when it runs again.
                switch.given_up = True
                if switch.done.wait(_TAKE_BACK_TIME):
                    break
                self._log.error("Could not switch controllers: the control loop did not respond")
                return False
        return not switch.failed

    def _find(self, name: str) -> Optional[LoadedController]:
        return next((c for c in self._controllers if c.name == name), None)

    def _plan(
        self, start: Sequence[str], stop: Sequence[str], strict: bool
    ) -> Optional[Tuple[List[LoadedController], List[LoadedController]]]:
        """Turn names into what is really to be started and stopped; None when it must fail."""
        found: Dict[str, LoadedController] = {c.name: c for c in self._controllers}
        for verb, names in (("stop", stop), ("start", start)):
            for name in names:
                if name in found:
                    continue
                self._log.log(
                    logging.ERROR if strict else logging.DEBUG,
                    "Could not %s controller with name '%s' because no controller with this name "
                    "exists",
                    verb,
                    name,
                )
                if strict:
                    return None
        to_stop = _unique(found[name] for name in stop if name in found)
        to_start = _unique(found[name] for name in start if name in found)
        for loaded in list(to_stop):
            if _is_running(loaded.state):
                if loaded in to_start:
                    self._log.error(
                        "Could not start or stop controller '%s' because of conflicting switching "
                        "command: it is in both lists",
                        loaded.name,
                    )
                    return None
            elif strict:
                self._log.error(
                    "Could not stop controller '%s' since it is not running", loaded.name
                )
                return None
            else:
                to_stop.remove(loaded)
        for loaded in list(to_start):
            if not _is_running(loaded.state):
                continue
            if strict:
                self._log.error("Controller '%s' is already running", loaded.name)
                return None
            to_start.remove(loaded)
        return to_start, to_stop

    def _conflict(self, start: List[LoadedController], stop: List[LoadedController]) -> bool:
        """Tell, and log, whether two controllers would claim the same joint."""
        after = [c for c in self._controllers if _is_running(c.state) and c not in stop] + start
        conflict = self._hw.check_for_conflict([c.info for c in after])
        if conflict is not None:
            self._log.error("Could not switch controllers, due to resource conflict: %s", conflict)
        return conflict is not None

    def _feasible(self, start: List[LoadedController], stop: List[LoadedController]) -> bool:
        if self._conflict(start, stop):
            return False
        reason = self._hw.prepare_switch([c.info for c in start], [c.info for c in stop])
        if reason is not None:
            self._log.error(
                "Could not switch controllers. The hardware interface combination for the "
                "requested controllers is unfeasible: %s",
                reason,
            )
            return False
        return True


def _is_running(state: ControllerState) -> bool:
    return state is ControllerState.RUNNING


def _unique(controllers: Iterable[LoadedController]) -> List[LoadedController]:
    return list(dict.fromkeys(controllers))
