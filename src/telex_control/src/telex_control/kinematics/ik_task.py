"""Tasks and results that both backends of the inverse kinematics share."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Tuple

import numpy as np

from .ik_options import Tolerance


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


class Outcome(NamedTuple):
    """Where a search has ended.

    Attributes
    ----------
    q : ndarray, shape (n,)
    converged : bool
    position_error, orientation_error : float
    iterations, restarts : int
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
    outcome : Outcome
    held : ndarray, shape (n,)
        Joints that would go on, upwards (above 0) or downwards: 2 or -2 where a position limit
        holds them, 1 or -1 where their reach does, else 0.
    sigma : float
    direction : ndarray, shape (6,)
        See `TrackResult`.
    """

    outcome: Outcome
    held: np.ndarray
    sigma: float
    direction: np.ndarray


AT_LIMIT, AT_SPEED = 2.0, 1.0
"""What holds a joint, in `Tick.held`."""


class Backend:
    """Numerics of the inverse kinematics of one chain. Not for several threads at once.

    All joint vectors are float64 of shape (n,), all boxes are (lower, upper) with lower <= upper;
    what is answered is within the box.
    """

    name: str
    default_iterations: int
    """Of a solve."""
    search_slice: int
    """Iterations of a tick that a search for another posture may take."""

    def warm_up(self) -> None:
        """Prepare what is made once."""

    def random(self, seed: int) -> Any:
        """Return the state of a random number generator, for `solve`."""
        raise NotImplementedError

    def forward(self, q: np.ndarray) -> np.ndarray:
        """Return the pose of the tip, shape (4, 4)."""
        raise NotImplementedError

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the Jacobian in the base frame, shape (6, n)."""
        raise NotImplementedError

    def solve(
        self,
        task: Task,
        seed: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        random: Any,
        iterations: int,
        *,
        restart: bool = False,
    ) -> Outcome:
        """Descend from the seed, then from elsewhere, until the target or the budget is reached.

        Parameters
        ----------
        restart : bool
            Begin elsewhere at once.
        """
        raise NotImplementedError

    def descend(
        self,
        task: Task,
        q: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        iterations: int,
        damping: float = 0.0,
    ) -> Outcome:
        """Descend from `q` to the next minimum of the error in the box.

        Parameters
        ----------
        damping : float
            Of each step, in the square of the weighted Jacobian's unit.
        """
        raise NotImplementedError

    def slide(
        self,
        task: Task,
        q: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        goal: GoalFunction,
        rounds: int,
    ) -> Tuple[np.ndarray, int]:
        """Move a solution `q` of the task to where the goal is less, the target kept.

        Returns
        -------
        q : ndarray, shape (n,)
        iterations : int
            That took as long.
        """
        raise NotImplementedError

    def goal_value(self, task: Task, q: np.ndarray, goal: GoalFunction) -> float:
        """Return the value of a goal."""
        raise NotImplementedError

    def tick(
        self,
        task: Task,
        q: np.ndarray,
        limits: Tuple[np.ndarray, np.ndarray],
        reach: np.ndarray,
        iterations: int,
        damping: float = 0.0,
        *,
        measured: bool = True,
    ) -> Tick:
        """Descend from `q`, no joint moving farther than `reach`.

        Joints outside of the limits come back as far as they reach.

        Parameters
        ----------
        measured : bool
            Find out how near to singular the end is; else sigma and direction mean nothing.
        """
        raise NotImplementedError
