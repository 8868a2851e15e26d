"""The present state of the line, which all that pass it share."""

from __future__ import annotations

import math
from random import Random

from .fields import PERFECT, LineFields

RETRANSMISSION = 0.1
"""Time (s) after which what must arrive is sent again when it got lost."""

MOST_BURSTS = 1000
"""Bursts that are drawn to come to the present; those of a longer time without traffic are not."""

MOST_RETRANSMISSIONS = 10
"""So often it gets lost at most, so that nothing that must arrive takes for ever."""


class Line:
    """Figures of the line, and what they do to single messages.

    Times are those of one clock (s), sim time in the nodes: while that stands nothing ages.

    Parameters
    ----------
    random
        Draws jitter, losses and bursts.

    Attributes
    ----------
    version
        Counts the changes of `fields`.
    """

    def __init__(self, random: Random) -> None:
        self.fields: LineFields = PERFECT
        self.version = 0
        self.is_perfect = True
        self._random = random
        self._since = 0.0
        self._burst = (math.inf, math.inf)

    def configure(self, fields: LineFields, since: float) -> None:
        """Change the figures.

        Parameters
        ----------
        since
            Time (s) at which they were chosen; outages count from it.
        """
        if (fields, since) == (self.fields, self._since):
            return
        bursts = (fields.burst_length, fields.burst_interval)
        if bursts != (self.fields.burst_length, self.fields.burst_interval):
            self._burst = (math.inf, math.inf) if fields.burst_interval == 0.0 else (since, since)
        self.fields, self._since = fields, since
        self.is_perfect = fields.is_perfect
        self.version += 1

    def in_outage(self, now: float) -> bool:
        """Tell whether the line is down by its figures, bursts apart."""
        return self._outage_ends(now) > now

    def reopens(self, now: float) -> float:
        """Return when (s) something can pass again: `now` if the line is up."""
        return max(self._outage_ends(now), self._burst_ends(now))

    def draw_delay(self) -> float:
        """Return the time (s) that one message takes."""
        jitter = self.fields.jitter
        return self.fields.delay + (self._random.random() * jitter if jitter else 0.0)

    def loses(self, now: float) -> bool:
        """Tell whether a message that may be lost gets lost at a time (s)."""
        if self.is_perfect:
            return False
        return self.reopens(now) > now or self.loses_by_chance()

    def draw_retransmissions(self) -> float:
        """Return the time (s) that a message takes longer which must arrive."""
        lost = 0
        while lost < MOST_RETRANSMISSIONS and self.loses_by_chance():
            lost += 1
        return lost * RETRANSMISSION

    def loses_by_chance(self) -> bool:
        """Tell whether a message gets lost though the line is up."""
        return self.fields.loss > 0.0 and self._random.random() < self.fields.loss

    def _outage_ends(self, now: float) -> float:
        fields = self.fields
        if fields.loss >= 1.0:
            return math.inf
        if fields.outage_every == 0.0:
            return now
        if fields.outage_for >= fields.outage_every:
            return math.inf
        into = (now - self._since) % fields.outage_every
        up = fields.outage_every - fields.outage_for
        return now if into < up else now + fields.outage_every - into

    def _burst_ends(self, now: float) -> float:
        if self.fields.burst_interval == 0.0:
            return now
        begin, end = self._burst
        if now - end > MOST_BURSTS * self.fields.burst_interval:
            end = now
        # A burst lies within the mean distance to the next, so the rest is drawn.
        pause = self.fields.burst_interval - self.fields.burst_length
        while end <= now:
            begin = end + (self._random.expovariate(1.0 / pause) if pause > 0.0 else 0.0)
            end = begin + self.fields.burst_length
        self._burst = (begin, end)
        return end if begin <= now else now
