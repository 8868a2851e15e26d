"""Figures of the line between console and robot."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Mapping

from telex_control.common.params import Declared, number, require

LONGEST_DELAY = 10.0
"""Largest delay (s) that may be asked for: the largest seen in the field."""

LEAST_BANDWIDTH = 1000.0
"""Smallest cap (bit/s): below it a single picture would take minutes."""

LEAST_BURST_INTERVAL = 0.01
"""Shortest mean time (s) between bursts: shorter than what passes the line is apart, and each of
them is drawn."""

LONGEST_TIME = 3600.0
"""Longest time (s) of and between bursts and outages."""


@dataclass(frozen=True)
class LineFields(Declared):
    """What the line does to its traffic; the defaults are a perfect line.

    Raises
    ------
    telex_control.common.params.ConfigError
        A value is out of range, or the two of a pair do not fit.
    """

    delay: float = number(0.0, "Time (s) that everything takes, one way.", 0.0, LONGEST_DELAY)
    jitter: float = number(
        0.0,
        "Time (s) by which single messages come later still, at most, evenly distributed.",
        0.0,
        LONGEST_DELAY,
    )
    loss: float = number(
        0.0,
        "Share of commands and pictures that get lost; what must arrive is sent again and comes "
        "late. 1: nothing passes.",
        0.0,
        1.0,
    )
    burst_length: float = number(
        0.0, "Time (s) for which everything is lost, at random; 0: never.", 0.0, LONGEST_TIME
    )
    burst_interval: float = number(
        0.0, "Mean time (s) between bursts, 0.01 at least; 0: there are none.", 0.0, LONGEST_TIME
    )
    bandwidth: float = number(
        0.0, "Cap (bit/s) of each connection, each way; 0: there is none.", 0.0, 1e12
    )
    outage_every: float = number(
        0.0, "Period (s) of outages; 0: there are none.", 0.0, LONGEST_TIME
    )
    outage_for: float = number(
        0.0, "Time (s) at the end of each period for which the line is down.", 0.0, LONGEST_TIME
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.bandwidth == 0.0 or self.bandwidth >= LEAST_BANDWIDTH,
            f"bandwidth is {self.bandwidth!r}; it must be 0 (no cap) or at least "
            f"{LEAST_BANDWIDTH:g} bit/s",
        )
        require(
            self.burst_interval == 0.0 or self.burst_interval >= LEAST_BURST_INTERVAL,
            f"burst_interval is {self.burst_interval!r}; it must be 0 (no bursts) or at least "
            f"{LEAST_BURST_INTERVAL:g} s",
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
"""A line that changes nothing."""
