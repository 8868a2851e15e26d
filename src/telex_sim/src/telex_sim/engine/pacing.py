"""Keeps simulated time in step with the wall clock."""

from __future__ import annotations

import time
from typing import Callable

_GIVE_UP_BEHIND = 0.1
"""A backlog longer than this (s) is forgotten, not caught up in a burst."""

_MEASURED_SPAN = 0.5
"""Shortest span (s) over which the real-time factor is measured."""


class RealTimePacer:
    """Sleeps so that sim time runs at a factor of wall time.

    Parameters
    ----------
    factor : float
        Sim time per wall time; 0 never sleeps.
    clock, sleep : callable
        For tests.
    """

    def __init__(
        self,
        factor: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._factor = factor
        self._clock = clock
        self._sleep = sleep
        self.restart(0.0)

    def restart(self, sim_time: float) -> None:
        """Begin here and now, as after a pause."""
        self._origin = self._clock() - (sim_time / self._factor if self._factor else 0.0)

    def wait(self, sim_time: float) -> float:
        """Sleep until the wall has come to `sim_time` (s).

        Returns
        -------
        float
            How late this call is (s); 0 when it slept.
        """
        if not self._factor:
            return 0.0
        ahead = self._origin + sim_time / self._factor - self._clock()
        if ahead > 0.0:
            self._sleep(ahead)
            return 0.0
        if ahead < -_GIVE_UP_BEHIND:
            self.restart(sim_time)
        return -ahead


class RealTimeFactor:
    """Measures the achieved real-time factor between two calls."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.restart(0.0)

    def restart(self, sim_time: float) -> None:
        """Measure from here and now."""
        self._wall, self._sim = self._clock(), sim_time
        self._factor = 0.0

    def since_last(self, sim_time: float) -> float:
        """Sim time per wall time since the last measurement.

        A span too short to measure gives the last value again.
        """
        wall = self._clock()
        elapsed = wall - self._wall
        if elapsed >= _MEASURED_SPAN:
            self._factor = (sim_time - self._sim) / elapsed
            self._wall, self._sim = wall, sim_time
        return self._factor
