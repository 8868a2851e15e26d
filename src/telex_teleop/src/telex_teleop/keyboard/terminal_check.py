"""Check that the line to a silent terminal is alive.

A key that is held by exact reports is silent until it goes up. If the connection to the terminal
has died meanwhile, its release never comes; so the terminal is asked something it must answer.
"""

from __future__ import annotations

from typing import Optional

_PERIOD = 0.1
"""Time (s) between two questions."""
_TIMEOUT = 0.4
"""Time (s) without a byte after which the line counts as dead."""


class TerminalCheck:
    """Decides when to query the terminal, and when its line counts as dead."""

    def __init__(self) -> None:
        self._asked = 0.0
        self._heard: Optional[float] = None  # None while nothing depends on the line

    def hear(self, now: float) -> None:
        """Take note that bytes came at `now` (monotonic time, s)."""
        if self._heard is not None:
            self._heard = now

    def dead(self, needed: bool, now: float) -> bool:
        """Tell whether the line is dead at `now`; `needed`: something depends on it."""
        if not needed:
            self._heard = None
        elif self._heard is None:
            self._heard, self._asked = now, now - _PERIOD
        return self._heard is not None and now - self._heard >= _TIMEOUT

    def asks(self, now: float) -> bool:
        """Tell whether it is time for a question at `now`."""
        if self._heard is None or now - self._asked < _PERIOD:
            return False
        self._asked = now
        return True
