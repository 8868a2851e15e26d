"""Moves the arm's joints to a named pose, all of them together, while a key is held."""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

import numpy as np

from telex_teleop.motion.reference import MotionLimits, stoppable_speed

# The largest joint distance that counts as arrived (rad or m).
ARRIVED = 1e-6


class PathMotion:
    """Leads several references along a straight line in joint space.

    All joints start and end together; the slowest one sets the pace. Progress is measured in time
    at full speed, so that velocity and acceleration limits of all joints become two numbers.

    Parameters
    ----------
    joints
        Names, in the order of all arrays.
    limits
        Of each joint.
    """

    def __init__(self, joints: Sequence[str], limits: Sequence[MotionLimits]) -> None:
        self._joints = tuple(joints)
        self._velocity_limits = np.array([each.max_velocity for each in limits])
        self._leads = np.array([each.max_lead for each in limits])
        # share of full speed gained per second
        gains = [each.max_acceleration / each.max_velocity for each in limits]
        self._gain = min(gains, default=math.inf)
        self._references: Optional[np.ndarray] = None
        self._pose = ""
        self._goal: Optional[np.ndarray] = None
        self._share = 0.0

    @property
    def moving(self) -> bool:
        """Whether it is on its way, or still comes to rest."""
        return self._references is not None

    @property
    def pose(self) -> str:
        """Name of the pose that it moves to, empty while it does not move."""
        return self._pose if self.moving else ""

    def drop(self) -> None:
        """Stop at once and forget where it was going."""
        self._references = None
        self._goal = None
        self._share = 0.0

    def wanted_rates(self, speed_scale: float) -> np.ndarray:
        """Return the rates (per second) that the joints would have at the operator's speed."""
        if self._references is None or self._goal is None:
            return np.zeros(len(self._joints))
        way = self._goal - self._references
        left = float(np.max(np.abs(way) / self._velocity_limits))
        return way if left == 0.0 else way / left * speed_scale

    def begin(self, pose: str, start: np.ndarray, goal: np.ndarray) -> None:
        """Set out from rest at `start` for a pose; a pose that is under way goes on."""
        if self.moving:
            return
        self._pose = pose
        self._references = np.array(start, dtype=float)
        self._goal = np.array(goal, dtype=float)
        self._share = 0.0

    def update(
        self, dt: float, positions: np.ndarray, speed: float
    ) -> Tuple[Optional[np.ndarray], str]:
        """Move the references by one step.

        Parameters
        ----------
        dt
            Time since the last step (s), above 0.
        positions : ndarray, shape (n,)
            Measured (rad or m).
        speed
            Share of full speed that is wanted, 0 to come to rest.

        Returns
        -------
        references, held_back
            The references, None when it has come to rest; name of a joint that something holds
            back, or empty.
        """
        if self._references is None or self._goal is None:
            return None, ""
        way = self._goal - self._references
        left = float(np.max(np.abs(way) / self._velocity_limits))
        if (self._share == 0.0 and speed == 0.0) or float(np.max(np.abs(way))) <= ARRIVED:
            self.drop()
            return None, ""
        change = self._gain * dt
        wanted = min(speed, stoppable_speed(self._gain, left, dt))
        share = max(self._share - change, min(self._share + change, wanted))
        # the last step ends on the goal itself
        step = way * min(1.0, share * dt / left)
        ahead = np.abs(self._references + step - positions)
        behind = ahead > np.maximum(self._leads, np.abs(self._references - positions))
        if behind.any():
            self._share = 0.0
            return self._references, self._joints[int(np.argmax(behind))]
        self._share = share
        self._references = self._references + step
        return self._references, ""
