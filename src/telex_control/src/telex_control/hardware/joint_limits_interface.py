"""Enforcement of joint limits on commands, after ros_control's joint_limits_interface.

A limits handle changes the command of its joint in place, once a control cycle, just before the
robot carries it out; `limits_handle` chooses the right one of the six. The formulas are upstream's
(joint_limits_interface.h, ros_control 0.20.0). Beyond upstream, a command that is not finite is
never carried out: an effort or velocity becomes 0, a position holds. Whoever puts the robot back to
where it started resets the handles, or else a limited command would creep on from where it was.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from typing import Optional, Tuple, Type

from .hardware_interface import (
    EffortJointInterface,
    HardwareInterface,
    JointHandle,
    NamedHandle,
    PositionJointInterface,
    ResourceManager,
    VelocityJointInterface,
)
from .joint_limits import JointLimits, JointLimitsError, SoftJointLimits, clamp


class JointLimitsHandle(NamedHandle):
    """What enforces limits on the command of one joint."""

    __slots__ = ("_joint",)

    def __init__(self, joint: JointHandle) -> None:
        super().__init__(joint.name)
        self._joint = joint

    def enforce(self, period: float) -> None:
        """Bound the command; `period` is the time since the last call (s)."""
        raise NotImplementedError

    def reset(self) -> None:
        """Forget the past, as after an emergency stop or a reset of the world."""


def _need(joint: JointHandle, limits: JointLimits, *names: str) -> None:
    for name in names:
        if not getattr(limits, name) < math.inf:
            raise JointLimitsError(
                f"Cannot enforce limits for joint '{joint.name}'. It has no {name}; set it in the "
                f"URDF's <limit>, or as joint_limits/{joint.name}/{name}"
            )


class PositionJointSaturationHandle(JointLimitsHandle):
    """Bounds a position command by the position limits, and its change by the velocity limit."""

    __slots__ = ("_high", "_low", "_previous", "_velocity")
    SAVED = ("_previous",)

    def __init__(self, joint: JointHandle, limits: JointLimits) -> None:
        super().__init__(joint)
        self._low = limits.min_position
        self._high = limits.max_position
        self._velocity = limits.max_velocity
        self._previous: Optional[float] = None

    def enforce(self, period: float) -> None:
        """Bound the position command."""
        joint = self._joint
        previous = joint.state.position if self._previous is None else self._previous
        command = joint.command
        # The comparison is false for NaN, which no robot may carry out.
        if not abs(command) < math.inf:
            command = previous
        low, high = self._low, self._high
        velocity = self._velocity
        if velocity < math.inf:
            low = max(previous - velocity * period, low)
            high = min(previous + velocity * period, high)
        self._previous = joint.command = clamp(command, low, high)

    def reset(self) -> None:
        """Begin with the measured position."""
        self._previous = None


class _SoftLimitsHandle(JointLimitsHandle):
    """What handles with soft limits share: the velocities that are allowed at a position."""

    __slots__ = ("_gain", "_lower", "_upper", "_velocity")

    def __init__(
        self, joint: JointHandle, limits: JointLimits, soft_limits: SoftJointLimits
    ) -> None:
        super().__init__(joint)
        self._velocity = limits.max_velocity
        # Soft limits slow down only a joint that has position limits, as upstream has it.
        bounded = limits.has_position_limits
        self._gain = -soft_limits.k_position if bounded else -1.0
        self._lower = soft_limits.min_position if bounded else -math.inf
        self._upper = soft_limits.max_position if bounded else math.inf

    def _allowed_velocities(self, position: float) -> Tuple[float, float]:
        """Return the lowest and the highest velocity that is allowed at `position`."""
        # Written out: `clamp` would be a third of the time of all limits, in every cycle.
        velocity, gain = self._velocity, self._gain
        slowest, fastest = gain * (position - self._lower), gain * (position - self._upper)
        if slowest < -velocity:
            slowest = -velocity
        elif slowest > velocity:
            slowest = velocity
        if fastest > velocity:
            fastest = velocity
        elif fastest < -velocity:
            fastest = -velocity
        return slowest, fastest


class PositionJointSoftLimitsHandle(_SoftLimitsHandle):
    """Bounds a position command by hard and soft limits, its change by the allowed velocity.

    Parameters
    ----------
    soft_limits : SoftJointLimits
        `k_velocity` is not used.

    Raises
    ------
    JointLimitsError
        There is no velocity limit.
    """

    __slots__ = ("_high", "_low", "_previous")
    SAVED = ("_previous",)

    def __init__(
        self, joint: JointHandle, limits: JointLimits, soft_limits: SoftJointLimits
    ) -> None:
        super().__init__(joint, limits, soft_limits)
        _need(joint, limits, "max_velocity")
        self._low = limits.min_position
        self._high = limits.max_position
        self._previous: Optional[float] = None

    def enforce(self, period: float) -> None:
        """Bound the position command."""
        joint = self._joint
        previous = joint.state.position if self._previous is None else self._previous
        command = joint.command
        if not abs(command) < math.inf:
            command = previous
        slowest, fastest = self._allowed_velocities(previous)
        self._previous = joint.command = clamp(
            command,
            max(previous + slowest * period, self._low),
            min(previous + fastest * period, self._high),
        )

    def reset(self) -> None:
        """Begin with the measured position."""
        self._previous = None


class EffortJointSaturationHandle(JointLimitsHandle):
    """Bounds an effort command by position, velocity and effort limits.

    Beyond a position limit no effort points further out, beyond the velocity limit none
    accelerates, and the effort stays within its limit.

    Raises
    ------
    JointLimitsError
        There is no velocity or no effort limit.
    """

    __slots__ = ("_effort", "_lower", "_upper", "_velocity")

    def __init__(self, joint: JointHandle, limits: JointLimits) -> None:
        super().__init__(joint)
        _need(joint, limits, "max_velocity", "max_effort")
        self._lower = limits.min_position
        self._upper = limits.max_position
        self._velocity = limits.max_velocity
        self._effort = limits.max_effort

    def enforce(self, period: float) -> None:
        """Bound the effort command."""
        joint = self._joint
        command = joint.command
        if not abs(command) < math.inf:
            command = 0.0
        position, velocity = joint.state.position, joint.state.velocity
        low, high = -self._effort, self._effort
        if position < self._lower or velocity < -self._velocity:
            low = 0.0
        if position > self._upper or velocity > self._velocity:
            high = 0.0
        joint.command = clamp(command, low, high)


class EffortJointSoftLimitsHandle(_SoftLimitsHandle):
    """Bounds an effort command so that the velocity stays within what soft limits allow.

    Raises
    ------
    JointLimitsError
        There is no velocity or no effort limit.
    """

    __slots__ = ("_damping", "_effort")

    def __init__(
        self, joint: JointHandle, limits: JointLimits, soft_limits: SoftJointLimits
    ) -> None:
        super().__init__(joint, limits, soft_limits)
        _need(joint, limits, "max_velocity", "max_effort")
        self._damping = -soft_limits.k_velocity
        self._effort = limits.max_effort

    def enforce(self, period: float) -> None:
        """Bound the effort command."""
        joint, state = self._joint, self._joint.state
        command = joint.command
        if not abs(command) < math.inf:
            command = 0.0
        slowest, fastest = self._allowed_velocities(state.position)
        gain, effort, velocity = self._damping, self._effort, state.velocity
        low, high = gain * (velocity - slowest), gain * (velocity - fastest)
        if low < -effort:
            low = -effort
        elif low > effort:
            low = effort
        if high > effort:
            high = effort
        elif high < -effort:
            high = -effort
        raised = low if command < low else command
        joint.command = high if raised > high else raised


class VelocityJointSaturationHandle(JointLimitsHandle):
    """Bounds a velocity command by the velocity limit, its change by the acceleration limit.

    Raises
    ------
    JointLimitsError
        There is no velocity limit.
    """

    __slots__ = ("_acceleration", "_previous", "_velocity")
    SAVED = ("_previous",)

    def __init__(self, joint: JointHandle, limits: JointLimits) -> None:
        super().__init__(joint)
        _need(joint, limits, "max_velocity")
        self._velocity = limits.max_velocity
        self._acceleration = limits.max_acceleration
        self._previous = 0.0

    def enforce(self, period: float) -> None:
        """Bound the velocity command."""
        joint = self._joint
        command = joint.command
        if not abs(command) < math.inf:
            command = 0.0
        low, high = -self._velocity, self._velocity
        acceleration = self._acceleration
        if acceleration < math.inf:
            low = max(self._previous - acceleration * period, low)
            high = min(self._previous + acceleration * period, high)
        self._previous = joint.command = clamp(command, low, high)

    def reset(self) -> None:
        """Begin at rest."""
        self._previous = 0.0


class VelocityJointSoftLimitsHandle(_SoftLimitsHandle):
    """Bounds a velocity command by what soft limits allow, and by the acceleration limit.

    Parameters
    ----------
    limits : JointLimits
        The acceleration is limited about the measured velocity.
    soft_limits : SoftJointLimits
        `k_velocity` is not used.
    """

    __slots__ = ("_acceleration",)

    def __init__(
        self, joint: JointHandle, limits: JointLimits, soft_limits: SoftJointLimits
    ) -> None:
        super().__init__(joint, limits, soft_limits)
        self._acceleration = limits.max_acceleration

    def enforce(self, period: float) -> None:
        """Bound the velocity command."""
        joint, state = self._joint, self._joint.state
        command = joint.command
        if not abs(command) < math.inf:
            command = 0.0
        low, high = self._allowed_velocities(state.position)
        acceleration = self._acceleration
        if acceleration < math.inf:
            low = max(state.velocity - acceleration * period, low)
            high = min(state.velocity + acceleration * period, high)
        joint.command = clamp(command, low, high)


class JointLimitsInterface(ResourceManager[JointLimitsHandle]):
    """The limits handles of a robot."""

    type_name = "joint_limits_interface::JointLimitsInterface"

    def enforce(self, period: float) -> None:
        """Bound the commands of all joints; `period` is the time since the last call (s)."""
        for handle in self._handles.values():
            handle.enforce(period)

    def reset(self) -> None:
        """Let all handles forget the past."""
        for handle in self._handles.values():
            handle.reset()


_SATURATION = {
    PositionJointInterface: PositionJointSaturationHandle,
    VelocityJointInterface: VelocityJointSaturationHandle,
    EffortJointInterface: EffortJointSaturationHandle,
}
_SOFT_LIMITS = {
    PositionJointInterface: PositionJointSoftLimitsHandle,
    VelocityJointInterface: VelocityJointSoftLimitsHandle,
    EffortJointInterface: EffortJointSoftLimitsHandle,
}
_UNBOUNDED = sys.float_info.max
"""Bounds nothing; finite, because some formula would meet 0 * infinity otherwise."""


def limits_handle(
    interface: Type[HardwareInterface],
    joint: JointHandle,
    limits: JointLimits,
    soft_limits: Optional[SoftJointLimits] = None,
) -> JointLimitsHandle:
    """Return the handle that enforces limits on a joint commanded through `interface`.

    Like Gazebo's hardware, and unlike the handles by themselves, it takes every joint: what has no
    limit is not bounded. A joint without any limits gets a handle, too, for no joint may be given
    a command that is not finite.

    Parameters
    ----------
    interface : class
        `EffortJointInterface`, `VelocityJointInterface` or `PositionJointInterface`.
    soft_limits : SoftJointLimits, optional
        With them, a handle that slows the joint down before its limits.
    """
    limits = dataclasses.replace(
        limits,
        max_velocity=min(limits.max_velocity, _UNBOUNDED),
        max_effort=min(limits.max_effort, _UNBOUNDED),
    )
    if soft_limits is None:
        return _SATURATION[interface](joint, limits)  # type: ignore[index]
    return _SOFT_LIMITS[interface](joint, limits, soft_limits)  # type: ignore[index]
