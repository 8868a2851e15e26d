"""Enforcement of joint limits on commands, after ros_control's joint_limits_interface.

Every handle has the same two methods: ``enforce(period)`` changes the command of its joint in
place, ``reset()`` forgets the past. The simulated hardware resets them with the world.
"""

from __future__ import annotations

import math
from typing import Protocol

from .hardware_interface import JointHandle


def clamp(value: float, low: float, high: float) -> float:
    """Return `value` bounded to [`low`, `high`]."""
    return low if value < low else (high if value > high else value)


class JointLimitsHandle(Protocol):
    """What enforces limits on the command of one joint."""

    def enforce(self, period: float) -> None:
        """Bound the command; `period` is the time since the last call (s)."""

    def reset(self) -> None:
        """Forget the past."""


class EffortJointSaturationHandle:
    """Bounds an effort command by position, velocity and effort limits.

    Beyond a position limit no effort points further out, beyond the velocity limit none
    accelerates, and the effort stays within its limit.

    Parameters
    ----------
    joint : JointHandle
    lower, upper : float
        Position limits (rad, m); may be infinite.
    velocity, effort : float
        Limits (rad/s, Nm; m/s, N), above 0.

    Raises
    ------
    ValueError
        A limit is not above 0, or NaN.
    """

    __slots__ = ("_effort", "_joint", "_lower", "_upper", "_velocity")

    def __init__(
        self, joint: JointHandle, lower: float, upper: float, velocity: float, effort: float
    ) -> None:
        if not (velocity > 0.0 and effort > 0.0):
            raise ValueError(
                f"joint '{joint.name}': velocity limit {velocity} and effort limit {effort} "
                "must be above 0"
            )
        self._joint = joint
        self._lower = lower
        self._upper = upper
        self._velocity = velocity
        self._effort = effort

    def enforce(self, period: float) -> None:
        """Bound the effort command; a command that is not a number becomes 0."""
        joint = self._joint
        command = joint.command
        # The comparison is false for NaN, which no robot may carry out.
        if not abs(command) < math.inf:
            command = 0.0
        position, velocity = joint.state.position, joint.state.velocity
        low, high = -self._effort, self._effort
        if position < self._lower or velocity < -self._velocity:
            low = 0.0
        if position > self._upper or velocity > self._velocity:
            high = 0.0
        joint.command = clamp(command, low, high)

    def reset(self) -> None:
        """Nothing is remembered."""


class VelocityJointSaturationHandle:
    """Bounds a velocity command to the velocity limit.

    Parameters
    ----------
    joint : JointHandle
    velocity : float
        Limit (rad/s, m/s), above 0.
    """

    __slots__ = ("_joint", "_velocity")

    def __init__(self, joint: JointHandle, velocity: float) -> None:
        if not velocity > 0.0:
            raise ValueError(f"joint '{joint.name}': velocity limit {velocity} must be above 0")
        self._joint = joint
        self._velocity = velocity

    def enforce(self, period: float) -> None:
        """Bound the velocity command; a command that is not a number becomes 0."""
        joint = self._joint
        command = joint.command if abs(joint.command) < math.inf else 0.0
        joint.command = clamp(command, -self._velocity, self._velocity)

    def reset(self) -> None:
        """Nothing is remembered."""
