"""Where the base stands in the world, between the reports of it."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from telex_teleop.rigid_motion import advanced, pose_error

__all__ = ["BasePose"]


class BasePose:
    """The base's pose, carried on at its last velocity.

    Reports come less often than joint states; without that the tool would follow in steps.

    Parameters
    ----------
    max_age
        A report older than this (s of sim time) counts as none.
    """

    def __init__(self, max_age: float) -> None:
        self._max_age = max_age
        self._last: Optional[Tuple[float, np.ndarray]] = None
        self._velocity = np.zeros(6)

    def take(self, stamp: float, pose: np.ndarray) -> None:
        """Take a report.

        Parameters
        ----------
        stamp
            Its sim time (s).
        pose : ndarray, shape (4, 4)
            Of the base in the world.
        """
        self._velocity = np.zeros(6)
        if self._last is not None:
            elapsed = stamp - self._last[0]
            if elapsed <= 0.0:
                return
            if elapsed <= self._max_age:
                self._velocity = pose_error(pose, self._last[1]) / elapsed
        self._last = (stamp, pose)

    def forget(self) -> None:
        """Forget it, because the robot was put somewhere else."""
        self._last = None
        self._velocity = np.zeros(6)

    def at(self, stamp: float) -> Optional[np.ndarray]:
        """Return the pose (4x4) at a sim time (s), None where no report is fresh enough."""
        if self._last is None:
            return None
        age = stamp - self._last[0]
        if abs(age) > self._max_age:
            return None
        return advanced(self._last[1], self._velocity * age)
