"""Limits of the robot's joints, read from its URDF."""

from __future__ import annotations

import math
import xml.etree.ElementTree
from dataclasses import dataclass
from typing import Dict, Iterable

import urdf_parser_py.xml_reflection.core
from urdf_parser_py.urdf import URDF, Joint

__all__ = ["JointLimits", "LimitsError", "limits_from_urdf"]

PARSE_ERRORS = (xml.etree.ElementTree.ParseError, urdf_parser_py.xml_reflection.core.ParseError)
PRISMATIC = "prismatic"
REVOLUTE = "revolute"


class LimitsError(ValueError):
    """The robot description lacks a joint or a limit that teleoperation needs."""


@dataclass(frozen=True)
class JointLimits:
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


def limits_from_urdf(description: str, joints: Iterable[str]) -> Dict[str, JointLimits]:
    """Read the limits of some joints.

    Parameters
    ----------
    description
        The URDF as text.
    joints
        Names of the joints that are wanted.

    Raises
    ------
    LimitsError
        When the text is no URDF, or a joint is missing, cannot move or has no usable limit.
    """
    try:
        # bytes, because lxml, which some versions use, refuses text that declares an encoding
        robot = URDF.from_xml_string(description.encode("utf-8"))
    except PARSE_ERRORS as error:
        raise LimitsError(f"robot_description is not a valid URDF: {error}") from error
    by_name = {joint.name: joint for joint in robot.joints}
    missing = sorted(set(joints) - set(by_name))
    if missing:
        raise LimitsError(f"robot_description has no joint {', '.join(missing)}")
    return {name: _limits(by_name[name]) for name in joints}


def _limits(joint: Joint) -> JointLimits:
    if joint.type not in ("revolute", "continuous", "prismatic"):
        raise LimitsError(
            f"joint {joint.name} is {joint.type}; must be revolute, continuous or prismatic"
        )
    limit = joint.limit
    velocity = math.nan if limit is None or limit.velocity is None else float(limit.velocity)
    if not (math.isfinite(velocity) and velocity > 0.0):
        raise LimitsError(f"joint {joint.name} needs <limit velocity=...> above 0 in the URDF")
    if joint.type == "continuous":
        return JointLimits(REVOLUTE, -math.inf, math.inf, velocity)
    lower, upper = float(limit.lower or 0.0), float(limit.upper or 0.0)
    soft = joint.safety_controller
    # Beyond its soft limits a joint is pushed back. URDF's default for both is 0, which says
    # nothing.
    if soft is not None and soft.soft_lower_limit < soft.soft_upper_limit:
        lower = max(lower, float(soft.soft_lower_limit))
        upper = min(upper, float(soft.soft_upper_limit))
    if not (math.isfinite(lower) and math.isfinite(upper) and lower < upper):
        raise LimitsError(
            f"joint {joint.name} has <limit lower={lower:g} upper={upper:g}>; "
            "lower must be below upper"
        )
    return JointLimits(PRISMATIC if joint.type == "prismatic" else REVOLUTE, lower, upper, velocity)
