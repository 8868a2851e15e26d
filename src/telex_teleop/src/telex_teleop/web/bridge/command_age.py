"""How old a command is when it arrives, told by the clock of the client that sent it."""

from __future__ import annotations

from typing import Optional

CLOCK_DRIFT = 5e-4
"""Rate at which two clocks may drift apart: what NTP corrects at most, clocks themselves less."""


class CommandAge:
    """Ages of one client's messages, by the quickest one so far.

    The two clocks need not agree: the smallest difference between arrival and sending stands for
    "no delay". It may grow as clocks drift, and no faster, or a queue that builds up would pass for
    the new normal.
    """

    def __init__(self) -> None:
        self._offset: Optional[float] = None
        self._seen = 0.0

    def of(self, sent: float, received: float) -> float:
        """Return the age (s) of a message on arrival.

        Parameters
        ----------
        sent
            Time on the client's clock (s).
        received
            Time on this machine's monotonic clock (s).
        """
        difference = received - sent
        offset = difference
        if self._offset is not None:
            offset = min(difference, self._offset + CLOCK_DRIFT * (received - self._seen))
        self._offset, self._seen = offset, received
        return difference - offset
