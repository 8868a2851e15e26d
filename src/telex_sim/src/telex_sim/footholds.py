"""What stands near a robot's tracks and hull, and could carry them."""

from __future__ import annotations

from heapq import nsmallest
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
import pybullet

from .stability import Vector
from .tipping import Foothold
from .world import Body

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


class Footholds:
    """Finds the footholds of one body.

    Parameters
    ----------
    body : Body
    half_widths : dict of int to float
        Tracks (PyBullet's numbers of links), and half the width of each belt (m).
    """

    def __init__(self, body: Body, half_widths: Dict[int, float]) -> None:
        self._body = body
        self._half_widths = half_widths

    def find(self, axles: Dict[int, np.ndarray]) -> List[Foothold]:
        """Footholds of the tracks and the hull, as they are now.

        PyBullet names one point for each pair of convex bodies, somewhere across the belt; where a
        belt as good as touches, both of its edges are footholds if they have something under them.

        Parameters
        ----------
        axles : dict of int to ndarray
            Unit vector along the axle of each track, in the world.
        """
        found: List[Foothold] = []
        edges: List[Tuple[Foothold, Vector]] = []
        for link in dict.fromkeys((-1, *self._half_widths)):
            for foothold in self._near(link):
                if foothold.gap >= TOUCHES:
                    found.append(foothold)
                elif link in self._half_widths:
                    edges += self._edges(foothold, link, axles[link])
        return found + self._on_something(edges)

    def _near(self, link: int) -> List[Foothold]:
        uid, client = self._body.uid, self._body.client
        low, high = pybullet.getAABB(uid, link, physicsClientId=client)
        around = pybullet.getOverlappingObjects(
            [each - _NEAR for each in low], [each + _NEAR for each in high], physicsClientId=client
        )
        others = {other for other, _ in around or ()} - {uid}
        found: List[Foothold] = []
        for other in sorted(others):
            points = pybullet.getClosestPoints(uid, other, _NEAR, link, physicsClientId=client)
            # A mesh gives one for each of its triangles that is near.
            found += nsmallest(
                _MOST, (Foothold(*point[5:9]) for point in points), key=lambda each: each.gap
            )
        return found

    def _edges(
        self, foothold: Foothold, link: int, axle: np.ndarray
    ) -> List[Tuple[Foothold, Vector]]:
        """The same foothold at both edges of the belt, and a place on the ground just beside it."""
        body, half = self._body, self._half_widths[link]
        if link < 0:
            origin = body.base_pose()[0]
        else:
            origin = pybullet.getLinkState(body.uid, link, physicsClientId=body.client)[4]
        aside = float(np.subtract(foothold.point, origin) @ axle)
        point, ground = foothold.point, foothold.ground
        return [
            (
                foothold._replace(
                    point=_moved(point, axle, side * half - aside),
                    ground=_moved(ground, axle, side * half - aside),
                ),
                _moved(ground, axle, side * (half + _BESIDE) - aside),
            )
            for side in (1.0, -1.0)
        ]

    def _on_something(self, edges: Sequence[Tuple[Foothold, Vector]]) -> List[Foothold]:
        """Those that have something under them."""
        if not edges:
            return []
        starts = [_moved(beside, each.normal, TOUCHES) for each, beside in edges]
        ends = [_moved(beside, each.normal, -TOUCHES) for each, beside in edges]
        hits = pybullet.rayTestBatch(starts, ends, physicsClientId=self._body.client)
        return [each for (each, _), hit in zip(edges, hits) if hit[0] not in (-1, self._body.uid)]


def _moved(point: Vector, direction: Any, by: float) -> Vector:
    x, y, z = (float(each + by * part) for each, part in zip(point, direction))
    return x, y, z
