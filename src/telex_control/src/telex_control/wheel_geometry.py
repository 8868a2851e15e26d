"""Wheel radius and separation, from the robot description."""

from __future__ import annotations

import math
from typing import Dict, List, Optional, Tuple
from xml.etree import ElementTree

from .urdf_joints import UrdfError

Vector = Tuple[float, float, float]


def wheel_separation(robot: ElementTree.Element, left: str, right: str) -> float:
    """Return the distance (m) between the origins of two wheel joints.

    Each is taken in its parent link, as diff_drive_controller does; both need the same one.

    Raises
    ------
    UrdfError
        A joint is missing, the parents differ, or the distance is 0.
    """
    joints = _joints(robot)
    first, second = _joint(joints, left), _joint(joints, right)
    parents = [_link(joint, "parent") for joint in (first, second)]
    if parents[0] != parents[1]:
        raise UrdfError(
            f"wheel joints '{left}' and '{right}' hang on different links, '{parents[0]}' and "
            f"'{parents[1]}'; their distance cannot be read from the URDF"
        )
    separation = math.dist(_origin(first), _origin(second))
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
    link_name = _link(_joint(_joints(robot), joint), "child")
    link = next((each for each in robot.findall("link") if each.get("name") == link_name), None)
    if link is None:
        raise UrdfError(f"wheel joint '{joint}': there is no link '{link_name}'")
    for shape in ("cylinder", "sphere"):
        element = link.find(f"collision/geometry/{shape}")
        if element is not None:
            return _positive(element.get("radius"), f"link '{link_name}': radius of its {shape}")
    raise UrdfError(
        f"link '{link_name}' does not collide as a cylinder or a sphere; "
        "the wheel's radius cannot be read from the URDF"
    )


def _joints(robot: ElementTree.Element) -> Dict[str, ElementTree.Element]:
    return {each.get("name", ""): each for each in robot.findall("joint")}


def _joint(joints: Dict[str, ElementTree.Element], name: str) -> ElementTree.Element:
    if name not in joints:
        raise UrdfError(f"robot_description has no wheel joint '{name}'")
    return joints[name]


def _link(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _origin(joint: ElementTree.Element) -> Vector:
    element = joint.find("origin")
    text = "0 0 0" if element is None else element.get("xyz", "0 0 0")
    words: List[str] = text.split()
    try:
        x, y, z = (float(word) for word in words)
    except ValueError:
        raise UrdfError(
            f"joint '{joint.get('name')}': origin xyz=\"{text}\" is no vector"
        ) from None
    return x, y, z


def _positive(text: Optional[str], what: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise UrdfError(f"{what} is {text!r}; a number above 0 is needed")
    return value
