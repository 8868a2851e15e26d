"""Limits of joints: what the URDF and the parameters ``joint_limits/<joint>`` say.

The parameters are those of ros_control's joint_limits_interface (joint_limits_rosparam.h).
"""

from __future__ import annotations

import dataclasses
import logging
import math
from dataclasses import dataclass
from typing import Any, Dict, Mapping, Optional, Tuple

from ..common.params import read_config, require, require_range
from ..urdf.joints import CONTINUOUS, UrdfJoint

_log = logging.getLogger("rosout")


class JointLimitsError(ValueError):
    """Limits are impossible or missing; the message names the joint, the limit and its value."""


def clamp(value: float, low: float, high: float) -> float:
    """Return `value` bounded to [`low`, `high`]; `high` where the bounds have crossed."""
    raised = low if value < low else value
    return high if raised > high else raised


@dataclass(frozen=True)
class JointLimits:
    """Hard limits of one joint; infinite where it has none (rad, m; s; Nm, N).

    Attributes
    ----------
    max_velocity, max_acceleration, max_jerk, max_effort : float
        Of the magnitude.
    angle_wraparound : bool
        A joint without position limits whose position repeats every turn.

    Raises
    ------
    ValueError
        A limit is negative, NaN, or crosses its counterpart.
    """

    min_position: float = -math.inf
    max_position: float = math.inf
    max_velocity: float = math.inf
    max_acceleration: float = math.inf
    max_jerk: float = math.inf
    max_effort: float = math.inf
    angle_wraparound: bool = False

    def __post_init__(self) -> None:
        if not self.min_position <= self.max_position:
            raise ValueError(
                f"min_position {self.min_position} must not be above max_position "
                f"{self.max_position}"
            )
        for name in ("max_velocity", "max_acceleration", "max_jerk", "max_effort"):
            value = getattr(self, name)
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; it must be above 0")

    @property
    def has_position_limits(self) -> bool:
        """Whether there is a lower or an upper limit."""
        return self.min_position > -math.inf or self.max_position < math.inf


