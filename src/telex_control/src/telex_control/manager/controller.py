"""The base class of controllers, and their life cycle."""

from __future__ import annotations

import enum
from typing import FrozenSet, Optional

from ..common.stateful import Stateful
from ..hardware.hardware_interface import ControllerInfo, RobotHW
from ..ros.node_handle import NodeHandle

__all__ = ["Controller", "ControllerInitError", "ControllerState", "LoadedController"]


class ControllerState(enum.Enum):
    """Where a controller is in its life; the values are those of ``list_controllers``."""

    CONSTRUCTED = "unknown"
    INITIALIZED = "initialized"
    RUNNING = "running"
    STOPPED = "stopped"
    WAITING = "waiting"
    ABORTED = "aborted"


class ControllerInitError(Exception):
    """A controller cannot be initialised; the message says why, for a person."""


class Controller(Stateful):
    """A controller. A user's own class derives from this and is named by its Python path.

    `init` runs outside the control loop and may take its time. `starting`, `update` and
    `stopping` run inside it: they neither block nor allocate without need. Callbacks of
    subscriptions run in other threads and only store one value, by assignment.

    What it remembers from cycle to cycle it declares as a `Stateful` part does, so that a bookmark
    of the simulation can bring it back. One that declares nothing is stopped and started then.

    Attributes
    ----------
    parameters : frozenset of str or None
        Names of the parameters that the controller reads, beside ``type``. Others in its
        namespace are named in a warning, since they may be misspelt; they are not refused,
        because upstream's controllers know more. None checks nothing.
    """

    parameters: Optional[FrozenSet[str]] = None

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Read the parameters, take the joint handles (which claims them) and open topics.

        Parameters
        ----------
        root : NodeHandle
            The robot's namespace, for ``robot_description``.
        node : NodeHandle
            The controller's own namespace.

        Raises
        ------
        ControllerInitError, ConfigError, HardwareInterfaceError
            With a message that names what is wrong.
        """
        raise NotImplementedError

    def starting(self, time: float) -> None:
        """Take over at `time` (s), without a jump: hold what is measured."""

    def update(self, time: float, period: float) -> None:
        """Compute the commands for the cycle at `time`, `period` after the last (s)."""
        raise NotImplementedError

    def stopping(self, time: float) -> None:
        """Give up the joints at `time` (s)."""

    def reset(self, time: float) -> None:
        """Begin anew at `time` (s): the robot was put back to where it started.

        Called inside the control loop while the controller runs.
        """
        self.stopping(time)
        self.starting(time)

    def interrupt(self, time: float) -> None:
        """Forget at `time` (s) what was commanded: nobody saw the robot meanwhile.

        Called inside the control loop while the controller runs. Unlike `reset`, the robot is where
        it was, and may move: one that must not stop at once overrides this.
        """
        self.stopping(time)
        self.starting(time)


class LoadedController:
    """A controller, with what the controller manager knows of it."""

    __slots__ = ("controller", "failed", "info", "node", "state")

    def __init__(self, name: str, type_name: str, controller: Controller, node: NodeHandle) -> None:
        self.controller = controller
        self.node = node
        self.state = ControllerState.CONSTRUCTED
        # It raised while it ran: stopped by the manager, not by somebody's wish.
        self.failed = False
        self.info = ControllerInfo(name, type_name, ())

    @property
    def name(self) -> str:
        """Name of the controller."""
        return self.info.name

    def init(self, hw: RobotHW, root: NodeHandle) -> None:
        """Initialise the controller and keep what it claims.

        Raises
        ------
        ControllerInitError
            Its init returned False, as one that is written after C++ may do.
        Exception
            Whatever the controller raises.
        """
        hw.take_claims()  # of a controller whose init failed
        result: object = self.controller.init(hw, root, self.node)  # type: ignore[func-returns-value]
        if result is False:
            raise ControllerInitError("its init returned False")
        self.info = ControllerInfo(self.info.name, self.info.type, hw.take_claims())
        self.state = ControllerState.INITIALIZED

    def start(self, time: float) -> None:
        """Start the controller from any state."""
        self.failed = False
        self.controller.starting(time)
        self.state = ControllerState.RUNNING

    def stop(self, time: float) -> None:
        """Stop the controller if it is running."""
        if self.state is ControllerState.RUNNING:
            # Stopped first: whatever stopping() does, update() is not called again.
            self.state = ControllerState.STOPPED
            self.controller.stopping(time)
