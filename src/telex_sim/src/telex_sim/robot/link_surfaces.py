"""The surfaces of a robot's links: friction, and how wheels give way."""

from __future__ import annotations

import math
from typing import Dict, FrozenSet, List, Optional, Set, Tuple
from xml.etree import ElementTree

import pybullet

from telex_control.urdf.joints import CONTINUOUS, MOVABLE
from telex_control.urdf.mimic import mimics
from telex_control.urdf.model import Cylinder, Link, Mesh, Robot, Sphere, UrdfError
from telex_control.urdf.transmission_parser import interfaces

from ..engine.simulator_config import HardwareConfig
from ..engine.world import Body

_ROUND = (Cylinder, Sphere, Mesh)
"""Collision shapes that can roll."""


class LinkSurfaces:
    """What PyBullet has to be told of a robot's links.

    Raises
    ------
    UrdfError
        See `frictions`.
    """

    def __init__(self, robot: Robot, config: HardwareConfig) -> None:
        wheel = config.wheel_contact
        soft = {"contactStiffness": wheel.stiffness, "contactDamping": wheel.damping}
        self._dynamics: Dict[str, Dict[str, float]] = {link: dict(soft) for link in wheels(robot)}
        for link, friction in frictions(robot).items():
            self._dynamics.setdefault(link, {})["lateralFriction"] = friction
        for link, contact in config.contacts.items():
            values = self._dynamics.setdefault(link, {})
            values["spinningFriction"] = contact.spinning_friction
            values["frictionAnchor"] = contact.friction_anchor
            if contact.friction is not None:
                values["lateralFriction"] = contact.friction
            if contact.stiffness is not None and contact.damping is not None:
                values["contactStiffness"] = contact.stiffness
                values["contactDamping"] = contact.damping

    def apply(self, body: Body) -> None:
        """Tell it PyBullet, of a body in a new world."""
        for link, values in self._dynamics.items():
            if link in body.links:
                pybullet.changeDynamics(
                    body.uid, body.links[link], physicsClientId=body.client, **values
                )


def wheels(robot: Robot) -> FrozenSet[str]:
    """Links that can roll: of a continuous joint, round, and carrying no further joint.

    Those of drive wheels and of casters alike, whoever drives them. Left out are wheels whose URDF
    has a stiffness of its own (``<contact>``, which PyBullet reads), and what is commanded by
    position, such as an arm's wrist, or mimics another joint, such as a fingertip.
    """
    links = robot.link_map
    carriers: Set[str] = set()
    fixed: List[Tuple[str, str]] = []
    turned: Set[str] = set()
    held = set(mimics(robot))
    held.update(name for name, by in interfaces(robot).items() if by == "PositionJointInterface")
    for joint in robot.joints:
        if joint.type in MOVABLE:
            carriers.add(joint.parent)
        else:
            fixed.append((joint.parent, joint.child))
        if joint.type == CONTINUOUS and joint.name not in held:
            turned.add(joint.child)
    while True:
        # What a link carries by fixed joints is part of it.
        more = {above for above, below in fixed if below in carriers} - carriers
        if not more:
            break
        carriers |= more
    return frozenset(
        name
        for name in turned - carriers
        if name in links
        and not _has_own(links[name], "stiffness")
        and any(isinstance(each.geometry, _ROUND) for each in links[name].collisions)
    )


def _has_own(link: Link, name: str) -> bool:
    """Whether a link's ``<contact>``, which PyBullet reads, has an element."""
    return link.contact is not None and link.contact.find(name) is not None


def frictions(robot: Robot) -> Dict[str, float]:
    """Friction coefficients that ``<gazebo reference="…">`` gives links: the mean of mu1 and mu2.

    A link whose ``<contact>`` has one for PyBullet keeps that.

    Raises
    ------
    UrdfError
        One is not a number, or below 0.
    """
    own = {link.name for link in robot.links if _has_own(link, "lateral_friction")}
    found: Dict[str, float] = {}
    for gazebo in robot.gazebos:
        link = gazebo.get("reference", "")
        values = [_coefficient(gazebo, link, name) for name in ("mu1", "mu2")]
        given = [value for value in values if value is not None]
        if given and link not in own:
            found[link] = sum(given) / len(given)
    return found


def _coefficient(gazebo: ElementTree.Element, link: str, name: str) -> Optional[float]:
    element = gazebo.find(name)
    if element is None:
        return None
    text = element.get("value") or (element.text or "").strip()
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise UrdfError(
            f"<gazebo reference=\"{link}\">: <{name}> is '{text}'; a number from 0 on is needed"
        )
    return value
