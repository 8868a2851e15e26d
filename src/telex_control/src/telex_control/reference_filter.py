"""Smooths a stream of set points that arrives slower than the control cycle."""

from __future__ import annotations

import math
from typing import Tuple


class ReferenceFilter:
    """A critically damped low-pass of second order.

    Between two set points the input is constant, so the motion has a closed form (with e the
    distance to the set point, v the speed and w the frequency)::

        e(t) = (e + (v + w e) t) exp(-w t)
        v(t) = (v - w (v + w e) t) exp(-w t)

    It is exact and stable for any cycle time, and never overshoots from rest. A ramp is followed
    with a delay of 2 / w.

    Parameters
    ----------
    frequency : float
        w (rad/s), above 0.
    """

    __slots__ = ("_decay", "_frequency", "_period", "position", "velocity")

    def __init__(self, frequency: float) -> None:
        if not 0.0 < frequency < math.inf:
            raise ValueError(f"the filter's frequency is {frequency} rad/s; it must be above 0")
        self._frequency = frequency
        self._period = 0.0
        self._decay = 1.0
        self.reset(0.0)

    def reset(self, position: float) -> None:
        """Rest at `position`."""
        self.position = position
        self.velocity = 0.0

    def update(self, set_point: float, period: float) -> Tuple[float, float]:
        """Advance by `period` (s) towards `set_point`.

        Returns
        -------
        position, velocity : float
            The smoothed reference and its derivative.
        """
        if period != self._period:
            self._period = period
            self._decay = math.exp(-self._frequency * period)
        distance = self.position - set_point
        drift = self.velocity + self._frequency * distance
        self.position = set_point + (distance + drift * period) * self._decay
        self.velocity = (self.velocity - self._frequency * drift * period) * self._decay
        return self.position, self.velocity
