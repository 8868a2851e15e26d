"""Choice of pictures by a rate."""

from __future__ import annotations

from typing import Optional

EARLY = 0.25
"""Part of its period by which a picture may come early, for cameras that are not quite regular."""


class Pacer:
    """Picks pictures so that there are at most so many per second, evenly, without a drift.

    Parameters
    ----------
    rate
        Pictures per second; None: all.
    """

    def __init__(self, rate: Optional[float]) -> None:
        self._period = 1.0 / rate if rate is not None else 0.0
        self._due = float("-inf")

    def is_due(self, now: float) -> bool:
        """Tell whether the next picture may go out at a monotonic time (s)."""
        return now >= self._due - EARLY * self._period

    def sent(self, now: float) -> None:
        """Note that a picture went out."""
        # From the time that was due, not from now, or every late picture would cost rate; but
        # pictures that did not come are not made up for.
        self._due = max(self._due + self._period, now)
