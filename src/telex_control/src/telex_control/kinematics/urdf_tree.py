"""Frames, axes and inertias of a URDF: the tree of its links, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Iterator, List, Optional, Tuple

from telex_control.urdf.elements import (
    Origin,
    UrdfError,
    Vector,
    number,
    origin,
    root_links,
    vector,
)
from telex_control.urdf.joints import MOVABLE, parse_urdf
from telex_control.urdf.model import Joint, Link, Robot

FIXED = "fixed"


class KinematicsError(UrdfError):
    """A robot description has no such kinematics; the message names the element and says why."""


@dataclass(frozen=True)
class LinkInertia:
    """URDF ``<inertial>``.

    Attributes
    ----------
    origin : Origin
        Centre of mass and axes of `inertia`, in the link's frame.
    mass : float
        kg.
    inertia : tuple of 6 floats
        ixx, iyy, izz, ixy, ixz, iyz about the centre of mass (kg m2).
    """

    origin: Origin
    mass: float
    inertia: Tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class TreeJoint:
    """A joint and the link that it carries.

    Attributes
    ----------
    kind : str
        ``revolute``, ``continuous``, ``prismatic`` or ``fixed``.
    origin : Origin
        Of the joint and its child's frame at position 0, in the parent's frame.
    axis : tuple of 3 floats
        Unit vector in the child's frame; positive positions turn about it, or move along it.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Origin
    axis: Vector


class UrdfTree:
    """The links of a robot, each but one carried by a joint.

    Parameters
    ----------
    robot : Robot
        See `telex_control.urdf.joints.parse_urdf`.

    Attributes
    ----------
    root : str
        The link that no joint carries.
    inertials : dict of str to LinkInertia or None
        By link.
    joint_above : dict of str to TreeJoint
        By the link that it carries.

    Raises
    ------
    KinematicsError, telex_control.urdf.elements.UrdfError
        The links form no tree, a joint is of another kind, or a number is wrong.
    """

    def __init__(self, robot: Robot) -> None:
        self.inertials: Dict[str, Optional[LinkInertia]] = {
            name: _inertial(link, f"link '{name}'") for name, link in robot.link_map.items()
        }
        self.joint_above: Dict[str, TreeJoint] = {}
        self._below: Dict[str, List[TreeJoint]] = {link: [] for link in self.inertials}
        for joint in robot.joints:
            self._add(_joint(joint))
        roots = root_links(robot)
        if len(roots) != 1:
            raise KinematicsError(
                f"robot_description has the roots {', '.join(roots) or 'none'}; one link, and "
                "only one, must be without a joint that carries it"
            )
        self.root = roots[0]
        reached = 1 + sum(1 for _ in self.joints())
        if reached != len(self.inertials):
            raise KinematicsError(
                f"robot_description: only {reached} of {len(self.inertials)} links hang on "
                f"'{self.root}'; the others form a loop"
            )

    @classmethod
    def from_urdf(cls, urdf: str) -> UrdfTree:
        """Make the tree from the text of a URDF; see the class."""
        return cls(parse_urdf(urdf))

    def _add(self, joint: TreeJoint) -> None:
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in self.inertials:
                raise KinematicsError(
                    f"joint '{joint.name}': there is no link '{link}', its {role}"
                )
        other = self.joint_above.get(joint.child)
        if other is not None:
            raise KinematicsError(
                f"link '{joint.child}' is carried by two joints, '{other.name}' and '{joint.name}'"
            )
        self.joint_above[joint.child] = joint
        self._below[joint.parent].append(joint)

    def joints(self) -> Iterator[TreeJoint]:
        """Yield all joints, a parent's before its children's, else in the order of the file."""
        waiting = self._below[self.root][::-1]
        while waiting:
            joint = waiting.pop()
            yield joint
            waiting.extend(self._below[joint.child][::-1])

    def path(self, base: str, tip: str) -> List[TreeJoint]:
        """Return the joints that lead from the link `base` out to the link `tip`.

        Raises
        ------
        KinematicsError
            One of them is not there, or `tip` does not hang on `base`.
        """
        for link in (base, tip):
            if link not in self.inertials:
                raise KinematicsError(f"the robot has no link '{link}'")
        found: List[TreeJoint] = []
        link = tip
        while link != base:
            joint = self.joint_above.get(link)
            if joint is None:
                raise KinematicsError(f"link '{tip}' does not hang on link '{base}'")
            found.append(joint)
            link = joint.parent
        return found[::-1]


def _joint(joint: Joint) -> TreeJoint:
    name, kind = joint.name, joint.type
    if kind not in (*MOVABLE, FIXED):
        raise KinematicsError(
            f"joint '{name}' is of type '{kind}'; {', '.join((*MOVABLE, FIXED))} are possible"
        )
    where = f"joint '{name}'"
    axis = (1.0, 0.0, 0.0)
    if kind != FIXED:
        axis = vector(joint, "axis", where, axis)
        length = math.sqrt(sum(value * value for value in axis))
        if length < 1e-9:
            raise KinematicsError(f"{where}: axis is {axis}; a direction is needed")
        axis = (axis[0] / length, axis[1] / length, axis[2] / length)
    return TreeJoint(
        name=name,
        kind=kind,
        parent=_link_of(joint, "parent", where),
        child=_link_of(joint, "child", where),
        origin=origin(joint, where),
        axis=axis,
    )


def _link_of(joint: Joint, role: str, where: str) -> str:
    found: str = getattr(joint, role)
    if not found:
        raise KinematicsError(f'{where} has no <{role} link="...">')
    return found


def _inertial(link: Link, where: str) -> Optional[LinkInertia]:
    inertial = link.inertial
    if inertial is None:
        return None
    inertia = inertial.inertia
    if inertial.mass is None or inertia is None:
        raise KinematicsError(f'{where}: its <inertial> needs <mass value="..."> and <inertia>')
    moments = [number(inertia, key, where) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
    return LinkInertia(
        origin=origin(inertial, where),
        mass=number(inertial, "mass", where),
        inertia=(moments[0], moments[1], moments[2], moments[3], moments[4], moments[5]),
    )
