"""All that a scripted operator sees of a robot, and all that it can tell it.

Observations come in and commands go out as plain values, so that an operator runs unchanged by
topics on a live robot, and in one process with a simulation. Names are those of the robot's links
and joints; units are m, rad, s and N. Quaternions are x, y, z, w.
"""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass, field, fields
from typing import Callable, Mapping, Optional, Tuple, Union

import numpy as np

ARM_MODES = ("JOINT", "CARTESIAN")
"""What `TeleopPort.set_mode` takes."""


class NotManagedError(Exception):
    """The robot did not do what the script is for; the message says what happened instead."""


# --- observations --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Placement:
    """Position (m) and orientation (quaternion x, y, z, w) in the world."""

    position: Tuple[float, float, float]
    orientation: Tuple[float, float, float, float]


@dataclass(frozen=True)
class Grip:
    """What the gripper's pads hold.

    Attributes
    ----------
    object : str
        Its name; empty: nothing.
    force : float
        With which they hold it (N).
    """

    object: str = ""
    force: float = 0.0


@dataclass(frozen=True)
class Notice:
    """What a teleoperation node says.

    Attributes
    ----------
    number : int
        Of the node's status, each larger than the one before.
    text : str
        Why commands are not obeyed, or else what there is to know; empty: nothing.
    """

    number: int
    text: str


@dataclass(frozen=True)
class Observation:
    """The robot at one moment, as far as anything is known of it.

    Attributes
    ----------
    time : float
        Sim time (s); negative: nothing has been seen yet.
    base : Placement, optional
        Of base_link.
    positions, velocities : mapping of str to float
        Of the joints, by their full names (rad, m; rad/s, m/s).
    notices : mapping of str to Notice
        The last of each teleoperation node, such as ``arm_teleop``.
    """

    time: float = -1.0
    base: Optional[Placement] = None
    positions: Mapping[str, float] = field(default_factory=dict)
    velocities: Mapping[str, float] = field(default_factory=dict)
    grip: Grip = field(default_factory=Grip)
    notices: Mapping[str, Notice] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class CameraPicture:
    """A camera's picture.

    Attributes
    ----------
    time : float
        Sim time at which it was taken (s).
    data : bytes
        JPEG or PNG.
    matrix : ndarray, shape (3, 3)
        K of the camera's CameraInfo.
    distortion : ndarray, shape (5,)
        D of it.
    """

    time: float
    data: bytes
    matrix: np.ndarray
    distortion: np.ndarray


# --- commands ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Finite:
    """Refuses numbers that are not finite.

    Raises
    ------
    ValueError
        On creation; the message names the field.
    """

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            values = value.values() if isinstance(value, Mapping) else np.ravel(value)
            for number in values:
                if not isinstance(number, str) and not math.isfinite(number):
                    raise ValueError(
                        f"{each.name} of {type(self).__name__} is {value!r}; finite numbers are "
                        "needed"
                    )


@dataclass(frozen=True)
class Drive(_Finite):
    """Velocity of the base: forward (m/s), and turning to the left (rad/s)."""

    linear: float = 0.0
    angular: float = 0.0


@dataclass(frozen=True)
class JointTargets(_Finite):
    """References of joints' position controllers, by the joints' full names (rad, m)."""

    positions: Mapping[str, float]


@dataclass(frozen=True)
class Jog(_Finite):
    """Rates of joints of a teleoperation node.

    Attributes
    ----------
    node : str
        ``arm_teleop``, ``flipper_teleop`` or ``gripper_teleop``.
    rates : mapping of str to float
        By the joints' full names, or ``gripper`` for all fingers (rad/s, m/s).
    """

    node: str
    rates: Mapping[str, float]


@dataclass(frozen=True)
class FlipperPreset:
    """A flipper preset's key; empty: none."""

    name: str


@dataclass(frozen=True)
class NamedPose:
    """Lead the arm's joints to a named pose; empty: none."""

    name: str


@dataclass(frozen=True, eq=False)
class ToolPose(_Finite):
    """Lead the tool on a straight line.

    Attributes
    ----------
    target : ndarray, shape (4, 4)
    frame : str
        That the target is given in: ``base_link``, ``world``, or ``tool_link`` as it stood when
        the command began.
    """

    target: np.ndarray
    frame: str = "base_link"


@dataclass(frozen=True)
class ToolTwist(_Finite):
    """Velocity of the tool (m/s, rad/s) along the axes of a frame of `ToolPose`."""

    linear: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame: str = "tool_link"


Command = Union[Drive, JointTargets, Jog, FlipperPreset, NamedPose, ToolPose, ToolTwist]
"""All but `JointTargets` hold for a moment only, as a key does, and are to be repeated."""


# --- ports ---------------------------------------------------------------------------------------


class Port(abc.ABC):
    """How an operator's program reaches a robot."""

    @abc.abstractmethod
    def observe(self) -> Observation:
        """Return what is known of the robot now."""

    @abc.abstractmethod
    def advance(self, seconds: float) -> None:
        """Let so much sim time (s) pass, and return once it can be observed.

        Raises
        ------
        NotManagedError
            Nothing is heard of the robot.
        """

    @abc.abstractmethod
    def send(self, command: Command) -> None:
        """Give a command.

        Raises
        ------
        TypeError
            It is none that this port takes.
        """


class CameraView(abc.ABC):
    """Pictures of one camera; close it when done, for they are drawn only while it is open."""

    @abc.abstractmethod
    def picture(self) -> Optional[CameraPicture]:
        """Return the newest picture, None before the first."""

    @abc.abstractmethod
    def close(self) -> None:
        """Look away."""


class TeleopPort(Port):
    """A robot behind its teleoperation nodes, as a person at a console has it.

    It takes all commands but `JointTargets`.

    Attributes
    ----------
    urdf : str
        The robot's description.
    repeat : callable
        Sends again what is held. A live robot's port calls it while sim time passes slowly, for
        the watchdogs look at the wall's clock as well; a station sets it.
    """

    urdf: str

    def __init__(self) -> None:
        self.repeat: Callable[[], None] = _nothing

    @abc.abstractmethod
    def set_mode(self, name: str) -> None:
        """Set the arm's mode, one of `ARM_MODES`.

        Raises
        ------
        NotManagedError
            The node refuses, or is not there.
        """

    @abc.abstractmethod
    def e_stop(self, active: bool) -> None:
        """Set or release the emergency stop."""

    @abc.abstractmethod
    def zoom(self, camera: str, factor: float) -> None:
        """Set a camera's zoom factor.

        Raises
        ------
        NotManagedError
            There is no such camera.
        """

    @abc.abstractmethod
    def camera(self, name: str) -> CameraView:
        """Begin to look through a camera, e.g. ``gripper``.

        Raises
        ------
        NotManagedError
            There is no such camera.
        """

    @abc.abstractmethod
    def object_pose(self, name: str) -> Optional[np.ndarray]:
        """True pose of an object's first link in the world, 4x4; None where it is not known.

        Another link is named as "object/link".

        No person at a console sees that: it is for operators that stand for somebody beside the
        robot, and for judging.
        """

    @abc.abstractmethod
    def answer(self, question: str, answer: str) -> None:
        """Answer a question of the exercise.

        Raises
        ------
        NotManagedError
            Nobody asks it.
        """


def _nothing() -> None:
    pass
