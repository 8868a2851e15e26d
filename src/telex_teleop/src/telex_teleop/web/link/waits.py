"""Waiting on the loop for what passes the line, whose times are those of a simulation."""

from __future__ import annotations

import asyncio
from typing import Callable, Optional

SHORTEST = 0.002
"""Time (s) between two looks at a clock that goes."""

STANDING = 0.02
"""The same while it stands."""

LONGEST = 0.1
"""Time (s) after which the line is looked at again in any case: it may have changed meanwhile."""


class DueWait:
    """Tells for how long to wait, by the wall, until sim time has come to where something is due.

    Parameters
    ----------
    clock
        Sim time (s).
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock = clock
        self._looked = float("-inf")

    def time_until(self, due: float) -> float:
        """Return the time (s) to wait before the next look."""
        now = self.clock()
        shortest = STANDING if now == self._looked else SHORTEST
        self._looked = now
        return min(max(due - now, shortest), LONGEST)


class LinePump:
    """Does what is due, as long as something is under way; on the loop's thread.

    Parameters
    ----------
    clock
        Sim time (s).
    work
        Does what is due at a sim time (s), and returns when it is to be called next, None if by no
        time.
    """

    def __init__(
        self, clock: Callable[[], float], work: Callable[[float], Optional[float]]
    ) -> None:
        self._wait = DueWait(clock)
        self._work = work
        self._handle: Optional[asyncio.TimerHandle] = None

    def run(self) -> None:
        """Do what is due, and wait for what is due next."""
        self.close()
        now = self._wait.clock()
        due: Optional[float] = now  # the rest is to go on if one piece of work fails
        try:
            due = self._work(now)
        finally:
            if due is not None:
                loop = asyncio.get_running_loop()
                self._handle = loop.call_later(self._wait.time_until(due), self.run)

    def close(self) -> None:
        """Wait no longer."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None
