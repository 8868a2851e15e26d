"""Limits of the robot's joints, read from its URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Collection, Dict

from telex_control.urdf.joints import (
    PRISMATIC,
    REVOLUTE,
    UrdfError,
    UrdfJoint,
    joints,
    parse_urdf,
)


@dataclass(frozen=True)
class JointBounds:
    """What a joint can do.

    Attributes
    ----------
    kind
        ``"revolute"`` (rad) or ``"prismatic"`` (m); a continuous joint is revolute without position
        limits.
    lower, upper
        Position limits (rad or m), the soft ones where the URDF has them; infinite where there is
        none.
    max_velocity
        Largest speed (rad/s or m/s), above zero.
    """

    kind: str
    lower: float
    upper: float
    max_velocity: float


def limits_from_urdf(description: str, names: Collection[str]) -> Dict[str, JointBounds]:
    """Read the limits of some joints.

    Parameters
    ----------
    names
        The joints that are wanted.

    Raises
    ------
    telex_control.urdf.joints.UrdfError
        When the text is no URDF, or a joint is missing, cannot move or has no usable limit.
    """
    movable = joints(parse_urdf(description))
    missing = sorted(set(names) - set(movable))
    if missing:
        raise UrdfError(
            "robot_description has no revolute, continuous or prismatic joint " + ", ".join(missing)
        )
    return {name: _limits(movable[name]) for name in names}


def _limits(joint: UrdfJoint) -> JointBounds:
    if not (math.isfinite(joint.velocity) and joint.velocity > 0.0):
        raise UrdfError(f"joint '{joint.name}' needs <limit velocity=...> above 0")
    lower, upper = joint.lower, joint.upper
    if joint.soft is not None:
        # Beyond its soft limits a joint is pushed back.
        lower, upper = max(lower, joint.soft.lower), min(upper, joint.soft.upper)
    if not lower < upper:
        raise UrdfError(
            f"joint '{joint.name}' may move from {lower:g} to {upper:g}, by its <limit> and "
            "<safety_controller>; lower must be below upper"
        )
    kind = PRISMATIC if joint.kind == PRISMATIC else REVOLUTE
    return JointBounds(kind, lower, upper, joint.velocity)
