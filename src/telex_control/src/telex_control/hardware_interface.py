"""What stands between controllers and a robot: joint handles, interfaces, claims and `RobotHW`.

The names and semantics are those of ros_control's ``hardware_interface``. Where C++ hands out
pointers into memory that the robot owns, the handles here are that memory: a robot writes
``state.position``, a controller reads it, and the other way round for ``command``. All units are
SI (rad, rad/s, Nm; m, m/s, N for prismatic joints).

Threads: handles are used by the control loop only. Interfaces are looked up, and claims gathered,
while a controller is initialised, which happens outside the loop.
"""

from __future__ import annotations

import enum
import logging
from typing import Dict, Generic, Iterable, List, Optional, Set, Tuple, Type, TypeVar

Handle = TypeVar("Handle", bound="_NamedHandle")
_log = logging.getLogger("rosout")


class HardwareInterfaceError(Exception):
    """A resource or interface that was asked for does not exist."""


class _NamedHandle:
    """Anything that is registered under a name."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name


class JointStateHandle(_NamedHandle):
    """Measured state of one joint.

    Attributes
    ----------
    position, velocity, effort : float
        Written by the robot in `RobotHW.read`.
    """

    __slots__ = ("effort", "position", "velocity")

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.position = 0.0
        self.velocity = 0.0
        self.effort = 0.0


class JointHandle(_NamedHandle):
    """Command of one joint, beside its measured state.

    Attributes
    ----------
    state : JointStateHandle
    command : float
        Effort, velocity or position, as the interface that holds the handle says.
    """

    __slots__ = ("command", "state")

    def __init__(self, state: JointStateHandle) -> None:
        super().__init__(state.name)
        self.state = state
        self.command = 0.0


class HardwareInterface(Generic[Handle]):
    """A set of handles of one kind.

    Attributes
    ----------
    type_name : str
        Name of the interface in messages and URDF transmissions, as C++ spells it.
    claims_resources : bool
        Whether taking a handle claims its joint for the taker alone.
    """

    type_name = ""
    claims_resources = False

    def __init__(self) -> None:
        self._handles: Dict[str, Handle] = {}
        self._claims: Set[str] = set()

    def register_handle(self, handle: Handle) -> None:
        """Add a handle; one of the same name is replaced, with a warning."""
        if handle.name in self._handles:
            _log.warning(
                "Replacing previously registered handle '%s' in '%s'", handle.name, self.type_name
            )
        self._handles[handle.name] = handle

    def get_handle(self, name: str) -> Handle:
        """Return the handle called `name`, and claim it if this interface claims.

        Raises
        ------
        HardwareInterfaceError
            No such handle.
        """
        try:
            handle = self._handles[name]
        except KeyError:
            raise HardwareInterfaceError(
                f"Could not find resource '{name}' in '{self.type_name}'; "
                f"it has: {', '.join(self.names()) or 'nothing'}"
            ) from None
        if self.claims_resources:
            self._claims.add(name)
        return handle

    def names(self) -> List[str]:
        """Names of all handles, sorted."""
        return sorted(self._handles)

    def take_claims(self) -> Set[str]:
        """Return what was claimed since the last call, and forget it."""
        claims, self._claims = self._claims, set()
        return claims


class JointStateInterface(HardwareInterface[JointStateHandle]):
    """Measured joint states; read only, so nothing is claimed."""

    type_name = "hardware_interface::JointStateInterface"


class JointCommandInterface(HardwareInterface[JointHandle]):
    """Joints that can be commanded, each by one controller at a time."""

    claims_resources = True


class EffortJointInterface(JointCommandInterface):
    """Joints commanded by effort (Nm, N)."""

    type_name = "hardware_interface::EffortJointInterface"


class VelocityJointInterface(JointCommandInterface):
    """Joints commanded by velocity (rad/s, m/s)."""

    type_name = "hardware_interface::VelocityJointInterface"


class PositionJointInterface(JointCommandInterface):
    """Joints commanded by position (rad, m)."""

    type_name = "hardware_interface::PositionJointInterface"


class InterfaceResources:
    """The joints that a controller has claimed through one interface."""

    __slots__ = ("hardware_interface", "resources")

    def __init__(self, hardware_interface: str, resources: Iterable[str]) -> None:
        self.hardware_interface = hardware_interface
        self.resources: Tuple[str, ...] = tuple(sorted(resources))


class ControllerInfo:
    """What a robot is told of a controller: its name, type and claims."""

    __slots__ = ("claimed_resources", "name", "type")

    def __init__(
        self, name: str, type_name: str, claimed_resources: Tuple[InterfaceResources, ...]
    ) -> None:
        self.name = name
        self.type = type_name
        self.claimed_resources = claimed_resources


class SwitchState(enum.Enum):
    """How far the hardware is with a switch of controllers."""

    DONE = enum.auto()
    ONGOING = enum.auto()
    ERROR = enum.auto()


Interface = TypeVar("Interface", bound=HardwareInterface)


class RobotHW:
    """A robot, as the controller manager sees it.

    A subclass registers its interfaces, and implements `read` and `write`. The control loop is
    ``read(time, period); controller_manager.update(time, period); write(time, period)``, in one
    thread.
    """

    def __init__(self) -> None:
        self._interfaces: Dict[Type[HardwareInterface], HardwareInterface] = {}
        self._used: Dict[HardwareInterface, None] = {}

    def register_interface(self, interface: HardwareInterface) -> None:
        """Offer `interface` to controllers."""
        self._interfaces[type(interface)] = interface

    def get(self, kind: Type[Interface]) -> Interface:
        """Return the interface of class `kind`.

        Raises
        ------
        HardwareInterfaceError
            This robot does not have it.
        """
        interface = self._interfaces.get(kind)
        if interface is None:
            raise HardwareInterfaceError(
                f"This controller requires a hardware interface of type '{kind.type_name}', "
                "which this robot does not have; it has: "
                + ", ".join(i.type_name for i in self.interfaces())
            )
        self._used[interface] = None
        return interface  # type: ignore[return-value]

    def take_claims(self) -> Tuple[InterfaceResources, ...]:
        """Return what was claimed since the last call, and forget it.

        There is one element for every interface that was asked for, also when nothing of it was
        claimed.
        """
        used, self._used = self._used, {}
        return tuple(InterfaceResources(each.type_name, each.take_claims()) for each in used)

    def interfaces(self) -> List[HardwareInterface]:
        """All interfaces, in the order of their registration."""
        return list(self._interfaces.values())

    def read(self, time: float, period: float) -> None:
        """Fill the state handles. `time` and `period` in s."""
        raise NotImplementedError

    def write(self, time: float, period: float) -> None:
        """Carry out the commands of the joint handles. `time` and `period` in s."""
        raise NotImplementedError

    def check_for_conflict(self, controllers: Iterable[ControllerInfo]) -> Optional[str]:
        """Tell whether two claims of `controllers` exclude each other.

        A joint belongs to one claim at a time, through whatever interface; a controller that
        claims a joint through two interfaces is in conflict with itself.

        Returns
        -------
        str or None
            What the conflict is, or None.
        """
        owners: Dict[str, str] = {}
        for controller in controllers:
            for claim in controller.claimed_resources:
                for resource in claim.resources:
                    if resource in owners:
                        return (
                            f"Resource conflict on [{resource}]: "
                            f"'{owners[resource]}' and '{controller.name}' both claim it"
                        )
                    owners[resource] = controller.name
        return None

    def prepare_switch(
        self, start: List[ControllerInfo], stop: List[ControllerInfo]
    ) -> Optional[str]:
        """Say why this switch of controllers is impossible, or None. Not in the control loop."""
        return None

    def do_switch(self, start: List[ControllerInfo], stop: List[ControllerInfo]) -> None:
        """Begin to switch the hardware. Called in the control loop."""

    def switch_result(self, controller: Optional[ControllerInfo] = None) -> SwitchState:
        """How far the hardware is with the last switch, as a whole or for one controller."""
        return SwitchState.DONE
