"""Pose of the base in the world, between its reports."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from telex_teleop.motion.rigid_motion import advanced, pose_error


class BasePose:
    """The base's pose, carried on at its last velocity.

    Reports come less often than joint states; without that the tool would follow in steps.

    Parameters
    ----------
    max_age
        A report older than this (s of sim time) counts as none. One that is older by more than this
        than the one before it begins anew: the stamp of the one before was wrong.
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
            if -self._max_age <= elapsed <= 0.0:
                return
            if 0.0 < elapsed <= self._max_age:
                self._velocity = pose_error(pose, self._last[1]) / elapsed
        self._last = (stamp, pose)

    def forget(self) -> None:
        """Forget it, because the robot was put somewhere else."""
        self._last = None
        self._velocity = np.zeros(6)

    def at(self, stamp: float, ahead: float = 0.0) -> Optional[np.ndarray]:
        """Return the pose (4x4) in some time, None where no report is fresh enough.

        Parameters
        ----------
        stamp
            Present sim time (s).
        ahead
            So much later (s).
        """
        if self._last is None:
            return None
        age = stamp - self._last[0]
        if abs(age) > self._max_age:
            return None
        return advanced(self._last[1], self._velocity * (age + ahead))

    def twist(self, stamp: float) -> Optional[np.ndarray]:
        """Return linear and angular velocity (m/s, rad/s) along the base's own axes, shape (6,).

        None where no report is fresh enough at `stamp` (s of sim time).
        """
        if self._last is None or abs(stamp - self._last[0]) > self._max_age:
            return None
        turn = self._last[1][:3, :3].T
        return np.concatenate([turn @ self._velocity[:3], turn @ self._velocity[3:]])
