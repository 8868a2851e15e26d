"""Exercises of reading: the expert is told what stands on the charts."""

from __future__ import annotations

from .. import driving
from ..handling import Hand
from .brief import Brief

_LINE = 1.5  # m
_LOOK = 0.6
"""At each row (s)."""


def acuity(hand: Hand, brief: Brief) -> None:
    """Drive to the line, and read the rows from above."""
    station = hand.station
    driving.run_to(station, (_LINE, 0.0), 0.5, heading=0.0)
    station.stop()
    station.wait(1.0)
    for question in brief.answers:
        station.wait(_LOOK)
        station.port.answer(question, brief.answers[question])