@dataclass(frozen=True)
class SoftJointLimits:
    """Soft limits of one joint: how it is slowed down before it reaches its hard limits.

    Attributes
    ----------
    min_position, max_position : float
        Soft limits (rad, m).
    k_position : float
        How steeply the allowed velocity falls towards a soft limit (1/s).
    k_velocity : float
        Effort against each unit of velocity beyond the allowed one (Nm s/rad, N s/m).

    Raises
    ------
    ValueError
        A gain is negative or not finite; the limits leave no room.
    """

    min_position: float
    max_position: float
    k_position: float
    k_velocity: float

    def __post_init__(self) -> None:
        if not self.min_position < self.max_position:
            raise ValueError(
                f"soft_lower_limit {self.min_position} must be below soft_upper_limit "
                f"{self.max_position}"
            )
        for name in ("k_position", "k_velocity"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise ValueError(f"{name} is {value}; it must be finite and not negative")


@dataclass(frozen=True)
class _LimitsParams:
    """The parameters ``joint_limits/<joint>``; None is "not given"."""

    has_position_limits: Optional[bool] = None
    min_position: Optional[float] = None
    max_position: Optional[float] = None
    angle_wraparound: Optional[bool] = None
    has_velocity_limits: Optional[bool] = None
    max_velocity: Optional[float] = None
    has_acceleration_limits: Optional[bool] = None
    max_acceleration: Optional[float] = None
    has_jerk_limits: Optional[bool] = None
    max_jerk: Optional[float] = None
    has_effort_limits: Optional[bool] = None
    max_effort: Optional[float] = None
    has_soft_limits: Optional[bool] = None
    k_position: Optional[float] = None
    k_velocity: Optional[float] = None
    soft_lower_limit: Optional[float] = None
    soft_upper_limit: Optional[float] = None

    def __post_init__(self) -> None:
        for flag, names in _VALUES_OF_FLAGS.items():
            for name in names if getattr(self, flag) else ():
                require(getattr(self, name) is not None, f"{flag} is true, but {name} is not given")
        for name in ("max_velocity", "max_acceleration", "max_jerk", "max_effort"):
            require_range(self, name, above=0.0)
        for name in ("k_position", "k_velocity"):
            require_range(self, name, minimum=0.0)
        if self.has_position_limits:
            require_range(self, "max_position", minimum=self.min_position or 0.0)
        if self.has_soft_limits:
            require_range(self, "soft_upper_limit", above=self.soft_lower_limit or 0.0)


_VALUES_OF_FLAGS = {
    "has_position_limits": ("min_position", "max_position"),
    "has_velocity_limits": ("max_velocity",),
    "has_acceleration_limits": ("max_acceleration",),
    "has_jerk_limits": ("max_jerk",),
    "has_effort_limits": ("max_effort",),
    "has_soft_limits": ("k_position", "k_velocity", "soft_lower_limit", "soft_upper_limit"),
}


def joint_limits(
    joint: UrdfJoint, params: Any = None, namespace: str = "joint_limits"
) -> Tuple[JointLimits, Optional[SoftJointLimits]]:
    """Gather the limits of a joint from the URDF and from parameters, which prevail.

    Parameters
    ----------
    params : mapping, optional
        The parameters ``joint_limits``, as joint names to structs. In a struct, a value counts
        only when its flag (``has_velocity_limits`` …) is true; a flag that is false takes the
        URDF's limit away.
    namespace : str
        Full name of these parameters, for messages.

    Returns
    -------
    limits : JointLimits
    soft_limits : SoftJointLimits or None

    Raises
    ------
    ConfigError
        A parameter is unknown, missing or wrong.
    JointLimitsError
        The URDF's limits are wrong.
    """
    try:
        limits, soft = _urdf_limits(joint)
    except ValueError as error:
        raise JointLimitsError(f"joint '{joint.name}': {error}") from None
    if isinstance(params, Mapping) and joint.name in params:
        limits, soft = _overridden(limits, soft, params[joint.name], f"{namespace}/{joint.name}")
    if soft is not None and limits.has_position_limits:
        if not abs(soft.min_position) < math.inf:
            # A continuous joint that parameters have given an end: its gains are the URDF's.
            soft = dataclasses.replace(
                soft, min_position=limits.min_position, max_position=limits.max_position
            )
        if soft.k_position == 0.0:
            _log.warning(
                "joint '%s': k_position is 0, so that its soft limits allow no velocity at all",
                joint.name,
            )
    return limits, soft


def _overridden(
    limits: JointLimits, soft: Optional[SoftJointLimits], params: Any, where: str
) -> Tuple[JointLimits, Optional[SoftJointLimits]]:
    given = read_config(_LimitsParams, params, where)
    for flag, names in _VALUES_OF_FLAGS.items():
        useless = [name for name in names if getattr(given, name) is not None]
        if useless and getattr(given, flag) is None:
            _log.warning("parameter %s/%s has no effect without %s: true", where, useless[0], flag)
    changes: Dict[str, Any] = {}
    for flag, names in _VALUES_OF_FLAGS.items():
        if flag == "has_soft_limits" or getattr(given, flag) is None:
            continue
        for name in names:
            none = -math.inf if name == "min_position" else math.inf
            changes[name] = getattr(given, name) if getattr(given, flag) else none
    if given.has_position_limits:
        changes["angle_wraparound"] = False
    elif given.has_position_limits is False and given.angle_wraparound is not None:
        changes["angle_wraparound"] = given.angle_wraparound
    limits = dataclasses.replace(limits, **changes)
    if given.has_soft_limits is not None:
        soft = _soft_limits(given) if given.has_soft_limits else None
    return limits, soft


def _urdf_limits(joint: UrdfJoint) -> Tuple[JointLimits, Optional[SoftJointLimits]]:
    limits = JointLimits(
        min_position=joint.lower,
        max_position=joint.upper,
        max_velocity=joint.velocity,
        max_effort=joint.effort,
        angle_wraparound=joint.kind == CONTINUOUS,
    )
    soft = joint.soft
    if soft is None:
        return limits, None
    return limits, SoftJointLimits(soft.lower, soft.upper, soft.k_position, soft.k_velocity)


def _soft_limits(given: _LimitsParams) -> SoftJointLimits:
    assert given.soft_lower_limit is not None
    assert given.soft_upper_limit is not None
    assert given.k_position is not None
    assert given.k_velocity is not None
    return SoftJointLimits(
        given.soft_lower_limit, given.soft_upper_limit, given.k_position, given.k_velocity
    )
