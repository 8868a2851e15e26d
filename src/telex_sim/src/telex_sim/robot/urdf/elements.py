"""XML elements of a URDF that is rewritten for PyBullet.

Everywhere else a description is read as objects (`telex_control.urdf.model`). What PyBullet loads
is the user's own XML with some of it changed: written from objects, it would lose what they do not
have, such as PyBullet's own elements (``<contact>``), and what of it is wrong would no longer stand
there as PyBullet reads it.
"""

from __future__ import annotations

from typing import Dict, List, Optional
from xml.etree import ElementTree

from telex_control.common.geometry.quaternions import (
    IDENTITY,
    Pose,
    quaternion_from_rpy,
    rpy_from_quaternion,
)
from telex_control.urdf.elements import Vector, read_numbers

Element = ElementTree.Element


def by_name(robot: Element, tag: str) -> Dict[str, Element]:
    """Return the elements of one kind (``link``, ``joint``) by name, in the order of the file."""
    return {element.get("name", ""): element for element in robot.findall(tag)}


def end(joint: Element, which: str) -> str:
    """Return the link that a ``<joint>`` names as ``parent`` or ``child``; empty for none."""
    element = joint.find(which)
    return "" if element is None else element.get("link", "")


def root_links(robot: Element) -> List[str]:
    """Return the links that hang on no joint, in the order of the file."""
    carried = {end(joint, "child") for joint in robot.findall("joint")}
    return [name for name in by_name(robot, "link") if name not in carried]


def carried_joints(robot: Element) -> Dict[str, List[Element]]:
    """Return the joints on each link that has any."""
    carried: Dict[str, List[Element]] = {}
    for joint in robot.findall("joint"):
        carried.setdefault(end(joint, "parent"), []).append(joint)
    return carried


def number(element: Optional[Element], attribute: str, where: str) -> float:
    """Return an attribute that is one number; 0 where it is not there.

    Raises
    ------
    UrdfError
        It is no finite number.
    """
    text = None if element is None else element.get(attribute)
    if element is None or text is None:
        return 0.0
    return read_numbers(text, 1, f"{where}: <{element.tag} {attribute}")[0]


def vector(
    element: Optional[Element], attribute: str, where: str, default: Vector = (0.0, 0.0, 0.0)
) -> Vector:
    """Return an attribute that is three numbers; `default` where it is not there.

    Raises
    ------
    UrdfError
        They are not three finite numbers.
    """
    text = None if element is None else element.get(attribute)
    if element is None or text is None:
        return default
    x, y, z = read_numbers(text, 3, f"{where}: <{element.tag} {attribute}")
    return x, y, z


def pose_of(owner: Optional[Element]) -> Pose:
    """Return the ``<origin>`` of an element.

    Raises
    ------
    UrdfError
        It has anything else than numbers.
    """
    if owner is None:
        return IDENTITY
    place = owner.find("origin")
    rpy = vector(place, "rpy", owner.tag)
    return vector(place, "xyz", owner.tag), quaternion_from_rpy(rpy)


def set_pose(owner: Element, pose: Pose) -> None:
    """Replace the ``<origin>`` of an element."""
    place = owner.find("origin")
    if place is None:
        place = ElementTree.SubElement(owner, "origin")
    for key, values in (("xyz", pose[0]), ("rpy", rpy_from_quaternion(pose[1]))):
        place.set(key, " ".join(repr(float(value)) for value in values))


def mass_of(link: Element) -> float:
    """Return the mass (kg) of a link; 0 where none is given."""
    return number(link.find("inertial/mass"), "value", f"link '{link.get('name')}'")
