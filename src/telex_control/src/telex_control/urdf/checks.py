"""Refusal of invalid robot descriptions: links in a circle, impossible numbers."""

from __future__ import annotations

from collections import Counter
from typing import Dict, List, Optional, Tuple
from xml.etree import ElementTree

import numpy as np

from .elements import UrdfError, by_name, end, number, numbers, root_links

__all__ = ["check_bodies", "check_links"]

_DEEPEST = 200
"""Links one on another; PyBullet takes no more than 128 in all."""
_HEAVIEST = 1.0e6
"""kg."""
_FARTHEST = 1.0e4
"""m, rad; no place, angle or size is larger."""
_ROUNDING = 1.0e-6
"""Share of the largest moment of inertia by which the least one may be below 0."""
_NO_MOMENT = 1.0e-6
"""kg m2; by which it may be below 0, too, for published robots have small parts of this kind."""
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_SIZES = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {},
}
"""What each shape needs, and how many numbers."""
_KINDS = ("fixed", "revolute", "continuous", "prismatic")
"""Joints that are simulated; of others PyBullet makes what nobody moves."""


def check_links(robot: ElementTree.Element) -> None:
    """Refuse links that hang on themselves, on two joints, or in a chain without end.

    Parameters
    ----------
    robot : Element
        ``<robot>``.

    Raises
    ------
    UrdfError
        It names the links.
    """
    above: Dict[str, Tuple[str, str]] = {}
    for joint in robot.findall("joint"):
        name, parent, child = joint.get("name", ""), end(joint, "parent"), end(joint, "child")
        if not child:
            continue
        if child in above:
            raise UrdfError(
                f"link '{child}' is the child of the joints '{above[child][1]}' and '{name}'; a "
                "link hangs on one joint"
            )
        above[child] = (parent, name)
    depths: Dict[str, int] = {}
    for link in above:
        way: Dict[str, None] = {}
        at = link
        while at in above and at not in depths:
            if at in way:
                passed = list(way)
                circle = [*passed[passed.index(at) :], at]
                raise UrdfError(
                    f"the links form a circle: {_shortened(circle)}; one link must hang on no joint"
                )
            way[at] = None
            at = above[at][0]
        depth = depths.get(at, 0)
        for name in reversed(list(way)):
            depth += 1
            depths[name] = depth
        if depth > _DEEPEST:
            raise UrdfError(
                f"link '{link}' is the last of a chain of {depth}; {_DEEPEST} are possible"
            )


def _shortened(names: List[str]) -> str:
    shown = names if len(names) <= 8 else [*names[:6], "...", names[-1]]
    return " -> ".join(shown)


def check_bodies(robot: ElementTree.Element) -> None:
    """Refuse what makes no body, and masses, inertias, places and sizes that none can have.

    All of an inertia may be 0: it then counts for nothing.

    Parameters
    ----------
    robot : Element
        ``<robot>``.

    Raises
    ------
    UrdfError
        It names link or joint, the value, and what would be right.
    """
    if robot.get("name") is None:
        raise UrdfError("robot_description: <robot> has no name")
    for tag in ("link", "joint"):
        _check_names(robot, tag)
    roots = root_links(robot)
    if len(roots) != 1:
        raise UrdfError(
            f"robot_description has the roots {', '.join(roots)}; one link must hang on no joint"
            if roots
            else "robot_description has no <link>; calls of macros need the prefix xacro:"
        )
    links = by_name(robot, "link")
    for name, link in links.items():
        owner = f"link '{name}'"
        mass = number(link.find("inertial/mass"), "value", owner, 0.0)
        if not 0.0 <= mass <= _HEAVIEST:
            raise UrdfError(f"{owner}: mass is {mass:g} kg; 0 to {_HEAVIEST:g} is needed")
        inertia = link.find("inertial/inertia")
        if mass and inertia is None:
            raise UrdfError(f"{owner}: its <inertial> has no <inertia>; all of it may be 0")
        _check_inertia(owner, inertia)
        _check_place(f"{owner}: inertial", link.find("inertial/origin"))
        for kind in ("collision", "visual"):
            for part in link.findall(kind):
                _check_place(f"{owner}: {kind}", part.find("origin"))
                _check_shape(f"{owner}: {kind}", part.find("geometry"))
    for joint in robot.findall("joint"):
        owner = f"joint '{joint.get('name', '')}'"
        for which in ("parent", "child"):
            if end(joint, which) not in links:
                raise UrdfError(f"{owner}: its {which} is '{end(joint, which)}', which is no link")
        bare = joint.get("type") == "fixed" and links[end(joint, "child")].find("collision") is None
        if not (bare and _is_unfilled(joint.find("origin"))):
            _check_place(owner, joint.find("origin"))
        if joint.get("type", "") not in _KINDS:
            raise UrdfError(
                f"{owner} has the type '{joint.get('type', '')}'; simulated are {', '.join(_KINDS)}"
            )
        _check_numbers(owner, joint.find("axis"), "xyz", 3)


