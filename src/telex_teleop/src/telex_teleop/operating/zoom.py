"""The zoom factor of a camera, which changes at a commanded rate."""

from __future__ import annotations

import math
from typing import Optional

# A longer time between two commands is a pause, over which nothing was held.
LONGEST_STEP = 0.1  # s


class ZoomFactor:
    """Zoom factor between 1 and a largest one; a rate changes its logarithm.

    Parameters
    ----------
    maximum
        Largest factor; 1: the camera cannot zoom.
    """

    def __init__(self, maximum: float) -> None:
        self._maximum = maximum
        self._last: Optional[float] = None
        self.value = 1.0

    def take(self, value: float) -> None:
        """Take what somebody has told the camera; no factor at all is ignored."""
        if math.isfinite(value):
            self.value = min(max(value, 1.0), self._maximum)

    def turn(self, rate: float, now: float) -> float:
        """Turn at a rate (1/s) since the last call, and return the factor at `now`.

        `now` is monotonic time (s). A rate of 0 ends the turning; the next call with
        another one begins it.
        """
        last, self._last = self._last, None if rate == 0.0 else now
        if last is not None:
            self.take(self.value * math.exp(rate * min(now - last, LONGEST_STEP)))
        return self.value
