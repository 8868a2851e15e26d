"""Flies the instructor's camera about the robot."""

from __future__ import annotations

import math
from typing import Optional

import numpy as np

from ..cameras_config import FIXED, FOLLOW, ViewConfig
from ..preview.still import looking


class OverviewRig:
    """Goes smoothly where it is sent, and along with what it follows.

    Parameters
    ----------
    smoothing
        Time constant of its movements (s); 0: none.
    """

    def __init__(self, view: ViewConfig, smoothing: float) -> None:
        # Replaced as a whole by ROS's thread.
        self.view = view
        self._smoothing = smoothing
        self._time: Optional[float] = None
        self._turned = 0.0
        self._of: Optional[ViewConfig] = None
        # Centre (m), azimuth in the world (rad), elevation (rad), distance (m).
        self._place = np.zeros(6)

    def pose(self, followed_in_world: np.ndarray, now: float) -> np.ndarray:
        """Where the camera is now.

        Parameters
        ----------
        followed_in_world
            Pose of the link that is followed, shape (4, 4).
        now
            Monotonic time (s), not before that of the last call.

        Returns
        -------
        numpy.ndarray
            Pose of the optical frame in the world, shape (4, 4).
        """
        view = self.view
        passed = 0.0 if self._time is None else now - self._time
        if view is not self._of:
            self._turned = 0.0
        self._turned += view.turn_rate * passed
        wanted = self._wanted(view, followed_in_world)
        if self._time is None or self._smoothing == 0.0:
            self._place = wanted
        else:
            ahead = wanted - self._place
            ahead[3] = math.remainder(ahead[3], 2.0 * math.pi)
            self._place = self._place - math.expm1(-passed / self._smoothing) * ahead
        self._time, self._of = now, view
        center, (azimuth, elevation, distance) = self._place[:3], self._place[3:]
        level = math.cos(elevation)
        out = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])
        return looking((center + distance * out).tolist(), center.tolist())

    def _wanted(self, view: ViewConfig, followed: np.ndarray) -> np.ndarray:
        center, azimuth = np.array(view.center), view.azimuth + self._turned
        if view.mode == FOLLOW:
            heading = math.atan2(followed[1, 0], followed[0, 0])
            sine, cosine = math.sin(heading), math.cos(heading)
            azimuth += heading
            center = center @ [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]
        if view.mode != FIXED:
            center = center + followed[:3, 3]
        return np.array([*center, azimuth, view.elevation, view.distance])
