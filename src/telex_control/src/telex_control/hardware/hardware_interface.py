"""The interface between controllers and a robot: handles, interfaces, claims and `RobotHW`.

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

from ..common.stateful import Stateful
from ..ros.node_handle import NodeHandle

__all__ = [
    "ControllerInfo",
    "EffortJointInterface",
    "ForceTorqueSensorHandle",
    "ForceTorqueSensorInterface",
    "HardwareInterface",
    "HardwareInterfaceError",
    "ImuSensorHandle",
    "ImuSensorInterface",
    "InterfaceResources",
    "JointCommandInterface",
    "JointHandle",
    "JointStateHandle",
    "JointStateInterface",
    "NamedHandle",
    "PositionJointInterface",
    "ResourceManager",
    "RobotHW",
    "SwitchState",
    "VelocityJointInterface",
]

_log = logging.getLogger("rosout")


class HardwareInterfaceError(Exception):
    """A resource or interface that was asked for does not exist."""


class NamedHandle(Stateful):
    """Anything that is registered under a name."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name


class JointStateHandle(NamedHandle):
    """Measured state of one joint.

    Attributes
    ----------
    position, velocity, effort : float
        Written by the robot in `RobotHW.read`.
    """

    __slots__ = ("effort", "position", "velocity")
    SAVED = __slots__

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.position = 0.0
        self.velocity = 0.0
        self.effort = 0.0


class JointHandle(NamedHandle):
    """Command of one joint, beside its measured state.

    Attributes
    ----------
    command : float
        Effort, velocity or position, as the interface that holds the handle says.
    """

    __slots__ = ("command", "state")
    SAVED = ("command",)

    def __init__(self, state: JointStateHandle) -> None:
        super().__init__(state.name)
        self.state = state
        self.command = 0.0


class ImuSensorHandle(NamedHandle):
    """What an inertial sensor measures, in the axes of `frame_id`.

    A quantity that the sensor does not measure is None. Covariances are row-major 3 x 3, and None
    where they are not known.

    Attributes
    ----------
    orientation : tuple of 4 floats or None
        Quaternion (x, y, z, w) from the world to the sensor.
    angular_velocity : tuple of 3 floats or None
        (rad/s)
    linear_acceleration : tuple of 3 floats or None
        Proper acceleration (m/s^2): at rest it points up.
    orientation_covariance : tuple of 9 floats or None
        (rad^2)
    angular_velocity_covariance : tuple of 9 floats or None
        (rad^2/s^2)
    linear_acceleration_covariance : tuple of 9 floats or None
        (m^2/s^4)
    """

    __slots__ = (
        "angular_velocity",
        "angular_velocity_covariance",
        "frame_id",
        "linear_acceleration",
        "linear_acceleration_covariance",
        "orientation",
        "orientation_covariance",
    )
    SAVED = (
        "angular_velocity",
        "angular_velocity_covariance",
        "linear_acceleration",
        "linear_acceleration_covariance",
        "orientation",
        "orientation_covariance",
    )

    def __init__(self, name: str, frame_id: str) -> None:
        super().__init__(name)
        self.frame_id = frame_id
        self.orientation: Optional[Tuple[float, float, float, float]] = None
        self.angular_velocity: Optional[Tuple[float, float, float]] = None
        self.linear_acceleration: Optional[Tuple[float, float, float]] = None
        self.orientation_covariance: Optional[Tuple[float, ...]] = None
        self.angular_velocity_covariance: Optional[Tuple[float, ...]] = None
        self.linear_acceleration_covariance: Optional[Tuple[float, ...]] = None


class ForceTorqueSensorHandle(NamedHandle):
    """What a force-torque sensor measures, in the axes of `frame_id`.

    Attributes
    ----------
    force : tuple of 3 floats or None
        (N); None when the sensor does not measure it.
    torque : tuple of 3 floats or None
        (Nm)
    """

    __slots__ = ("force", "frame_id", "torque")

    def __init__(self, name: str, frame_id: str) -> None:
        super().__init__(name)
        self.frame_id = frame_id
        self.force: Optional[Tuple[float, float, float]] = None
        self.torque: Optional[Tuple[float, float, float]] = None


