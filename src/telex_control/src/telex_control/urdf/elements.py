"""The XML of robot descriptions: where its elements are found and its attributes become numbers.

What the elements mean stands elsewhere: joints and limits in `urdf_joints`, the tree of links in
`kinematics.urdf_tree`, what is refused in `urdf_checks`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple
from xml.etree import ElementTree

__all__ = [
    "Origin",
    "UrdfError",
    "Vector",
    "by_name",
    "end",
    "number",
    "numbers",
    "origin",
    "read_xml",
    "root_links",
    "vector",
]

Vector = Tuple[float, float, float]
Element = ElementTree.Element

_MOST_CHARACTERS = 1_000_000
"""A robot_description that is longer is refused: nothing else runs while it is parsed."""


class UrdfError(ValueError):
    """The robot description cannot be used; the message says what is wrong with which element."""


@dataclass(frozen=True)
class Origin:
    """URDF ``<origin>``: position (m), and rotation about the fixed axes x, y, z (rad)."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)


def read_xml(text: str) -> Element:
    """Return the ``<robot>`` element of a URDF text.

    A default namespace (``<robot xmlns="...">``) is taken off, as other readers of URDF ignore it.

    Raises
    ------
    UrdfError
        Too long, not XML, or no robot.
    """
    if len(text) > _MOST_CHARACTERS:
        raise UrdfError(
            f"robot_description has {len(text)} characters; at most {_MOST_CHARACTERS} are read"
        )
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise UrdfError(f"robot_description is no XML: {error}") from None
    namespace, brace, _ = root.tag.rpartition("}")
    if brace:
        for element in root.iter():
            if element.tag.startswith(namespace + brace):
                element.tag = element.tag[len(namespace + brace) :]
    if root.tag != "robot":
        raise UrdfError(f"robot_description has the root element <{root.tag}>; <robot> is needed")
    return root


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


def number(
    element: Optional[Element], attribute: str, where: str, default: Optional[float] = None
) -> float:
    """Return an attribute that is one number.

    Parameters
    ----------
    element : Element or None
    attribute : str
    where : str
        What the element belongs to, for the message: ``link 'a'``.
    default : float, optional
        Where element or attribute is not there; without it, they must be.

    Raises
    ------
    UrdfError
        It is no finite number.
    """
    if default is not None and (element is None or element.get(attribute) is None):
        return default
    return numbers(element, attribute, 1, where)[0]


def vector(
    element: Optional[Element], attribute: str, where: str, default: Vector = (0.0, 0.0, 0.0)
) -> Vector:
    """Return an attribute that is three numbers; `default` where it is not there.

    Raises
    ------
    UrdfError
        They are not three finite numbers.
    """
    if element is None or element.get(attribute) is None:
        return default
    x, y, z = numbers(element, attribute, 3, where)
    return x, y, z


def numbers(element: Optional[Element], attribute: str, count: int, where: str) -> List[float]:
    """Return an attribute that is so many numbers, with blanks between them.

    Raises
    ------
    UrdfError
        The attribute is not there, or has anything else.
    """
    wanted = "a finite number is" if count == 1 else f"{count} finite numbers are"
    if element is None:
        raise UrdfError(f"{where}: {attribute} is not given; {wanted} needed")
    text = element.get(attribute, "")
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise UrdfError(f'{where}: <{element.tag} {attribute}="{text}">; {wanted} needed')
    return values


def origin(owner: Optional[Element], where: str) -> Origin:
    """Return the ``<origin>`` of an element; at zero where it has none.

    Raises
    ------
    UrdfError
    """
    element = None if owner is None else owner.find("origin")
    return Origin(vector(element, "xyz", where), vector(element, "rpy", where))
