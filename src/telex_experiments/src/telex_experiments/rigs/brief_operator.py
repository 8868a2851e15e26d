"""An operator of exercises who gives up soon, for --smoke of the benchmarks."""

from __future__ import annotations

from telex_training.operators.experts.brief import Brief
from telex_training.operators.handling import Hand
from telex_training.operators.port import Drive, NotManagedError

_DRIVES = 0.5


def drives_a_little(hand: Hand, brief: Brief) -> None:
    """Drive for half a second, and give up."""
    station = hand.station
    until = station.time + _DRIVES
    while station.time < until:
        station.port.send(Drive(0.2, 0.0))
        station.tick()
    raise NotManagedError(f"setting {brief.setting}: that was all")
