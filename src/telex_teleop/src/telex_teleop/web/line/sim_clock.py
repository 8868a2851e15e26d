"""Sim time between two readings of it."""

from __future__ import annotations

import math

MOST_AHEAD = 0.06
"""Time (s) by which it goes on without a reading; a simulation that is paused gives none that is
new."""


class SimClock:
    """Goes on with the machine's clock from the last reading, never back but by a jump of that."""

    def __init__(self) -> None:
        self._reading = -math.inf
        self._read = 0.0
        self._told = -math.inf

    def at(self, reading: float, read: float, now: float) -> float:
        """Return sim time (s).

        Parameters
        ----------
        reading
            The last reading of sim time (s).
        read
            When that was read (s, of the machine's clock).
        now
            The machine's clock (s).
        """
        if reading != self._reading:
            if reading < self._reading - MOST_AHEAD:
                self._told = -math.inf
            self._reading, self._read = reading, read
        ahead = min(max(now - self._read, 0.0), MOST_AHEAD)
        self._told = max(self._told, reading + ahead)
        return self._told
