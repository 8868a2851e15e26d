"""Bodies of a world that stand in each other.

The first step would throw them apart, and where many stand in one place it would take seconds.
Only the thread that owns the PyBullet client may use what is here.
"""

from __future__ import annotations

from typing import Callable, Iterable, List, NamedTuple, Set, Tuple

import pybullet

DEEPEST = 0.005
"""Depth (m) to which things may be in each other."""
MOST_NAMED = 10
"""Pairs that a message names."""


class Overlap(NamedTuple):
    """Two bodies that stand in each other.

    Attributes
    ----------
    first, second : int
        PyBullet's numbers.
    depth : float
        m.
    """

    first: int
    second: int
    depth: float


def overlaps(
    client: int,
    bodies: Iterable[int],
    matter: Callable[[int, int], bool],
    moves: Callable[[int, int], bool],
    most: int = MOST_NAMED,
) -> List[Overlap]:
    """Find bodies that stand more than 5 mm in another one, where at least one of them moves.

    Parameters
    ----------
    client : int
        PyBullet's.
    bodies : iterable of int
        Whose surroundings are looked at.
    matter : callable
        Whether two bodies (PyBullet's numbers) must not stand in each other.
    moves : callable
        Whether a link of a body (PyBullet's numbers) can move.
    most : int
        It stops as soon as so many are found: of hundreds in one place, each is in each.
    """
    found: List[Overlap] = []
    seen: Set[Tuple[int, int]] = set()
    for body in bodies:
        for other in sorted(neighbours(client, body)):
            pair = (min(body, other), max(body, other))
            if other == body or pair in seen or not matter(body, other):
                continue
            seen.add(pair)
            depth = _depth(client, body, other, moves)
            if depth > DEEPEST:
                found.append(Overlap(body, other, depth))
                if len(found) >= most:
                    return found
    return found


def neighbours(client: int, body: int) -> Set[int]:
    """All bodies whose bounding boxes meet those of a body."""
    found: Set[int] = set()
    for link in range(-1, pybullet.getNumJoints(body, physicsClientId=client)):
        low, high = pybullet.getAABB(body, link, physicsClientId=client)
        near = pybullet.getOverlappingObjects(low, high, physicsClientId=client)
        found.update(uid for uid, _ in near or ())
    return found


def _depth(client: int, body: int, other: int, moves: Callable[[int, int], bool]) -> float:
    points = pybullet.getClosestPoints(body, other, 0.0, physicsClientId=client)
    depths = [
        -point[8] for point in points if moves(point[1], point[3]) or moves(point[2], point[4])
    ]
    return max(depths, default=0.0)
