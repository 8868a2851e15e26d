"""Figures of the line by the quality of a radio signal."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Tuple

from telex_control.common.params import Declared, number, parameter, require, required

from .fields import LineFields


@dataclass(frozen=True)
class SignalPoint(Declared):
    """Figures at one quality of the signal."""

    signal: float = number(required, "Quality, 0 to 1.", 0.0, 1.0)
    fields: LineFields = parameter(LineFields, "What the line does then.")


@dataclass(frozen=True)
class SignalCurve:
    """Figures between points, each in a straight line; beyond the outer ones they stay.

    Attributes
    ----------
    points
        By rising signal.

    Raises
    ------
    telex_control.common.params.ConfigError
        There are fewer than two, or they do not rise, or some have a bandwidth or bursts and some
        none.
    """

    points: Tuple[SignalPoint, ...]

    def __post_init__(self) -> None:
        signals = [point.signal for point in self.points]
        require(len(signals) >= 2, f"by_signal has {len(signals)} points; two at least are needed")
        rising = all(one < next_one for one, next_one in zip(signals, signals[1:]))
        require(rising, f"by_signal has the signals {signals}; they must rise from point to point")
        for key in ("bandwidth", "burst_interval"):
            given = {getattr(point.fields, key) > 0.0 for point in self.points}
            require(
                len(given) == 1,
                f"by_signal has points with and without a {key}; between them there is none to "
                "compute: give it in all of them, or in none",
            )

    def at(self, signal: float) -> LineFields:
        """Return the figures at a quality of the signal, 0 to 1."""
        points = self.points
        if signal <= points[0].signal:
            return points[0].fields
        for below, above in zip(points, points[1:]):
            if signal < above.signal:
                share = (signal - below.signal) / (above.signal - below.signal)
                return _between(below.fields, above.fields, share)
        return points[-1].fields


def _between(below: LineFields, above: LineFields, share: float) -> LineFields:
    low, high = dataclasses.asdict(below), dataclasses.asdict(above)
    # In this form between two that are equal nothing is less than they are, by rounding.
    return LineFields(**{key: low[key] + share * (high[key] - low[key]) for key in low})
