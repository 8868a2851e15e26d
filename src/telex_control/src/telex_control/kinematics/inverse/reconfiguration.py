"""The search for another posture, while tracking stands stuck: a little of it in every tick."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Optional, Tuple

import numpy as np

from .options import IKOptions
from .task import Task

if TYPE_CHECKING:
    from .numerics import ChainNumerics

_MOVED = 0.02
"""Weighted change of the target (rad) after which the search has a new budget."""
_STILL = 1e-4
"""Weighted change of the target (rad) in a tick that counts as none."""
_REFINE = 10
"""Iterations in which a known posture must follow the target from tick to tick."""


class PostureSearch:
    """Whether another posture reaches a target that the present one does not.

    Reproducible: the same sequence of ticks finds the same.

    Parameters
    ----------
    box : pair of ndarray, shape (n,)
        Position limits.
    """

    def __init__(
        self, numerics: ChainNumerics, box: Tuple[np.ndarray, np.ndarray], options: IKOptions
    ) -> None:
        self._numerics = numerics
        self._box = box
        self._slice = numerics.search_slice
        self._budget = int(options.search_iterations)
        self._seed = int(options.random_seed)
        after = options.reconfigure_after
        self._patience = math.inf if after is None else after
        self._weights = np.ones((3, 4))
        self._weights[:, 3] = options.length_weight
        self._begin()

    def forget(self) -> None:
        """Begin anew at the next look: the target has been reached."""
        # Without a look since there is nothing to forget: the case of most ticks.
        if self._last is not None:
            self._begin()

    def _begin(self) -> None:
        self._random = self._numerics.random(self._seed)
        self._left = self._budget
        self._target: Optional[np.ndarray] = None
        self._last: Optional[np.ndarray] = None
        self._posture: Optional[np.ndarray] = None
        self._walking = False
        self._still = 0.0  # s

    def look(self, task: Task, here: np.ndarray, dt: float) -> Optional[np.ndarray]:
        """Search on for a tick.

        Parameters
        ----------
        here : ndarray, shape (n,)
            The present posture, which does not reach the target.
        dt : float
            Length of the tick (s).

        Returns
        -------
        ndarray, shape (n,), or None
            Joint positions that reach the target: the nearest found, by the joint that moves most.
        """
        self._follow(task)
        self._still = self._still + dt if self._stands(task) else 0.0
        self._last = task.target
        if self._target is None or self._apart(self._target, task) > _MOVED:
            self._target = task.target
            self._left = self._budget
        if self._left > 0:
            found = self._numerics.solve(
                task, here, self._box, self._random, min(self._slice, self._left), restart=True
            )
            self._left -= max(found.iterations, 1)
            if found.converged and (
                self._posture is None or abs(found.q - here).max() < abs(self._posture - here).max()
            ):
                self._posture = found.q
        if self._posture is not None and self._still >= self._patience:
            self._walking = True
        return self._posture

    def destination(self, task: Task) -> Optional[np.ndarray]:
        """Return the posture that is to be walked to, None when there is none (any more).

        Parameters
        ----------
        task : Task
            The present target; once it moves, the walk ends.
        """
        if not self._walking:
            return None
        self._walking = self._stands(task)
        self._last = task.target
        if not self._walking:
            self._still = 0.0
            return None
        return self._posture

    def _stands(self, task: Task) -> bool:
        """Whether the target is where it was in the tick before."""
        return self._last is not None and self._apart(self._last, task) < _STILL

    def _apart(self, target: np.ndarray, task: Task) -> float:
        """Largest change of a target, lengths weighted."""
        # The largest of plain floats: numpy's own takes several times as long on so few.
        change = abs((task.target[:3] - target[:3]) * self._weights)
        largest: float = max(change.ravel().tolist())
        return largest

    def _follow(self, task: Task) -> None:
        """Have the known posture follow the target, or forget it."""
        if self._posture is not None:
            known = self._numerics.descend(task, self._posture, self._box, _REFINE)
            self._posture = known.q if known.converged else None
