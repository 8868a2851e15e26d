"""Room for a robot where it starts, and a place for a further one beside it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Callable, Iterator, Mapping, Optional, Tuple

import pybullet

from telex_control.common.params import ConfigError

from ..scene.model import Scene, Start
from .simulator_config import StartConfig
from .world import Body, World, WorldError

_DEEPEST = 0.005
"""Penetration (m) above which the contact forces of the first step would throw the robot."""

_OVERLAP = 0.01
"""How deep (m) a robot may stand in something where it is added: meshes are not exact."""

_BESIDE = ((0.0, 1.3), (0.0, -1.3), (-1.8, 0.0), (0.0, 2.6), (0.0, -2.6), (-1.8, 1.3), (-1.8, -1.3))
_FURTHER = ((-3.6, 0.0), (1.8, 1.3), (1.8, -1.3), (0.0, 3.9), (0.0, -3.9), (1.8, 0.0))
"""Places of further robots, the nearest first: m ahead of the scene's start, and to its left."""

_FAR = tuple((0.0, 1.3 * side * 2**number) for number in range(2, 10) for side in (1, -1))
"""Where else one may go that has to go somewhere."""

_LENGTH, _WIDTH, _SPACING = 1.5, 0.9, 0.15
"""Of the ground that must be level and free for one (m), and between looks at it."""

_ABOVE, _EYE, _LEVEL = 1.2, 0.4, 0.03
"""How far above the ground it must be free, and may be seen from the start; unevenness (m)."""


def start_in_scene(scene: Scene, config: StartConfig, number: int) -> Optional[Start]:
    """Return the start that a scene has for a further robot.

    Parameters
    ----------
    config : StartConfig
        The robot's.
    number : int
        Of the robot, from 1, where its configuration gives none.

    Returns
    -------
    Start, optional
        None: there is none for it, or the robot has a place of its own.
    """
    number = config.further or number
    if not config.looks_for_room or number > len(scene.robots):
        return None
    start = scene.robots[number - 1]
    return start if start.pose in config.poses else replace(start, pose="")


def place_beside(
    world: World, start: Start, robots: Mapping[int, str], load: Callable[[Start], Body], name: str
) -> Body:
    """Put a further robot beside the scene's start: on the same ground, and not behind a wall.

    Parameters
    ----------
    start : Start
        The scene's.
    robots : mapping of int to str
        Those that are there, by PyBullet's numbers.
    load : callable
        Puts it at a start into the world.
    name : str
        Of the robot, for the message.

    Raises
    ------
    ConfigError
        There is no room near the start.
    """
    for ahead, left in (*_BESIDE, *_FURTHER):
        x, y = _turned(start.yaw, ahead, left)
        place = replace(start, x=start.x + x, y=start.y + y)
        if not _is_open(world.client, start, place, robots):
            continue
        before = world.bodies()
        body = load(place)
        if world.overlap(body, _OVERLAP) is None:
            return body
        world.remove_others(before)
    raise ConfigError(
        f"{name} finds no room beside the scene's start; start/place (x, y, z, heading) says where "
        "it starts"
    )


def move_aside(world: World, body: Body, yaw: float) -> None:
    """Move a robot to the nearest place at its height where it stands in nothing.

    Parameters
    ----------
    yaw : float
        Direction (rad) that counts as ahead.
    """
    client = world.client
    (x, y, z), orientation = pybullet.getBasePositionAndOrientation(
        body.uid, physicsClientId=client
    )
    for ahead, left in (*_BESIDE, *_FURTHER, *_FAR):
        dx, dy = _turned(yaw, ahead, left)
        place = (x + dx, y + dy, z)
        pybullet.resetBasePositionAndOrientation(
            body.uid, place, orientation, physicsClientId=client
        )
        if world.overlap(body, _OVERLAP) is None:
            return


def _turned(yaw: float, ahead: float, left: float) -> Tuple[float, float]:
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * ahead - sine * left, sine * ahead + cosine * left


def _is_open(client: int, start: Start, place: Start, robots: Mapping[int, str]) -> bool:
    """Tell whether a place is level and free, and nothing but robots stands before the start."""
    ground = start.ground
    spots = [
        (place.x + x, place.y + y)
        for x, y in itertools.starmap(
            lambda ahead, left: _turned(place.yaw, ahead, left),
            itertools.product(_steps(_LENGTH), _steps(_WIDTH)),
        )
    ]
    hits = pybullet.rayTestBatch(
        [(x, y, ground + _ABOVE) for x, y in spots],
        [(x, y, ground - 1.0) for x, y in spots],
        physicsClientId=client,
    )
    if not all(uid >= 0 and abs(point[2] - ground) <= _LEVEL for uid, _, _, point, _ in hits):
        return False
    eye = ground + _EYE
    (seen,) = pybullet.rayTest(
        (place.x, place.y, eye), (start.x, start.y, eye), physicsClientId=client
    )
    return seen[0] < 0 or seen[0] in robots


def _steps(length: float) -> Iterator[float]:
    count = round(length / _SPACING)
    return (_SPACING * (number - 0.5 * count) for number in range(count + 1))


def check_place(world: World, body: Body, owners: Mapping[int, str], name: str) -> None:
    """Refuse a further robot that would stand in something.

    Parameters
    ----------
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
