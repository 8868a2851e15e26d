"""Keeps what others send from filling a node's log: long lines are cut, floods thinned out."""

from __future__ import annotations

import logging
import time
from typing import Callable, Dict, Tuple

LONGEST = 1000
"""Characters of a line; what a user typed wrong is said within that."""

BURST, REFILL = 10.0, 1.0
"""Lines that one place in the code may write at once, and how many per second after that."""

MAX_PLACES = 1000
"""Places in the code that are remembered."""


class CalmLog(logging.Filter):
    """Cuts long records, and drops warnings of one place in the code that come too often.

    Parameters
    ----------
    clock
        Monotonic time (s).
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._left: Dict[Tuple[str, int], Tuple[float, float]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Cut a record; tell whether it is to be written."""
        try:
            text = record.getMessage()
        except Exception:  # wrong arguments: logging says where, and whoever logs goes on
            return True
        if len(text) > LONGEST:
            record.msg = f"{text[:LONGEST]}... ({len(text)} characters)"
            record.args = ()
        return record.levelno != logging.WARNING or self._may(record.pathname, record.lineno)

    def _may(self, path: str, line: int) -> bool:
        now = self._clock()
        if len(self._left) >= MAX_PLACES:
            self._left.clear()
        left, since = self._left.get((path, line), (BURST, now))
        left = min(BURST, left + (now - since) * REFILL)
        written = left >= 1.0
        self._left[path, line] = (left - written, now)
        return written


def calm_log() -> None:
    """Keep rospy's log of this node calm."""
    logging.getLogger("rosout").addFilter(CalmLog())