def _check_names(robot: ElementTree.Element, tag: str) -> None:
    names = [element.get("name", "") for element in robot.findall(tag)]
    for name, count in Counter(names).items():
        if not name:
            raise UrdfError(f"robot_description has a <{tag}> without a name")
        if count > 1:
            raise UrdfError(f"robot_description has {count} {tag}s of the name '{name}'")


def _check_inertia(owner: str, inertia: Optional[ElementTree.Element]) -> None:
    if inertia is None:
        return
    values = [number(inertia, key, owner, 0.0) for key in _MOMENTS]
    if max(map(abs, values)) > _HEAVIEST * _FARTHEST**2:
        raise UrdfError(f"{owner}: its <inertia> has {max(values, key=abs):g} kg m2")
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = values
    moments = np.linalg.eigvalsh(matrix + np.triu(matrix, 1).T)
    if moments[0] < -max(_NO_MOMENT, _ROUNDING * abs(moments[2])):
        said = ", ".join(f"{key} {value:g}" for key, value in zip(_MOMENTS, values))
        raise UrdfError(
            f"{owner}: inertia has the principal moment {moments[0]:g} kg m2 ({said}); none may be "
            "below 0"
        )


def _is_unfilled(origin: Optional[ElementTree.Element]) -> bool:
    """Whether its place is a macro's words: published files have such frames; PyBullet takes 0."""
    words = [] if origin is None else f"{origin.get('xyz', '')} {origin.get('rpy', '')}".split()
    try:
        list(map(float, words))
    except ValueError:
        return True
    return False


def _check_place(owner: str, origin: Optional[ElementTree.Element]) -> None:
    for key in ("xyz", "rpy"):
        _check_numbers(owner, origin, key, 3)


def _check_shape(owner: str, geometry: Optional[ElementTree.Element]) -> None:
    shape = None if geometry is None else next(iter(geometry), None)
    if shape is None or shape.tag not in _SIZES:
        known = ", ".join(_SIZES)
        said = "no shape" if shape is None else f"the shape <{shape.tag}>"
        raise UrdfError(f"{owner} has {said} in its <geometry>; known are {known}")
    for key, count in _SIZES[shape.tag].items():
        for value in numbers(shape, key, count, owner):
            if not 0.0 <= value <= _FARTHEST:
                raise UrdfError(f"{owner}: {key} is {value:g} m; 0 to {_FARTHEST:g} is needed")
    _check_numbers(owner, shape, "scale", 3)


def _check_numbers(
    owner: str, element: Optional[ElementTree.Element], key: str, count: int
) -> None:
    if element is None or element.get(key) is None:
        return
    for value in numbers(element, key, count, owner):
        if abs(value) > _FARTHEST:
            raise UrdfError(
                f"{owner}: <{element.tag} {key}> has the value {value:g}; at most {_FARTHEST:g} is "
                "possible"
            )
