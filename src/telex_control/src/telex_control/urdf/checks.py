"""Refusal of invalid robot descriptions: links in a circle, impossible numbers."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from .elements import UrdfError, number, numbers, root_links, xml_name
from .model import Inertia, Joint, Mesh, Pose, Robot, UnknownShape

_DEEPEST = 200
"""Links one on another; PyBullet takes no more than 128 in all."""
_LONGEST_NAME = 200
"""Bytes; PyBullet writes past the end of its fields from 1024 on."""
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
_SHORTEST_AXIS = 1.0e-9
"""Length below which an axis tells no direction, as in the kinematics."""
_KINDS = ("fixed", "revolute", "continuous", "prismatic")
"""Joints that are simulated; of others PyBullet makes what nobody moves."""


def check_links(robot: Robot) -> None:
    """Refuse links that hang on themselves, on two joints, or in a chain without end.

    Raises
    ------
    UrdfError
        It names the links.
    """
    above: Dict[str, Tuple[str, str]] = {}
    for joint in robot.joints:
        name, parent, child = joint.name, joint.parent, joint.child
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


def check_bodies(robot: Robot) -> None:
    """Refuse what makes no body, and masses, inertias, places and sizes that none can have.

    All of an inertia may be 0: it then counts for nothing.

    Raises
    ------
    UrdfError
        It names link or joint, the value, and what would be right.
    """
    if robot.name is None:
        raise UrdfError("robot_description: <robot> has no name")
    _check_length("robot", robot.name)
    _check_names("link", [link.name for link in robot.links])
    _check_names("joint", [joint.name for joint in robot.joints])
    roots = root_links(robot)
    if len(roots) != 1:
        raise UrdfError(
            f"robot_description has the roots {', '.join(roots)}; one link must hang on no joint"
            if roots
            else "robot_description has no <link>; calls of macros need the prefix xacro:"
        )
    links = robot.link_map
    for name, link in links.items():
        owner = f"link '{name}'"
        inertial = link.inertial
        mass = number(inertial, "mass", owner, 0.0)
        if not 0.0 <= mass <= _HEAVIEST:
            raise UrdfError(f"{owner}: mass is {mass:g} kg; 0 to {_HEAVIEST:g} is needed")
        inertia = None if inertial is None else inertial.inertia
        if mass and inertia is None:
            raise UrdfError(f"{owner}: its <inertial> has no <inertia>; all of it may be 0")
        _check_inertia(owner, inertia)
        if inertial is not None:
            _check_place(f"{owner}: inertial", inertial.origin)
        for part in (*link.collisions, *link.visuals):
            where = f"{owner}: {part.XML_REFL.tag}"
            _check_place(where, part.origin)
            _check_shape(where, part.geometry)
    for joint in robot.joints:
        owner = f"joint '{joint.name}'"
        for which in ("parent", "child"):
            if getattr(joint, which) not in links:
                raise UrdfError(
                    f"{owner}: its {which} is '{getattr(joint, which)}', which is no link"
                )
        bare = joint.type == "fixed" and not links[joint.child].collisions
        if not (bare and _is_unfilled(joint.origin)):
            _check_place(owner, joint.origin)
        if joint.type not in _KINDS:
            raise UrdfError(
                f"{owner} has the type '{joint.type}'; simulated are {', '.join(_KINDS)}"
            )
        _check_numbers(owner, joint, "axis", 3)
        # Published files have axes of 0 0 0 at fixed joints.
        if joint.type != "fixed":
            _check_direction(owner, joint)


def _check_names(tag: str, names: List[str]) -> None:
    for name, count in Counter(names).items():
        if not name:
            raise UrdfError(f"robot_description has a <{tag}> without a name")
        _check_length(tag, name)
        if count > 1:
            raise UrdfError(f"robot_description has {count} {tag}s of the name '{name}'")


def _check_length(tag: str, name: str) -> None:
    size = len(name.encode())
    if size > _LONGEST_NAME:
        raise UrdfError(
            f"robot_description: the name of a <{tag}> is '{name[:40]}...', of {size} bytes; at "
            f"most {_LONGEST_NAME} are possible"
        )


def _check_inertia(owner: str, inertia: Optional[Inertia]) -> None:
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


def _is_unfilled(origin: Optional[Pose]) -> bool:
    """Whether its place is a macro's words: published files have such frames; PyBullet takes 0."""
    texts = [] if origin is None else [origin.xyz, origin.rpy]
    try:
        list(map(float, " ".join(text for text in texts if isinstance(text, str)).split()))
    except ValueError:
        return True
    return False


def _check_place(owner: str, origin: Optional[Pose]) -> None:
    if origin is not None:
        for key in ("xyz", "rpy"):
            _check_numbers(owner, origin, key, 3)


def _check_shape(owner: str, shape: Any) -> None:
    tag = shape.tag if isinstance(shape, UnknownShape) else shape and shape.XML_REFL.tag
    if tag not in _SIZES:
        known = ", ".join(_SIZES)
        said = "no shape" if shape is None else f"the shape <{tag}>"
        raise UrdfError(f"{owner} has {said} in its <geometry>; known are {known}")
    for key, count in _SIZES[tag].items():
        for value in numbers(shape, key, count, owner):
            if not 0.0 <= value <= _FARTHEST:
                raise UrdfError(f"{owner}: {key} is {value:g} m; 0 to {_FARTHEST:g} is needed")
    if isinstance(shape, Mesh):
        _check_numbers(owner, shape, "scale", 3)


def _check_direction(owner: str, joint: Joint) -> None:
    if joint.axis is None:
        return
    values = numbers(joint, "axis", 3, owner)
    if math.sqrt(sum(value * value for value in values)) < _SHORTEST_AXIS:
        said = " ".join(f"{value:g}" for value in values)
        raise UrdfError(f"{owner}: axis is {said}; a direction is needed")


def _check_numbers(owner: str, element: Any, key: str, count: int) -> None:
    if getattr(element, key) is None:
        return
    for value in numbers(element, key, count, owner):
        if abs(value) > _FARTHEST:
            tag, name = xml_name(element, key)
            raise UrdfError(
                f"{owner}: <{tag} {name}> has the value {value:g}; at most {_FARTHEST:g} is "
                "possible"
            )
