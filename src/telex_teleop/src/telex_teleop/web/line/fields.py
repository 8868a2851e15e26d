"""Figures of the line between console and robot."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Mapping

from telex_control.common.params import require, require_range

LONGEST_DELAY = 10.0
"""Largest delay (s) that may be asked for: what the field has been seen to do."""

LEAST_BANDWIDTH = 1000.0
"""Smallest cap (bit/s): below it a single picture would take minutes."""

LONGEST_TIME = 3600.0
"""Longest time (s) of and between bursts and outages."""


@dataclass(frozen=True)
class LineFields:
    """What the line does to that which passes it; the defaults are a perfect line.

    Attributes
    ----------
    delay
        Time (s) that everything takes, one way.
    jitter
        Time (s) by which single messages come later still, at most, evenly distributed.
    loss
        Share of commands and pictures that get lost; what must arrive is sent again and comes late.
        1: nothing passes.
    burst_length, burst_interval
        Everything is lost for so long (s), at random times, which lie so far apart in the mean (s);
        0: there are none.
    bandwidth
        Cap (bit/s) of each connection, each way; 0: there is none.
    outage_every, outage_for
        The line is down for the last so many seconds of every period (s); 0: it never is.

    Raises
    ------
    telex_control.common.params.ConfigError
        A value is out of range, or the two of a pair do not fit.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    burst_length: float = 0.0
    burst_interval: float = 0.0
    bandwidth: float = 0.0
    outage_every: float = 0.0
    outage_for: float = 0.0

    def __post_init__(self) -> None:
        require_range(self, "delay", 0.0, LONGEST_DELAY)
        require_range(self, "jitter", 0.0, LONGEST_DELAY)
        require_range(self, "loss", 0.0, 1.0)
        for name in ("burst_length", "burst_interval", "outage_every", "outage_for"):
            require_range(self, name, 0.0, LONGEST_TIME)
        require_range(self, "bandwidth", 0.0, 1e12)
        require(
            self.bandwidth == 0.0 or self.bandwidth >= LEAST_BANDWIDTH,
            f"bandwidth is {self.bandwidth!r}; it must be 0 (no cap) or at least "
            f"{LEAST_BANDWIDTH:g} bit/s",
        )
        self._require_pair("burst", "burst_length", "burst_interval")
        self._require_pair("outage", "outage_for", "outage_every")

    def _require_pair(self, what: str, length: str, period: str) -> None:
        one, other = getattr(self, length), getattr(self, period)
        require(
            (one == 0.0) == (other == 0.0) and one <= other,
            f"{length} is {one!r} and {period} {other!r}; a {what} needs both above 0, and it must "
            "not be longer than the time from one to the next",
        )

    @property
    def is_perfect(self) -> bool:
        """Whether everything passes as it comes."""
        return self == PERFECT

    @classmethod
    def of(cls, holder: object) -> LineFields:
        """Return the figures that something holds, such as a message, as attributes.

        Raises
        ------
        telex_control.common.params.ConfigError
            They cannot be.
        """
        return cls(**{field.name: getattr(holder, field.name) for field in dataclasses.fields(cls)})

    def replace(self, changes: Mapping[str, Any]) -> LineFields:
        """Return these figures with some others; raises ConfigError if they cannot be."""
        return dataclasses.replace(self, **changes)


PERFECT = LineFields()
"""Figures of a line that is none."""
