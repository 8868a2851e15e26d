"""Joints and limits of a URDF, as the control layer needs them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Dict, Optional

from .checks import check_links
from .elements import UrdfError, number
from .mimic import Mimic, mimics
from .model import Robot, SafetyController, read_robot

__all__ = [
    "CONTINUOUS",
    "MOVABLE",
    "PRISMATIC",
    "REVOLUTE",
    "SoftLimits",
    "UrdfError",
    "UrdfJoint",
    "joints",
    "parse_urdf",
    "short_name",
]

REVOLUTE = "revolute"
CONTINUOUS = "continuous"
PRISMATIC = "prismatic"
MOVABLE = (REVOLUTE, CONTINUOUS, PRISMATIC)


@dataclass(frozen=True)
class SoftLimits:
    """URDF ``<safety_controller>``: soft position limits (rad, m) and their gains.

    A limit that is left out is 0, as URDF has it and as ros_control enforces it: taking it for the
    hard limit would let a joint move here where the real robot stops it. A continuous joint has
    no soft position limits, whatever the element says.
    """

    lower: float
    upper: float
    k_position: float
    k_velocity: float


@dataclass(frozen=True)
class UrdfJoint:
    """One movable joint (rad, rad/s, Nm; m, m/s, N when prismatic).

    Attributes
    ----------
    lower, upper : float
        Position limits; infinite for continuous joints.
    velocity, effort : float
        Limits; infinite when the URDF gives none.
    friction : float
        Dry friction (``<dynamics friction>``), 0 or more.
    damping : float
        Viscous friction (``<dynamics damping>``; N m s/rad, N s/m), 0 or more.
    mimic : Mimic or None
        What it follows, if it does not move by itself.
    mimic_limits : bool
        Whether its own limits count then: they do unless they leave its leader no room.
    """

    name: str
    kind: str
    lower: float
    upper: float
    velocity: float
    effort: float
    friction: float
    damping: float
    soft: Optional[SoftLimits]
    mimic: Optional[Mimic] = None
    mimic_limits: bool = True


def short_name(joint: str) -> str:
    """Return a joint's name without the usual ending ``_joint``."""
    ending = "_joint"
    return joint[: -len(ending)] if joint.endswith(ending) else joint


def parse_urdf(text: str) -> Robot:
    """Return the robot of a URDF text, as objects of urdf_parser_py; see `model`.

    Raises
    ------
    UrdfError
        Too long, not XML, no robot, or its links form no tree.
    """
    robot = read_robot(text)
    check_links(robot)
    return robot


def _not_negative(element: Optional[Any], attribute: str, owner: str) -> float:
    value = number(element, attribute, f"joint '{owner}'", 0.0)
    if value < 0.0:
        raise UrdfError(f"joint '{owner}': {attribute} is {value:g}; 0 or more is needed")
    return value


def joints(robot: Robot) -> Dict[str, UrdfJoint]:
    """Return the movable joints of a robot by name, in the order of the file.

    A joint that others follow (``<mimic>``) has the limits that keep all of them within theirs.

    Raises
    ------
    UrdfError
        A limit is missing where it is required, is no number, or lower is above upper; soft limits
        leave no room; friction or damping is below 0.
    """
    result: Dict[str, UrdfJoint] = {}
    for element in robot.joints:
        kind, name, limit = element.type, element.name, element.limit
        if kind not in MOVABLE:
            continue
        where = f"joint '{name}'"
        if limit is None and kind != CONTINUOUS:
            raise UrdfError(f"joint '{name}' is {kind} and has no <limit>")
        infinite = math.inf
        lower = -infinite if kind == CONTINUOUS else number(limit, "lower", where, 0.0)
        upper = infinite if kind == CONTINUOUS else number(limit, "upper", where, 0.0)
        if lower > upper:
            raise UrdfError(f"joint '{name}': lower limit {lower} is above upper limit {upper}")
        result[name] = UrdfJoint(
            name=name,
            kind=kind,
            lower=lower,
            upper=upper,
            velocity=number(limit, "velocity", where, infinite),
            effort=number(limit, "effort", where, infinite),
            friction=_not_negative(element.dynamics, "friction", name),
            damping=_not_negative(element.dynamics, "damping", name),
            soft=_soft_limits(element.safety_controller, kind, name),
        )
    for name, mimic in mimics(robot).items():
        if name in result and mimic.joint in result:
            _couple(result, name, mimic)
    return result


def _couple(described: Dict[str, UrdfJoint], name: str, mimic: Mimic) -> None:
    """Limit a joint by another one that follows it."""
    leader, joint = described[mimic.joint], described[name]
    lower, upper = leader.lower, leader.upper
    if leader.kind != CONTINUOUS:
        lowest, highest = mimic.preimage(joint.lower, joint.upper)
        lower, upper = max(lower, lowest), min(upper, highest)
    if lower < upper:
        leader = replace(leader, lower=lower, upper=upper)
        joint = replace(joint, mimic=mimic)
    else:
        # Published grippers have such limits (0 to 0.8 with the multiplier -1).
        lower, upper = mimic.image(leader.lower, leader.upper)
        joint = replace(joint, mimic=mimic, mimic_limits=False, lower=lower, upper=upper)
    if joint.velocity and mimic.multiplier:
        velocity = min(leader.velocity, joint.velocity / abs(mimic.multiplier))
        leader = replace(leader, velocity=velocity)
    described[mimic.joint], described[name] = leader, joint


def _soft_limits(safety: Optional[SafetyController], kind: str, owner: str) -> Optional[SoftLimits]:
    if safety is None:
        return None
    where = f"joint '{owner}'"
    lower, upper = -math.inf, math.inf
    if kind != CONTINUOUS:
        lower = number(safety, "soft_lower_limit", where, 0.0)
        upper = number(safety, "soft_upper_limit", where, 0.0)
    if not lower < upper:
        raise UrdfError(
            f"joint '{owner}': soft_lower_limit {lower} must be below soft_upper_limit {upper} "
            "(0 where it is not given) in its <safety_controller>"
        )
    return SoftLimits(
        lower=lower,
        upper=upper,
        k_position=number(safety, "k_position", where, 0.0),
        k_velocity=number(safety, "k_velocity", where, 0.0),
    )
