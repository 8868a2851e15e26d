"""Surfaces near a robot's tracks and hull that could carry them."""

from __future__ import annotations

from heapq import nsmallest
from typing import Any, Dict, Iterable, List, Sequence, Tuple

import numpy as np
import pybullet

from ..engine.world import Body
from .force_angle import ForceAngle, Vector
from .supports import NO_PLACES
from .tipping import CARRIES, LEVER, Footholds

TOUCHES = 0.02
"""Gap (m) up to which a foothold bears as a contact does: on edges of stairs, belts lose and find
their contacts from step to step.
"""
_NEAR = 0.3
"""Distance (m) up to which footholds are looked for."""
_MOST = 32
"""Footholds that are kept of a link on one body, the nearest."""
_BESIDE = 0.002
"""How far beside a belt (m) is looked for what its edge stands on: a ray that begins in the belt
would end there.
"""


class FootholdFinder:
    """Finds the footholds of one body.

    Parameters
    ----------
    belts : dict of int to tuple of 2 floats
        Tracks (PyBullet's numbers of links), and where each belt begins and ends along its axle,
        from the centre of mass (m).
    """

    def __init__(self, body: Body, belts: Dict[int, Tuple[float, float]]) -> None:
        self._body = body
        self._belts = belts

    def touching(
        self, centers: Dict[int, np.ndarray], axles: Dict[int, np.ndarray]
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Where tracks as good as touch the ground.

        PyBullet names one point for each pair of convex bodies, somewhere across the belt; both of
        its edges bear there if they have something under them.

        Parameters
        ----------
        centers, axles : dict of int to ndarray
            Centre of mass of each track (m), and unit vector along its axle, in the world.

        Returns
        -------
        places, begins, ends : ndarray, shape (n, 3)
            On the ground, under either edge of the belt; and where a ray beside it begins and ends
            that meets what is there (m).
        gaps : ndarray, shape (n,)
            m.
        """
        links: List[int] = []
        rows: List[Any] = []
        for link in self._belts:
            near = [
                row
                for row in self._near(link, TOUCHES)
                if row[8] < TOUCHES and row[7][2] >= CARRIES
            ]
            rows += near
            links += [link] * len(near)
        if not rows:
            return NO_PLACES, NO_PLACES, NO_PLACES, np.empty(0)
        points, grounds, normals, gaps = _footholds(rows)
        across = np.array([(centers[link], axles[link]) for link in links])
        axle = across[:, 1]
        aside = ((points - across[:, 0]) * axle).sum(axis=1, keepdims=True)
        edges = np.array([self._belts[link] for link in links]) - aside
        outside = np.add(edges, (-_BESIDE, _BESIDE))
        ground, axle = grounds[:, None], axle[:, None]
        places = (ground + edges[:, :, None] * axle).reshape(-1, 3)
        beside = ground + outside[:, :, None] * axle
        reach = TOUCHES * normals[:, None]
        begins, ends = (each.reshape(-1, 3) for each in (beside + reach, beside - reach))
        return places, begins, ends, gaps.repeat(2)

    def beyond(self, edges: Sequence[ForceAngle]) -> Footholds:
        """Footholds of the tracks and the hull that nothing touches yet.

        Parameters
        ----------
        edges : sequence of ForceAngle
            Over which the robot may tip: only what lies beyond one of them is looked at.
        """
        rows: List[Any] = []
        for link in dict.fromkeys((-1, *self._belts)):
            low, high = self._box(link)
            if any(_beyond(edge, low, high) for edge in edges):
                rows += self._near(link, _NEAR)
        found = _footholds(rows)
        return found.those((found.gaps >= TOUCHES) & (found.normals[:, 2] >= CARRIES))

    def _box(self, link: int) -> Tuple[Vector, Vector]:
        corners: Tuple[Vector, Vector] = pybullet.getAABB(
            self._body.uid, link, physicsClientId=self._body.client
        )
        return corners

    def _near(self, link: int, distance: float) -> List[Any]:
        """Closest points of a link on each body around, as PyBullet gives them."""
        uid, client = self._body.uid, self._body.client
        low, high = self._box(link)
        around = pybullet.getOverlappingObjects(
            [each - distance for each in low],
            [each + distance for each in high],
            physicsClientId=client,
        )
        found: List[Any] = []
        for other in sorted({other for other, _ in around or ()} - {uid}):
            points = pybullet.getClosestPoints(uid, other, distance, link, physicsClientId=client)
            # A mesh gives one for each of its triangles that is near.
            found += points if len(points) <= _MOST else nsmallest(_MOST, points, key=_gap)
        return found


def _beyond(edge: ForceAngle, low: Vector, high: Vector) -> bool:
    """Whether any of a box lies so far beyond an edge that it could catch the robot."""
    outer = sum(
        max(outward * (least - start), outward * (most - start))
        for outward, start, least, most in zip(edge.outward, edge.start, low, high)
    )
    return outer > LEVER


def _gap(point: Any) -> float:
    gap: float = point[8]
    return gap


def _footholds(rows: Iterable[Any]) -> Footholds:
    values = np.array([(*row[5], *row[6], *row[7], row[8]) for row in rows]).reshape(-1, 10)
    return Footholds(values[:, :3], values[:, 3:6], values[:, 6:9], values[:, 9])
