"""The commanded velocity of the tool, in the base's axes. Free of ROS."""

from __future__ import annotations

from typing import Optional

import numpy as np

from telex_control.common.geometry.matrices import inverse
from telex_teleop.arm.tool_command import Frame, PoseCommand, ToolCommand, TwistCommand
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.motion.rigid_motion import pose_error


class WantedMotion:
    """Turns commands into twists; knows the pose that the tool is on its way to.

    Parameters
    ----------
    settings
        Speeds.
    """

    def __init__(self, settings: ToolSettings) -> None:
        self._settings = settings
        self._started: Optional[PoseCommand] = None
        self._target: Optional[np.ndarray] = None

    @property
    def to_a_pose(self) -> bool:
        """Whether the tool is on its way to a pose."""
        return self._started is not None

    def forget(self) -> None:
        """Forget the pose that the tool is moving to."""
        self._started = None

    def twist(
        self,
        command: Optional[ToolCommand],
        goal: np.ndarray,
        base: Optional[np.ndarray],
        speed_scale: float,
        dt: float,
    ) -> np.ndarray:
        """Return the wanted twist in the base's axes.

        Parameters
        ----------
        command
            What is wanted now, None to come to rest.
        goal : ndarray, shape (4, 4)
            The tool's desired pose in the base's frame.
        base : ndarray, shape (4, 4), or None
            Pose of the base in the world, as far as it is known.
        dt
            Time since the last joint state (s), above 0.

        Returns
        -------
        ndarray, shape (6,)
            m/s, rad/s.
        """
        if command is None:
            self.forget()
            return np.zeros(6)
        if isinstance(command, TwistCommand):
            self.forget()
            velocity = self._limited(command.velocity) * speed_scale
            return _turned(velocity, command.frame, goal, base)
        if self._started is None or not _same_pose(self._started, command):
            self._started, self._target = command, None
        return self._towards(command, goal, base, speed_scale, dt)

    def _limited(self, velocity: np.ndarray) -> np.ndarray:
        limited = velocity.copy()
        for part, limit in (
            (slice(0, 3), self._settings.max_linear),
            (slice(3, 6), self._settings.max_angular),
        ):
            speed = float(np.linalg.norm(velocity[part]))
            if speed > limit:
                limited[part] *= limit / speed
        return limited

    def _towards(
        self,
        command: PoseCommand,
        goal: np.ndarray,
        base: Optional[np.ndarray],
        speed_scale: float,
        dt: float,
    ) -> np.ndarray:
        """Return the twist along the straight line to a pose; turning ends with moving."""
        if command.frame is Frame.WORLD:
            if base is None:
                return np.zeros(6)
            target = inverse(base) @ command.pose
        else:
            if self._target is None:
                from_tool = command.frame is Frame.TOOL
                self._target = goal @ command.pose if from_tool else command.pose
            target = self._target
        return self._settings.approach(pose_error(target, goal), speed_scale, dt)


def _turned(
    velocity: np.ndarray, frame: Frame, goal: np.ndarray, base: Optional[np.ndarray]
) -> np.ndarray:
    if frame is Frame.BASE:
        return velocity
    if frame is Frame.TOOL:
        rotation = goal[:3, :3]
    elif base is None:
        return np.zeros(6)
    else:
        rotation = base[:3, :3].T
    return np.concatenate([rotation @ velocity[:3], rotation @ velocity[3:]])


def _same_pose(first: PoseCommand, second: PoseCommand) -> bool:
    return first.frame is second.frame and bool(np.array_equal(first.pose, second.pose))
