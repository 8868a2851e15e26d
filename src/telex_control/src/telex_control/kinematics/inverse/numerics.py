"""Numerics of the inverse kinematics of one chain, over kernels that numba compiles."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from ..chain import Chain
from . import kernels
from .joint_frames import joint_frames
from .options import IKOptions, Tolerance
from .task import GoalFunction, SearchOutcome, Task, TaskShape, Tick

_ODD = 0x9E3779B97F4A7C15


class ChainNumerics:
    """Numerics of one chain. Not for several threads at once.

    All joint vectors are float64 of shape (n,), all boxes are (lower, upper) with lower <= upper;
    what is answered is within the box.
    """

    default_iterations = 6000
    """Of a solve."""
    search_slice = 15
    """Iterations of a tick that a search for another posture may take."""

    def __init__(self, chain: Chain, options: IKOptions) -> None:
        self._model = kernels.Model(*joint_frames(chain))
        self._attempt = int(options.attempt_iterations)
        self._candidates = int(options.restart_candidates)
        # The base frame itself as target, lengths not weighted.
        self._base = TaskShape.of(Tolerance(), 1.0).at(np.eye(4))

    def random(self, seed: int) -> Any:
        """Return the state of a random number generator, for `solve`."""
        # The generator must not start at 0, and neighbouring seeds should not begin alike.
        return np.array([((seed + 1) * _ODD) % 2**64 or _ODD], dtype=np.uint64)

    def forward(self, q: np.ndarray) -> np.ndarray:
        """Return the pose of the tip, shape (4, 4)."""
        pose = np.eye(4)
        kernels.forward(self._model, self._base, q, pose)
        return pose

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the Jacobian in the base frame, shape (6, n)."""
        made = np.empty((6, q.size))
        kernels.jacobian(self._model, self._base, q, made)
        return made

    def solve(
        self,
        task: Task,
        seed: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        random: Any,
        iterations: int,
        *,
        restart: bool = False,
    ) -> SearchOutcome:
        """Descend from the seed, then from elsewhere, until the target or the budget is reached.

        Parameters
        ----------
        restart : bool
            Begin elsewhere at once.
        """
        q = np.empty(seed.size)
        converged, place, turn, used, restarts = kernels.solve(
            self._model,
            task,
            seed,
            box[0],
            box[1],
            random,
            iterations,
            self._attempt,
            self._candidates,
            restart,
            q,
        )
        return SearchOutcome(q, converged, place, turn, used, restarts)

    def descend(
        self,
        task: Task,
        q: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        iterations: int,
        damping: float = 0.0,
    ) -> SearchOutcome:
        """Descend from `q` to the next minimum of the error in the box.

        Parameters
        ----------
        damping : float
            Of each step, in the square of the weighted Jacobian's unit.
        """
        moved = q.copy()
        converged, place, turn, used = kernels.descend(
            self._model, task, box[0], box[1], iterations, damping, moved
        )
        return SearchOutcome(moved, converged, place, turn, used, 0)

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
        moved = q.copy()
        used = kernels.slide(self._model, task, goal, box[0], box[1], rounds, moved)
        return moved, used

    def goal_value(self, task: Task, q: np.ndarray, goal: GoalFunction) -> float:
        """Return the value of a goal."""
        return kernels.goal_value(self._model, task, goal, q)

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
        moved, held, direction = q.copy(), np.empty(q.size), np.zeros(6)
        converged, place, turn, used, sigma = kernels.tick(
            self._model,
            task,
            limits[0],
            limits[1],
            reach,
            iterations,
            damping,
            measured,
            moved,
            held,
            direction,
        )
        return Tick(SearchOutcome(moved, converged, place, turn, used, 0), held, sigma, direction)
