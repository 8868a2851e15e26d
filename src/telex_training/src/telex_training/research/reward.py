"""The judge's view of a repetition as terms of a reward."""

from __future__ import annotations

import math
from typing import Any, Dict, Mapping

from ..exercises.model import Exercise

TERMS = ("steps", "time", "success", "fault")
_USUAL_LIMIT = 300.0
"""Where a repetition has no limit (s)."""


class Reward:
    """Terms of what happens to a repetition.

    ``steps``: share of the exercise's steps that were done now. ``time``: time and penalties since,
    as a negative share of the repetition's limit. ``success``: 1 when the repetition is completed.
    ``fault``: -1 when it ends otherwise.

    Parameters
    ----------
    state : mapping
        As `Judge.state` has it at first.
    weights : mapping of str to float
        By which terms count that are to count otherwise than once; see `require_terms`.

    Attributes
    ----------
    ended, succeeded : bool
        Whether the repetition has ended, and was completed.
    """

    def __init__(
        self, exercise: Exercise, state: Mapping[str, Any], weights: Mapping[str, float]
    ) -> None:
        self.ended = self.succeeded = False
        self._weights = {name: float(weights.get(name, 1.0)) for name in TERMS}
        self._limit = exercise.repetitions.time or _USUAL_LIMIT
        self._results = len(state["results"])
        self._steps = self._spent = 0.0
        self.terms(state)

    def terms(self, state: Mapping[str, Any]) -> Dict[str, float]:
        """Return the weighted terms of what has happened since the last state."""
        done, results = state["steps_done"], state["results"]
        self.ended = len(results) > self._results
        self.succeeded = self.ended and results[-1] == "passed"
        # A state that has done with the repetition knows nothing of it any more.
        steps = max(self._steps, sum(done) / len(done) if done else 0.0)
        spent = max(self._spent, (state["elapsed"] + state["penalty"]) / self._limit)
        found = {
            "steps": steps - self._steps,
            "time": self._spent - spent,
            "success": float(self.succeeded),
            "fault": -1.0 if self.ended and not self.succeeded else 0.0,
        }
        self._steps, self._spent = steps, spent
        return {name: self._weights[name] * value for name, value in found.items()}


def require_terms(weights: Mapping[str, float]) -> None:
    """Raise a ValueError unless all names are those of terms, and all weights finite."""
    for name, weight in weights.items():
        if name not in TERMS:
            raise ValueError(f"weights has '{name}'; there are: {', '.join(TERMS)}")
        if not math.isfinite(weight):
            raise ValueError(f"weights['{name}'] is {weight}; a finite number is needed")
