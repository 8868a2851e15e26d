"""What no robot description may say: links in a circle, and numbers that no body can have."""

from __future__ import annotations

from typing import Dict, Iterator, List, Optional, Tuple
from xml.etree import ElementTree

import numpy as np

from .urdf import UrdfError, by_name, end, number, root_links

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
_SIZES = ("size", "radius", "length", "scale")


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
        _check_inertia(owner, link.find("inertial/inertia"))
        for kind in ("inertial", "collision", "visual"):
            for part in link.findall(kind):
                _check_place(f"{owner}: {kind}", part.find("origin"))
                _check_sizes(f"{owner}: {kind}", part.find("geometry"))
    for joint in robot.findall("joint"):
        owner = f"joint '{joint.get('name', '')}'"
        for which in ("parent", "child"):
            if end(joint, which) not in links:
                raise UrdfError(f"{owner}: its {which} is '{end(joint, which)}', which is no link")
        _check_place(owner, joint.find("origin"))
        for value in _numbers(joint.find("axis"), "xyz"):
            _require_finite(owner, "axis", value)


def _check_inertia(owner: str, inertia: Optional[ElementTree.Element]) -> None:
    if inertia is None:
        return
    values = [number(inertia, key, owner, 0.0) for key in _MOMENTS]
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = values
    moments = np.linalg.eigvalsh(matrix + np.triu(matrix, 1).T)
    if moments[0] < -max(_NO_MOMENT, _ROUNDING * abs(moments[2])):
        said = ", ".join(f"{key} {value:g}" for key, value in zip(_MOMENTS, values))
        raise UrdfError(
            f"{owner}: inertia has the principal moment {moments[0]:g} kg m2 ({said}); none may be "
            "below 0"
        )


def _check_place(owner: str, origin: Optional[ElementTree.Element]) -> None:
    for key in ("xyz", "rpy"):
        for value in _numbers(origin, key):
            _require_finite(owner, f"origin {key}", value)


def _check_sizes(owner: str, geometry: Optional[ElementTree.Element]) -> None:
    for shape in () if geometry is None else geometry:
        for key in _SIZES:
            for value in _numbers(shape, key):
                _require_finite(owner, key, value)
                if value < 0.0 and key != "scale":
                    raise UrdfError(f"{owner}: {key} is {value:g} m; 0 or more is needed")


def _require_finite(owner: str, what: str, value: float) -> None:
    if not abs(value) <= _FARTHEST:
        raise UrdfError(
            f"{owner}: {what} has the value {value:g}; finite numbers, of at most {_FARTHEST:g}, "
            "are needed"
        )


def _numbers(element: Optional[ElementTree.Element], key: str) -> Iterator[float]:
    """Yield the numbers of an attribute; words that are none are left to those who read it."""
    for word in ("" if element is None else element.get(key, "")).split():
        try:
            yield float(word)
        except ValueError:
            return
