"""Values that hold for a while, spans of time, and figures reduced to what a strip can show."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Any, Dict, List, Optional

import numpy as np

_DIGITS = 4


class Steps:
    """A value that holds until the next one is told."""

    def __init__(self) -> None:
        self.times: List[float] = []
        self.values: List[Any] = []

    def append(self, time: float, value: Any) -> None:
        """Take a value that holds from a time (s) on, not before that of the last one."""
        self.times.append(time)
        self.values.append(value)

    def at(self, time: float) -> Optional[Any]:
        """Value that holds at a time (s); None before the first."""
        number = bisect_right(self.times, time)
        return self.values[number - 1] if number else None

    def shift(self, begin: float) -> None:
        """Count time from `begin` (s) on."""
        self.times = [time - begin for time in self.times]


class Intervals:
    """Spans of time for which something was so."""

    def __init__(self) -> None:
        self.spans: List[List[float]] = []
        self._since: Optional[float] = None

    def set(self, time: float, on: bool) -> None:
        """Hear at a time (s) whether it is so."""
        if on and self._since is None:
            self._since = time
        elif not on:
            self.close(time)

    def extend(self, time: float, length: float) -> None:
        """Hear at a time (s) that it is so for `length` (s) at least."""
        if self.spans and time <= self.spans[-1][1]:
            self.spans[-1][1] = time + length
        else:
            self.spans.append([time, time + length])

    def close(self, time: float) -> None:
        """End a span that has not ended yet."""
        if self._since is not None:
            self.spans.append([self._since, time])
            self._since = None

    def shift(self, begin: float, duration: float) -> None:
        """Count time from `begin` (s) on, and leave out what is not within the duration (s)."""
        moved = [
            [max(0.0, first - begin), min(duration, last - begin)] for first, last in self.spans
        ]
        self.spans = [[first, last] for first, last in moved if last >= first]

    def since(self, time: float) -> Optional[float]:
        """Begin (s) of the span that a time (s) is in; None: it is in none."""
        for first, last in reversed(self.spans):
            if first <= time < last:
                return first
        return None

    def rounded(self) -> List[List[float]]:
        """Return the spans for a page."""
        return [[round(first, 3), round(last, 3)] for first, last in self.spans]


def envelope(
    times: np.ndarray, values: np.ndarray, duration: float, bins: int
) -> Dict[str, List[Optional[float]]]:
    """Least and largest value in each of the bins that a duration is cut into.

    A peak of one sample is seen however long the recording is.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        s, in order.
    duration : float
        s.

    Returns
    -------
    dict
        ``low`` and ``high``, each of `bins` numbers; None where there was no sample.
    """
    low: List[Optional[float]] = [None] * bins
    high: List[Optional[float]] = [None] * bins
    if len(times):
        width = max(duration, 1e-9) / bins
        numbers = np.minimum((times / width).astype(int), bins - 1)
        used, firsts = np.unique(numbers, return_index=True)
        lows = np.minimum.reduceat(values, firsts)
        highs = np.maximum.reduceat(values, firsts)
        for number, least, most in zip(used.tolist(), lows.tolist(), highs.tolist()):
            low[number], high[number] = _rounded(least), _rounded(most)
    return {"low": low, "high": high}


def _rounded(value: float) -> Optional[float]:
    return round(value, _DIGITS) if math.isfinite(value) else None
