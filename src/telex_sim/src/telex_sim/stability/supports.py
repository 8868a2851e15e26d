"""Supports of a robot, as far as they matter for its stability."""

from __future__ import annotations

from typing import Dict, List, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from ..engine.world import Body
from .force_angle import Vector, support_polygon

NO_PLACES = np.empty((0, 3))

_Ray = Tuple[List[float], List[float]]


class Supports:
    """Points that hold a robot up, and others that do if a ray meets something below them.

    Rays take long: they are sent for those only that would be corners of the support polygon.

    Parameters
    ----------
    body : Body
        The robot's; rays that meet it meet nothing.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        self._points: List[Vector] = []
        self._rays: Dict[Vector, _Ray] = {}
        self._polygon: Optional[List[Vector]] = []

    def add(self, points: Sequence[Vector]) -> None:
        """Take points that hold it up (m)."""
        if points:
            self._points += points
            self._polygon = None

    def add_likely(self, points: np.ndarray, begins: np.ndarray, ends: np.ndarray) -> None:
        """Take points that hold it up if a ray meets something.

        Parameters
        ----------
        points, begins, ends : ndarray, shape (n, 3)
            The points, and where each one's ray begins and ends (m).
        """
        found: List[Vector] = [(x, y, z) for x, y, z in points.tolist()]
        self._rays.update(zip(found, zip(begins.tolist(), ends.tolist())))
        self.add(found)

    def polygon(self) -> List[Vector]:
        """Return the support polygon, see `telex_sim.stability.force_angle.support_polygon`.

        What lies inside it is forgotten: with further points it lies inside, too.
        """
        while self._polygon is None:
            corners = support_polygon(self._points)
            likely = [corner for corner in corners if corner in self._rays]
            missed = self._missed(likely)
            if missed:
                self._points = [point for point in self._points if point not in missed]
            else:
                self._points, self._polygon = list(corners), corners
        return self._polygon

    def _missed(self, likely: Sequence[Vector]) -> Set[Vector]:
        """Those that have nothing below them."""
        if not likely:
            return set()
        begins, ends = zip(*(self._rays.pop(point) for point in likely))
        hits = pybullet.rayTestBatch(begins, ends, physicsClientId=self._body.client)
        return {point for point, hit in zip(likely, hits) if hit[0] in (-1, self._body.uid)}
