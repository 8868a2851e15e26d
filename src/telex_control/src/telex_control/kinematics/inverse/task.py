"""Tasks and results of the inverse kinematics, as plain data."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .options import Tolerance


class Task(NamedTuple):
    """A target, and what of it is asked for. Only arrays and numbers: compiled code takes it.

    Attributes
    ----------
    target : ndarray, shape (4, 4)
        Of the tip in the base frame (m).
    bounds : ndarray, shape (6,)
        Along and about the target's axes (m, rad), within which there is no error.
    bounded : bool
        Any of the bounds is above 0.
    free_axis : int
        Of the target, about which alone the rotation is free; -1 when there is none. The
        orientation error is then the angle between this axis and the tip's.
    length_weight : float
        rad/m.
    position, rotation : float
        Norms of the error (m, rad) at which the target is reached.
    """

    target: np.ndarray
    bounds: np.ndarray
    bounded: bool
    free_axis: int
    length_weight: float
    position: float
    rotation: float


class TaskShape(NamedTuple):
    """A `Task` without target: made once for each tolerance."""

    bounds: np.ndarray
    bounded: bool
    free_axis: int
    length_weight: float
    position: float
    rotation: float

    @classmethod
    def of(cls, tolerance: Tolerance, length_weight: float) -> TaskShape:
        """Make the shape of a tolerance."""
        bounds = np.array([*tolerance.position_bounds, *tolerance.rotation_bounds], dtype=float)
        free = [axis for axis in range(3) if math.isinf(bounds[3 + axis])]
        return cls(
            bounds,
            bool(bounds.any()),
            free[0] if len(free) == 1 else -1,
            float(length_weight),
            float(tolerance.position),
            float(tolerance.rotation),
        )

    def at(self, target: np.ndarray) -> Task:
        """Make the task of a target."""
        return Task(target, *self)


class GoalFunction(NamedTuple):
    """A secondary goal: what is to be small.

    Attributes
    ----------
    kind : int
        `DISTANCE` or `SINGULARITY`.
    reference, scale : ndarray, shape (n,)
        Of the distance: half the sum of ((q - reference) / scale)^2; joints of scale inf are out.
    """

    kind: int
    reference: np.ndarray
    scale: np.ndarray


DISTANCE, SINGULARITY = 0, 1


class SearchOutcome(NamedTuple):
    """Where a search has ended.

    Attributes
    ----------
    q : ndarray, shape (n,)
    """

    q: np.ndarray
    converged: bool
    position_error: float
    orientation_error: float
    iterations: int
    restarts: int


class Tick(NamedTuple):
    """Where a tick of tracking has ended.

    Attributes
    ----------
    held : ndarray, shape (n,)
        Joints that would go on, upwards (above 0) or downwards: 2 or -2 where a position limit
        holds them, 1 or -1 where their reach does, else 0.
    direction : ndarray, shape (6,)
        See `TrackResult`.
    """

    outcome: SearchOutcome
    held: np.ndarray
    sigma: float
    direction: np.ndarray


AT_LIMIT, AT_SPEED = 2.0, 1.0
"""What holds a joint, in `Tick.held`."""
