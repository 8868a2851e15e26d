"""Wheel radius and separation, from the robot description."""

from __future__ import annotations

import math
from typing import Dict
from xml.etree import ElementTree

from .urdf import UrdfError, by_name, end, number, origin


def wheel_separation(robot: ElementTree.Element, left: str, right: str) -> float:
    """Return the distance (m) between the origins of two wheel joints.

    Each is taken in its parent link, as diff_drive_controller does; both need the same one.

    Raises
    ------
    UrdfError
        A joint is missing, the parents differ, or the distance is 0.
    """
    joints = by_name(robot, "joint")
    first, second = _joint(joints, left), _joint(joints, right)
    parents = [end(joint, "parent") for joint in (first, second)]
    if parents[0] != parents[1]:
        raise UrdfError(
            f"wheel joints '{left}' and '{right}' hang on different links, '{parents[0]}' and "
            f"'{parents[1]}'; their distance cannot be read from the URDF"
        )
    places = [
        origin(joint, f"joint '{name}'").xyz for joint, name in ((first, left), (second, right))
    ]
    separation = math.dist(*places)
    if separation <= 0.0:
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


def _joint(joints: Dict[str, ElementTree.Element], name: str) -> ElementTree.Element:
    if name not in joints:
        raise UrdfError(f"robot_description has no wheel joint '{name}'")
    return joints[name]
