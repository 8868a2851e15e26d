"""Commands of an operator as a vector of numbers: actions of the environment and of data sets."""

from __future__ import annotations

import math
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

from telex_teleop.arm.arm_settings import carrier_of
from telex_teleop.joints.joint_settings import limits_of_present

from ..operators.port import Command, Drive, Jog, ToolTwist
from ..rehearsal.node_settings import ARM, FLIPPERS, GRIPPER, TRACKS, shipped_settings

DRIVE_PART, ARM_PART, TOOL_PART = "drive", "arm", "tool"
FLIPPERS_PART, GRIPPER_PART = "flippers", "gripper"
PARTS = (DRIVE_PART, ARM_PART, TOOL_PART, FLIPPERS_PART, GRIPPER_PART)
USUAL = (DRIVE_PART, ARM_PART, FLIPPERS_PART, GRIPPER_PART)
_NODES = {
    DRIVE_PART: TRACKS,
    ARM_PART: ARM,
    TOOL_PART: ARM,
    FLIPPERS_PART: FLIPPERS,
    GRIPPER_PART: GRIPPER,
}
_TOOL_AXES = ("x", "y", "z", "roll", "pitch", "yaw")


class Rate(NamedTuple):
    """A number of the vector.

    Attributes
    ----------
    part : str
        One of `PARTS`.
    most : float
        Magnitude at full speed (m/s, rad/s).
    key : str
        Name of what is jogged; empty in parts without joints.
    measured_by : tuple of str
        Joints whose mean rate it is; none: no joint tells.
    """

    part: str
    name: str
    most: float
    key: str = ""
    measured_by: Tuple[str, ...] = ()


class CommandVector:
    """What the teleoperation nodes of a robot take, in a fixed order.

    Parameters
    ----------
    parts : sequence of str
        Those of `PARTS` that the vector has, in the order there; what the robot lacks is left out.

    Attributes
    ----------
    joints : tuple of str
        All joints of the teleoperation nodes, whatever the parts.

    Raises
    ------
    ValueError
        There is no such part, or the arm is to be led in two ways.
    """

    def __init__(self, urdf: str, parts: Sequence[str] = USUAL) -> None:
        for part in parts:
            if part not in PARTS:
                raise ValueError(f"parts has '{part}'; there are: {', '.join(PARTS)}")
        if ARM_PART in parts and TOOL_PART in parts:
            raise ValueError(
                f"parts has '{ARM_PART}' and '{TOOL_PART}'; the arm obeys one of them at a time"
            )
        known, self.joints = _rates(urdf)
        self.rates = tuple(rate for part in PARTS if part in parts for rate in known[part])
        self.names = tuple(rate.name for rate in self.rates)
        self.most = np.array([rate.most for rate in self.rates])
        self.tool = TOOL_PART in parts
        if not self.rates:
            raise ValueError(f"parts is {list(parts)}; this robot has none of them")

    def commands(self, values: np.ndarray, moving: Sequence[str] = ()) -> List[Command]:
        """Return the commands for a vector: those of parts that move, and of those that did.

        Parameters
        ----------
        moving : sequence of str
            Parts that moved before, which are told to stop.
        """
        given: Dict[str, List[Tuple[Rate, float]]] = {}
        for rate, value in zip(self.rates, values.tolist()):
            given.setdefault(rate.part, []).append((rate, value))
        return [
            _command(part, numbers)
            for part, numbers in given.items()
            if part in moving or any(value for _, value in numbers)
        ]

    def moving(self, values: np.ndarray) -> Tuple[str, ...]:
        """Return the parts of which a number is not 0."""
        return tuple({rate.part: None for rate, value in zip(self.rates, values.tolist()) if value})


def _command(part: str, numbers: List[Tuple[Rate, float]]) -> Command:
    values = [value for _, value in numbers]
    if part == DRIVE_PART:
        return Drive(values[0], values[1])
    if part == TOOL_PART:
        return ToolTwist((values[0], values[1], values[2]), (values[3], values[4], values[5]))
    return Jog(_NODES[part], {rate.key: value for rate, value in numbers})


def node_of(part: str) -> str:
    """Return the teleoperation node that moves a part."""
    return _NODES[part]


def _rates(urdf: str) -> Tuple[Dict[str, List[Rate]], Tuple[str, ...]]:
    """Return all numbers of a robot by part, and its joints."""
    settings = shipped_settings()
    tracks, cartesian = settings.tracks, settings.arm.cartesian
    found: Dict[str, List[Rate]] = {
        DRIVE_PART: [
            Rate(DRIVE_PART, "drive.linear", tracks.max_linear),
            Rate(DRIVE_PART, "drive.angular", tracks.max_angular),
        ]
    }
    joints: List[str] = []
    for part, node in ((ARM_PART, settings.arm), (FLIPPERS_PART, settings.flippers)):
        axes = node.axes(limits_of_present(node, urdf)[0])
        joints += axes
        found[part] = [
            Rate(part, f"{joint[: -len('_joint')]}.rate", axis.motion.max_velocity, joint, (joint,))
            for joint, axis in axes.items()
        ]
    arm = settings.arm.axes(limits_of_present(settings.arm, urdf)[0])
    chain, _, _ = carrier_of(settings.arm, urdf, arm)
    found[TOOL_PART] = [
        Rate(TOOL_PART, f"tool.{axis}", cartesian.max_linear if i < 3 else cartesian.max_angular)
        for i, axis in enumerate(_TOOL_AXES)
        if chain is not None
    ]
    fingers = settings.gripper.axes(limits_of_present(settings.gripper, urdf)[0])
    joints += fingers
    group, found[GRIPPER_PART] = settings.gripper.coupling, []
    if fingers:
        axis = settings.gripper.axis(group.name, group.limits(fingers))
        most, by = axis.motion.max_velocity, tuple(group.measured_by)
        found[GRIPPER_PART] = [Rate(GRIPPER_PART, "gripper.rate", most, group.name, by)]
    return found, tuple(joints)


def state_names(joints: Sequence[str]) -> Tuple[str, ...]:
    """Names of the numbers of a state: pose of the base in the world (m), joints (rad, m)."""
    return (*pose_names("base"), *joints)


def pose_names(name: str) -> Tuple[str, ...]:
    """Names of the numbers of a pose: position, and a quaternion x, y, z, w."""
    return tuple(f"{name}.{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw"))


def checked(values: object, names: Sequence[str]) -> np.ndarray:
    """Return a vector that somebody gave, as an array.

    Raises
    ------
    ValueError
        It is no vector of as many finite numbers as there are names.
    """
    try:
        made = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(
            f"action is {values!r:.60}; an array of {len(names)} numbers is needed"
        ) from None
    if made.shape != (len(names),):
        raise ValueError(f"action has the shape {made.shape}; ({len(names)},) is needed")
    for name, value in zip(names, made.tolist()):
        if not math.isfinite(value):
            raise ValueError(f"action: {name} is {value}; a finite number is needed")
    return made
