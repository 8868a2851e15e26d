"""Recovery of a simulator that crashed: its clock and the emergency stops."""

from __future__ import annotations

from typing import Any, Set

from telex_control.ros.run_memory import RunMemory

from ..engine.simulation import Simulation


class CrashRecovery:
    """Restores what must survive a crash, and keeps it for the next one.

    The scene begins anew, as after a reset. Sim time goes on, since tf, bags and timers do not
    survive a clock that jumps back, and an emergency stop stays set.

    Attributes
    ----------
    happened : bool
        Whether another simulator has crashed before this one.
    resets : int
        Resets until now; to others a crash is one.
    """

    def __init__(self, memory: RunMemory) -> None:
        self._memory = memory
        self._noted: Any = (0, False, -1, [])
        # Namespaces of further robots that were stopped, and have not come again.
        self._stopped: Set[str] = set()
        self.happened = False
        self.resets = 0

    def restore(self, simulation: Simulation) -> None:
        """Go on after the simulator before, if that crashed; the simulation has not begun yet."""
        left = self._memory.recall()
        steps, resets = left.get("steps"), left.get("resets")
        if not (isinstance(steps, int) and isinstance(resets, int)):
            return
        self.happened = True
        self.resets = resets + 1
        # A whole second later than what was kept: nothing that was said before the crash has a
        # later stamp, and all rates keep the places that they have after a first start.
        per_second = round(1.0 / simulation.config.timing.step_size)
        simulation.steps = (steps // per_second + 2) * per_second
        if left.get("e_stop") is True:
            simulation.request_e_stop(True)
        stopped = left.get("stopped")
        if isinstance(stopped, list):
            self._stopped = {name for name in stopped if isinstance(name, str)}

    def was_stopped(self, namespace: str) -> bool:
        """Whether a further robot that comes again was stopped before the crash."""
        if namespace not in self._stopped:
            return False
        self._stopped.discard(namespace)
        return True

    def keep_stopped(self, namespace: str) -> None:
        """Have a further robot that was stopped, and could not stay, be so when it comes again."""
        self._stopped.add(namespace)

    def note(self, simulation: Simulation, resets: int) -> None:
        """Keep the present state, where it is not that of just now; to be called often."""
        first, *others = simulation.robots
        e_stop = first.e_stop_wanted
        stopped = {robot.namespace for robot in others if robot.e_stop_wanted} | self._stopped
        now = [e_stop, resets, sorted(stopped)]
        steps, *rest = self._noted
        # The clock goes on a whole second later at least than what is kept.
        soon = 0 <= simulation.steps - steps < round(0.5 / simulation.config.timing.step_size)
        if soon and rest == now:
            return
        self._noted = (simulation.steps, *now)
        self._memory.keep(steps=simulation.steps, e_stop=e_stop, resets=resets, stopped=now[2])

    def forget(self) -> None:
        """Leave nothing: the simulator ends in order."""
        self._memory.forget()
