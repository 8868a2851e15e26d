"""Validation of commands to the tool, free of ROS types."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Dict, Sequence, Union

import numpy as np

from telex_control.common.plausible import LARGEST_POSITION, LARGEST_SPEED
from telex_control.kinematics import KinematicsError, make_pose
from telex_teleop.motion.joint_jog import InvalidCommand, require_number


class Frame(Enum):
    """Along whose axes a command is meant."""

    TOOL = "tool"
    BASE = "base"
    WORLD = "world"


@dataclass(frozen=True)
class TwistCommand:
    """Velocity of the tool centre point.

    Attributes
    ----------
    frame
        Its axes.
    velocity : ndarray, shape (6,)
        Linear (m/s) and angular (rad/s) velocity.
    """

    frame: Frame
    velocity: np.ndarray

    @property
    def moves(self) -> bool:
        """Whether it asks for motion."""
        return bool(self.velocity.any())


@dataclass(frozen=True)
class PoseCommand:
    """Pose that the tool shall go to.

    Attributes
    ----------
    frame
        What it is measured in; the tool's frame is where the tool stood when the stream began.
    pose : ndarray, shape (4, 4)
    """

    frame: Frame
    pose: np.ndarray


ToolCommand = Union[TwistCommand, PoseCommand]


class FrameNames:
    """Frames by the names that messages have for them.

    Parameters
    ----------
    tool, base, world
        Their names, all different.
    default
        One of them: what an empty ``frame_id`` stands for.
    """

    def __init__(self, tool: str, base: str, world: str, default: str) -> None:
        self._frames: Dict[str, Frame] = {tool: Frame.TOOL, base: Frame.BASE, world: Frame.WORLD}
        self.default = default

    @property
    def names(self) -> Sequence[str]:
        """All of them."""
        return tuple(self._frames)

    def find(self, frame_id: str) -> Frame:
        """Return the frame of a message.

        Raises
        ------
        InvalidCommand
            When it is none of ours.
        """
        name = frame_id.lstrip("/") or self.default
        frame = self._frames.get(name)
        if frame is None:
            raise InvalidCommand(
                f"header.frame_id is {frame_id!r}; must be {', '.join(self._frames)}, or empty for "
                f"{self.default}"
            )
        return frame

    def twist(
        self, frame_id: str, linear: Sequence[float], angular: Sequence[float]
    ) -> TwistCommand:
        """Check the fields of a TwistStamped.

        Raises
        ------
        InvalidCommand
            When the frame is unknown, or a number is not finite.
        """
        frame = self.find(frame_id)
        _require_numbers("twist.linear", linear, LARGEST_SPEED)
        _require_numbers("twist.angular", angular, LARGEST_SPEED)
        return TwistCommand(frame, np.array([*linear, *angular], dtype=float))

    def pose(
        self, frame_id: str, position: Sequence[float], orientation: Sequence[float]
    ) -> PoseCommand:
        """Check the fields of a PoseStamped; the quaternion is x, y, z, w.

        Raises
        ------
        InvalidCommand
            When the frame is unknown, a number is not finite, or the quaternion is not normalised.
        """
        frame = self.find(frame_id)
        return PoseCommand(frame, pose_matrix(position, orientation))


def pose_matrix(position: Sequence[float], orientation: Sequence[float]) -> np.ndarray:
    """Return the 4x4 matrix of the fields of a Pose; the quaternion is x, y, z, w.

    Raises
    ------
    InvalidCommand
        When a number is not finite, or the quaternion is not normalised.
    """
    _require_numbers("pose.position", position, LARGEST_POSITION)
    _require_numbers("pose.orientation", orientation, LARGEST_POSITION)
    try:
        return make_pose(position, orientation)
    except KinematicsError as error:
        raise InvalidCommand(f"pose: {error}; 0 0 0 1 is no rotation") from None


def _require_numbers(field: str, values: Sequence[float], largest: float) -> None:
    for axis, value in zip("xyzw", values):
        require_number(f"{field}.{axis}", value, largest)
