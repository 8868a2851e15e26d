"""Age of a command on arrival, by the clock of the client that sent it."""

from __future__ import annotations

import dataclasses
from typing import Optional

CLOCK_DRIFT = 5e-4
"""Rate at which two clocks may drift apart: what NTP corrects at most, clocks themselves less."""

PAUSE = 0.3
"""Silence (s) after which a stream of commands has ended, as on the robot's side."""

CONFIRMED_AFTER = 0.4
"""Time (s) for which messages must come with a new delay before it counts as the line's."""

STEADY = 0.1
"""Time (s) by which the delay may fall meanwhile; if it falls further, a queue is being emptied."""


@dataclasses.dataclass(frozen=True)
class _Moment:
    """When a message was sent and received, both on this machine's clock (s)."""

    sent: float
    received: float

    def follows(self, other: Optional[_Moment], time: float) -> bool:
        """Tell whether it was sent, and came as well, so long (s) after another one, if any."""
        return other is None or (
            self.sent - other.sent >= time and self.received - other.received >= time
        )


class CommandAge:
    """Ages of one client's messages, by the quickest one so far.

    The two clocks need not agree: the smallest difference between arrival and sending stands for
    "no delay". It may grow as clocks drift, and no faster, or a queue that builds up would pass for
    the new normal.

    A line that has become slower for good is told from such a queue by three things. The commands
    that came late have been let go: there was a pause, by both clocks. What tells of the new delay
    was sent after the first late message had arrived, so a gap in the line has not held it up. And
    messages come as they were sent for a while, not faster, as they would out of a queue.

    Parameters
    ----------
    max_age
        Age (s) above which a command comes too late.
    max_slower
        Delay (s) beyond that of the quickest message that may become the line's own.
    """

    def __init__(self, max_age: float, max_slower: float) -> None:
        self._max_age = max_age
        self._max_slower = max_slower
        self._quickest: Optional[float] = None
        self._seen = 0.0
        self._slower = 0.0
        self._late_since: Optional[float] = None
        self._held: Optional[_Moment] = None  # the last command of what has to be let go
        self._begun: Optional[_Moment] = None  # the first message that tells of a new delay
        self._delays = (0.0, 0.0)  # of that one, and the least since (s)

    @property
    def slower(self) -> float:
        """Delay (s) of the line beyond that of the quickest message."""
        return self._slower

    @property
    def is_learning(self) -> bool:
        """Whether the last message came late by what may be the line's new delay."""
        return self._begun is not None

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
        quickest = difference
        if self._quickest is not None:
            quickest = min(difference, self._quickest + CLOCK_DRIFT * (received - self._seen))
        self._quickest, self._seen = quickest, received
        delay = difference - quickest
        self._slower = min(self._slower, delay)
        if delay - self._slower <= self._max_age:
            self._late_since = self._begun = None
        else:
            self._learn(delay, _Moment(received - delay, received))
        return delay - self._slower

    def _learn(self, delay: float, moment: _Moment) -> None:
        """Take a late message for what may be the line's new delay."""
        if self._late_since is None:
            self._late_since = moment.received
        tells = moment.sent >= self._late_since and moment.follows(self._held, PAUSE)
        if not tells or delay > self._max_slower:
            self._begun = None
            return
        first, least = self._delays
        if self._begun is None or delay < first - STEADY:
            self._begun, self._delays = moment, (delay, delay)
            return
        least = min(least, delay)
        self._delays = (first, least)
        if moment.follows(self._begun, CONFIRMED_AFTER):
            self._slower = least
            self._late_since = self._begun = None

    def note_command(self, age: float, received: float) -> None:
        """Take note that a message was a command.

        Parameters
        ----------
        age
            What `of` has told (s).
        received
            When it came (s).
        """
        if not self.is_learning:
            self._held = _Moment(received - age - self._slower, received)