Handle = TypeVar("Handle", bound=NamedHandle)


class ResourceManager(Generic[Handle]):
    """A set of handles of one kind.

    Attributes
    ----------
    type_name : str
        Name of the kind in messages and URDF transmissions, as C++ spells it.
    """

    type_name = ""

    def __init__(self) -> None:
        self._handles: Dict[str, Handle] = {}

    def register_handle(self, handle: Handle) -> None:
        """Add a handle; one of the same name is replaced, with a warning."""
        if handle.name in self._handles:
            _log.warning(
                "Replacing previously registered handle '%s' in '%s'.", handle.name, self.type_name
            )
        self._handles[handle.name] = handle

    def get_handle(self, name: str) -> Handle:
        """Return the handle called `name`.

        Raises
        ------
        HardwareInterfaceError
            No such handle.
        """
        try:
            return self._handles[name]
        except KeyError:
            raise HardwareInterfaceError(
                f"Could not find resource '{name}' in '{self.type_name}'. "
                f"It has: {', '.join(self.names()) or 'nothing'}"
            ) from None

    def names(self) -> List[str]:
        """Names of all handles, sorted."""
        return sorted(self._handles)


class HardwareInterface(ResourceManager[Handle]):
    """A set of handles that a robot offers to controllers.

    A robot's own interface derives from this; it is asked for, and named in messages, by its class.

    Attributes
    ----------
    claims_resources : bool
        Whether taking a handle claims its joint for the taker alone.
    """

    claims_resources = False

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "type_name" not in cls.__dict__:
            cls.type_name = f"{cls.__module__}.{cls.__qualname__}".replace(".", "::")

    def __init__(self) -> None:
        super().__init__()
        self._claims: Set[str] = set()

    def get_handle(self, name: str) -> Handle:
        """Return the handle called `name`, and claim it if this interface claims.

        Raises
        ------
        HardwareInterfaceError
            No such handle.
        """
        handle = super().get_handle(name)
        if self.claims_resources:
            self._claims.add(name)
        return handle

    def take_claims(self) -> Set[str]:
        """Return what was claimed since the last call, and forget it."""
        claims, self._claims = self._claims, set()
        return claims


class JointStateInterface(HardwareInterface[JointStateHandle]):
    """Measured joint states; read only, so nothing is claimed."""

    type_name = "hardware_interface::JointStateInterface"


class JointCommandInterface(HardwareInterface[JointHandle]):
    """Joints that can be commanded, each by one controller at a time."""

    type_name = "hardware_interface::JointCommandInterface"
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


class ImuSensorInterface(HardwareInterface[ImuSensorHandle]):
    """Inertial sensors; nothing is claimed."""

    type_name = "hardware_interface::ImuSensorInterface"


class ForceTorqueSensorInterface(HardwareInterface[ForceTorqueSensorHandle]):
    """Force-torque sensors; nothing is claimed."""

    type_name = "hardware_interface::ForceTorqueSensorInterface"


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

    def init(self, root: NodeHandle, hw: NodeHandle) -> None:
        """Set the robot up. Called once, by whoever runs the control loop, before its first cycle.

        Parameters
        ----------
        root : NodeHandle
            The robot's namespace, for ``robot_description`` and ``joint_limits``.
        hw : NodeHandle
            The namespace of the robot's own parameters.

        Raises
        ------
        Exception
            The robot cannot be used; the message says why.
        """

    def register_interface(self, interface: HardwareInterface) -> None:
        """Offer `interface` to controllers; one of the same class is replaced, with a warning."""
        if type(interface) in self._interfaces:
            _log.warning("Replacing previously registered interface '%s'.", interface.type_name)
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
                f"This controller requires a hardware interface of type '{kind.type_name}'. Make "
                "sure this is registered in the hardware_interface::RobotHW class. It has: "
                + (", ".join(i.type_name for i in self.interfaces()) or "nothing")
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
