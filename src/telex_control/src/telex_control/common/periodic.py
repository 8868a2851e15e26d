"""Work that is due at a rate which need not divide that of the control loop."""

from __future__ import annotations

import math
from typing import Optional

from .stateful import Stateful


class Periodic(Stateful):
    """Tells when something is due; the mean rate is kept whatever the control period.

    Parameters
    ----------
    rate : float
        (Hz); at 0, nothing is ever due.
    """

    __slots__ = ("_next", "period")
    SAVED_TIMES = ("_next",)

    def __init__(self, rate: float) -> None:
        self.period = 1.0 / rate if rate > 0.0 else math.inf
        self._next: Optional[float] = None

    def restart(self) -> None:
        """Make it due at once."""
        self._next = None

    def is_due(self, time: float) -> bool:
        """Whether it is due at `time` (s)."""
        if self.period == math.inf:
            return False
        due = time if self._next is None else self._next
        # Half a microsecond of slack: sums of the period must not miss their cycle by rounding.
        if time < due - 5e-7:
            return False
        due += self.period
        self._next = due if due > time else time + self.period
        return True
