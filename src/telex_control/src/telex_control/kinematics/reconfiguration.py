"""The search for another posture, while tracking stands stuck: a little of it in every tick."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from .ik_options import IKOptions
from .ik_task import Backend, Task

_MOVED = 0.02
"""Weighted change of the target (rad) after which the search has a new budget."""
_REFINE = 10
"""Iterations in which a known posture must follow the target from tick to tick."""


class PostureSearch:
    """Whether another posture reaches a target that the present one does not.

    Reproducible: the same sequence of ticks finds the same.

    Parameters
    ----------
    numerics : Backend
    box : pair of ndarray, shape (n,)
        Position limits.
    options : IKOptions
    """

    def __init__(
        self, numerics: Backend, box: Tuple[np.ndarray, np.ndarray], options: IKOptions
    ) -> None:
        self._numerics = numerics
        self._box = box
        self._slice = numerics.search_slice
        self._budget = int(options.search_iterations)
        self._seed = int(options.random_seed)
        self.forget()

    def forget(self) -> None:
        """Begin anew at the next look: the target has been reached."""
        self._random = self._numerics.random(self._seed)
        self._left = self._budget
        self._target: Optional[np.ndarray] = None
        self._posture: Optional[np.ndarray] = None

    def look(self, task: Task, here: np.ndarray) -> Optional[np.ndarray]:
        """Search on for a tick.

        Parameters
        ----------
        task : Task
        here : ndarray, shape (n,)
            The present posture, which does not reach the target.

        Returns
        -------
        ndarray, shape (n,), or None
            Joint positions that reach the target.
        """
        if self._posture is not None:
            known = self._numerics.descend(task, self._posture, self._box, _REFINE)
            self._posture = known.q if known.converged else None
        if self._target is None or _apart(self._target, task) > _MOVED:
            self._target = task.target
            self._left = self._budget
        if self._posture is None and self._left > 0:
            found = self._numerics.solve(
                task, here, self._box, self._random, min(self._slice, self._left), restart=True
            )
            self._left -= max(found.iterations, 1)
            if found.converged:
                self._posture = found.q
        return self._posture


def _apart(target: np.ndarray, task: Task) -> float:
    """Largest change of a target, lengths weighted."""
    change = abs(task.target - target)
    return max(float(change[:3, :3].max()), task.length_weight * float(change[:3, 3].max()))
