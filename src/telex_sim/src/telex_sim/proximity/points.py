"""PyBullet's closest points, put right.

Where one body is made of several parts and the other is not, and for some pairs of parts, PyBullet
(3.2.7) confuses the sides: it tells the point on the second body as that on the first, with a
normal that points the other way. Of two links in a query, some parts may be told right and others
wrong. Nothing in its answer says so, so that each point is looked at: on which body does it lie?
Bodies of several parts that are centimetres deep in each other remain undecided; the contacts of
the simulation keep them from it.
"""

from __future__ import annotations

from typing import Any, List, NamedTuple, Sequence, Tuple

import pybullet

from ..engine.world import Vector
from .geometry import Box, inside

_PLACES_OF_PAIR = 3
"""Of two links, so many of the nearest places count: each link is made of convex parts."""
_SLACK = 1e-3
"""How far beyond its box a point of a body may be (m): shapes have a margin."""
_STEP = 2e-3
"""How far from a point it is tried on which side of it a body is (m)."""
_PROBE = 1e-3
"""Radius of the ball that it is tried with (m)."""


class ClosestPoint(NamedTuple):
    """Two points on the surfaces of two bodies (m, in the world), nearest to each other.

    The normal, a unit vector, leads from the second body to the first. The distance (m) is below 0
    when they are inside each other.
    """

    distance: float
    point: Vector
    normal: Vector


class ClosestPoints:
    """Finds them.

    Parameters
    ----------
    client : int
        PyBullet's.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self._probe = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=_PROBE, physicsClientId=client
        )

    def find(
        self,
        first: Tuple[int, int],
        second: Tuple[int, int],
        reach: float,
        boxes: Tuple[Box, Box],
    ) -> List[ClosestPoint]:
        """Return the closest points of some parts of two links, the nearest first.

        Parameters
        ----------
        first, second : tuple of 2 int
            Body and link.
        reach : float
            Largest distance (m).
        boxes : tuple of 2 boxes
            Around them.
        """
        points = pybullet.getClosestPoints(
            first[0], second[0], reach, first[1], second[1], physicsClientId=self._client
        )
        nearest = sorted(points, key=lambda point: point[8])[:_PLACES_OF_PAIR]
        return [self._right(first, boxes, point) for point in nearest]

    def _right(
        self, first: Tuple[int, int], boxes: Tuple[Box, Box], told: Sequence[Any]
    ) -> ClosestPoint:
        point, other, normal, distance = told[5:9]
        if self._is_confused(first, boxes, told):
            return ClosestPoint(distance, other, (-normal[0], -normal[1], -normal[2]))
        return ClosestPoint(distance, point, normal)

    def _is_confused(
        self, first: Tuple[int, int], boxes: Tuple[Box, Box], told: Sequence[Any]
    ) -> bool:
        point, other = told[5], told[6]
        if not (inside(point, boxes[0], _SLACK) and inside(other, boxes[1], _SLACK)):
            return True
        if not (inside(point, boxes[1], _SLACK) and inside(other, boxes[0], _SLACK)):
            return False
        return self._is_confused_within_boxes(first, told)

    def _is_confused_within_boxes(self, first: Tuple[int, int], told: Sequence[Any]) -> bool:
        """Whether the normal, which is to lead into the first body, leads out of it."""
        ahead, behind = (self._outside(first, told, offset) for offset in (_STEP, -_STEP))
        return ahead > behind

    def _outside(self, link: Tuple[int, int], told: Sequence[Any], offset: float) -> float:
        """How far from a link a place is that lies along the normal from the first point (m)."""
        point, normal, distance = told[5], told[7], told[8]
        far = abs(distance) + 4.0 * _STEP
        found = pybullet.getClosestPoints(
            bodyA=link[0],
            linkIndexA=link[1],
            bodyB=-1,
            distance=far,
            collisionShapeB=self._probe,
            collisionShapePositionB=[value + offset * along for value, along in zip(point, normal)],
            physicsClientId=self._client,
        )
        return min((each[8] for each in found), default=far)
