"""Wheel radius and separation, from the robot description."""

from __future__ import annotations

from typing import Dict, Optional, Tuple
from xml.etree import ElementTree

import PyKDL

from ..kinematics.kdl_tree import kdl_frame
from .elements import UrdfError, by_name, end, number, origin

_SAME = 1.0e-9
"""m; origins of joints that are nearer have one place."""


def wheel_separation(robot: ElementTree.Element, left: str, right: str) -> float:
    """Return the distance (m) between the origins of two wheel joints.

    All joints are at 0, those that carry the wheels' suspensions too.

    Raises
    ------
    UrdfError
        A joint is missing, they have no link in common, or the distance is 0.
    """
    (first, first_root), (second, second_root) = (_place(robot, each) for each in (left, right))
    if first_root != second_root:
        raise UrdfError(
            f"wheel joints '{left}' and '{right}' hang on different roots, '{first_root}' and "
            f"'{second_root}'; their distance cannot be read from the URDF"
        )
    separation = (first - second).Norm()
    if separation < _SAME:
        raise UrdfError(f"wheel joints '{left}' and '{right}' are in the same place")
    return separation


def wheel_radius(robot: ElementTree.Element, joint: str) -> float:
    """Return the radius (m) of the cylinder or sphere that a wheel collides as.

    Raises
    ------
    UrdfError
        The joint or its link is missing, or the link collides as something else.
    """
    link_name = end(_joint(by_name(robot, "joint"), joint), "child")
    link = by_name(robot, "link").get(link_name)
    if link is None:
        raise UrdfError(f"wheel joint '{joint}': there is no link '{link_name}'")
    for shape in ("cylinder", "sphere"):
        element = link.find(f"collision/geometry/{shape}")
        if element is not None:
            radius = number(element, "radius", f"link '{link_name}'")
            if radius <= 0.0:
                raise UrdfError(
                    f"link '{link_name}': radius of its {shape} is {radius:g} m; a number above 0 "
                    "is needed"
                )
            return radius
    raise UrdfError(
        f"link '{link_name}' does not collide as a cylinder or a sphere; "
        "the wheel's radius cannot be read from the URDF"
    )


def _place(robot: ElementTree.Element, name: str) -> Tuple[PyKDL.Vector, str]:
    """Where the origin of a joint is (m), in the frame of the root link; and that link."""
    joints = by_name(robot, "joint")
    above = {end(joint, "child"): joint for joint in joints.values()}
    joint: Optional[ElementTree.Element] = _joint(joints, name)
    frame, link = PyKDL.Frame(), ""
    while joint is not None:
        frame = kdl_frame(origin(joint, f"joint '{joint.get('name', '')}'")) * frame
        link = end(joint, "parent")
        joint = above.get(link)
    return frame.p, link


def _joint(joints: Dict[str, ElementTree.Element], name: str) -> ElementTree.Element:
    if name not in joints:
        raise UrdfError(f"robot_description has no wheel joint '{name}'")
    return joints[name]
