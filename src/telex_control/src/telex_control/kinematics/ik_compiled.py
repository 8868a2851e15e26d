"""Backend of the inverse kinematics that is compiled by numba."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from . import ik_kernels as kernels
from .chain import Chain
from .ik_options import IKOptions, Tolerance
from .ik_task import Backend, GoalFunction, Outcome, Task, TaskShape, Tick
from .joint_frames import joint_frames

_ODD = 0x9E3779B97F4A7C15


class CompiledBackend(Backend):
    """Calls `ik_kernels`.

    Parameters
    ----------
    chain : Chain
    options : IKOptions
    """

    name = "compiled"
    default_iterations = 6000
    search_slice = 15

    def __init__(self, chain: Chain, options: IKOptions) -> None:
        self._model = kernels.Model(*joint_frames(chain))
        self._attempt = int(options.attempt_iterations)
        self._candidates = int(options.restart_candidates)
        # The base frame itself as target, lengths not weighted.
        self._base = TaskShape.of(Tolerance(), 1.0).at(np.eye(4))

    def random(self, seed: int) -> Any:
        """See `Backend`."""
        # The generator must not start at 0, and neighbouring seeds should not begin alike.
        return np.array([((seed + 1) * _ODD) % 2**64 or _ODD], dtype=np.uint64)

    def forward(self, q: np.ndarray) -> np.ndarray:
        """See `Backend`."""
        pose = np.eye(4)
        kernels.forward(self._model, self._base, q, pose)
        return pose

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """See `Backend`."""
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
    ) -> Outcome:
        """See `Backend`."""
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
        return Outcome(q, converged, place, turn, used, restarts)

    def descend(
        self,
        task: Task,
        q: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        iterations: int,
        damping: float = 0.0,
    ) -> Outcome:
        """See `Backend`."""
        moved = q.copy()
        converged, place, turn, used = kernels.descend(
            self._model, task, box[0], box[1], iterations, damping, moved
        )
        return Outcome(moved, converged, place, turn, used, 0)

    def slide(
        self,
        task: Task,
        q: np.ndarray,
        box: Tuple[np.ndarray, np.ndarray],
        goal: GoalFunction,
        rounds: int,
    ) -> Tuple[np.ndarray, int]:
        """See `Backend`."""
        moved = q.copy()
        used = kernels.slide(self._model, task, goal, box[0], box[1], rounds, moved)
        return moved, used

    def goal_value(self, task: Task, q: np.ndarray, goal: GoalFunction) -> float:
        """See `Backend`."""
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
        """See `Backend`."""
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
        return Tick(Outcome(moved, converged, place, turn, used, 0), held, sigma, direction)
