"""Several joint references that follow a moving goal within velocity and acceleration limits."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import numpy as np

from telex_teleop.motion.reference import MotionLimits, stoppable_speed

# A reference nearer to its goal than this (rad or m) is set to the goal, at rest.
ARRIVED = 1e-9


class JointFollower:
    """Follows goals that come from inverse kinematics.

    Those keep velocity limits, but not acceleration limits: near a singularity, and where a limit
    makes other joints take over, they change their velocity from one tick to the next. Where that
    does not happen, reference and goal are the same; elsewhere the reference lags and catches up
    without overshooting a goal that moves evenly.

    Parameters
    ----------
    limits
        Of each joint. Its lead and tolerances are not looked at.
    """

    def __init__(self, limits: Sequence[MotionLimits]) -> None:
        self._limits = tuple(limits)
        self._goal = np.zeros(len(limits))
        self.references = np.zeros(len(limits))
        self.velocities = np.zeros(len(limits))

    @property
    def resting(self) -> bool:
        """Whether all references are where they were led, and stand still."""
        return not self.velocities.any() and bool(np.all(self.references == self._goal))

    def rest_at(self, positions: np.ndarray) -> None:
        """Start anew, at rest."""
        self._goal = np.array(positions, dtype=float)
        self.references = self._goal.copy()
        self.velocities = np.zeros(len(positions))

    def update(self, goal: np.ndarray, dt: float) -> np.ndarray:
        """Move the references by one step.

        Parameters
        ----------
        goal : ndarray, shape (n,)
            Where the joints should be now (rad or m).
        dt
            Time since the last step (s), above 0.

        Returns
        -------
        ndarray, shape (n,)
        """
        # Plain floats: on so few numbers, numpy's own calls cost several times as much.
        moved = [
            _step(limits, now, before, reference, velocity, dt)
            for limits, now, before, reference, velocity in zip(
                self._limits,
                goal.tolist(),
                self._goal.tolist(),
                self.references.tolist(),
                self.velocities.tolist(),
            )
        ]
        self._goal = np.array(goal, dtype=float)
        self.references = np.array([reference for reference, _ in moved])
        self.velocities = np.array([velocity for _, velocity in moved])
        return self.references


def _step(
    limits: MotionLimits, goal: float, before: float, reference: float, velocity: float, dt: float
) -> Tuple[float, float]:
    """Return reference and velocity of one joint after a step; its goal was `before`, is `goal`."""
    change = limits.max_acceleration * dt
    lag = before - reference
    goal_velocity = (goal - before) / dt
    catching_up = min(abs(lag) / dt, stoppable_speed(limits.max_acceleration, abs(lag), dt))
    wanted = goal_velocity + math.copysign(catching_up, lag)
    # A reference that is already outside may stay there, but goes no further.
    up = stoppable_speed(limits.max_acceleration, max(limits.upper - reference, 0.0), dt)
    down = stoppable_speed(limits.max_acceleration, max(reference - limits.lower, 0.0), dt)
    wanted = max(-down, min(up, wanted))
    wanted = max(-limits.max_velocity, min(limits.max_velocity, wanted))
    velocity = max(velocity - change, min(velocity + change, wanted))
    reference += velocity * dt
    if abs(goal - reference) <= ARRIVED and abs(goal - before) <= ARRIVED:
        # free of rounding, so that what rests is where it was led
        return goal, 0.0
    return reference, velocity
