"""Check that there is room for a robot where it starts."""

from __future__ import annotations

from typing import Callable, Mapping

import pybullet

from telex_control.common.params import ConfigError

from .world import Body, World, WorldError

_DEEPEST = 0.005
"""Penetration (m) above which the contact forces of the first step would throw the robot."""

_OVERLAP = 0.01
"""How deep (m) a robot may stand in something where it is added: meshes are not exact."""


def check_place(world: World, body: Body, owners: Mapping[int, str], name: str) -> None:
    """Refuse a further robot that would stand in something.

    Parameters
    ----------
    world : World
    body : Body
    owners : mapping of int to str
        What each body is of, in words, by PyBullet's number; not the floor.
    name : str
        Of the robot, for the message.

    Raises
    ------
    ConfigError
    """
    touched = world.overlap(body, _OVERLAP)
    if touched is None:
        return
    owner = owners.get(touched, "the ground")
    raise ConfigError(
        f"{name} would stand in {owner}; start/place (x, y, z, heading) says where it starts"
    )


def check_start(body: Body, pose: str, name_of: Callable[[int], str]) -> None:
    """Refuse a start in which the robot stands in itself or in something else.

    Parameters
    ----------
    body : Body
    pose : str
        Name of its start pose, for the message.
    name_of : callable
        Name of another body by PyBullet's identifier.

    Raises
    ------
    WorldError
        Two shapes overlap by more than 5 mm; the message names them.
    """
    pybullet.performCollisionDetection(physicsClientId=body.client)
    contacts = pybullet.getContactPoints(body.uid, physicsClientId=body.client)
    if not contacts:
        return
    deepest = min(contacts, key=lambda contact: contact[8])
    depth = -deepest[8]
    if depth <= _DEEPEST:
        return
    links = {index: name for name, index in body.links.items()}
    own, other = (deepest[3], deepest[4]) if deepest[1] == body.uid else (deepest[4], deepest[3])
    uid = deepest[2] if deepest[1] == body.uid else deepest[1]
    place = f"its {links[other]}" if uid == body.uid else name_of(uid)
    raise WorldError(
        f"start pose '{pose}': the robot's {links[own]} stands {1000.0 * depth:.0f} mm deep in "
        f"{place}; another pose, place or variant is needed"
    )
