"""Effects of faults of a belt's drive."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, NamedTuple

from .belt_drive import BeltDrive, BeltDriveConfig

_JAM = 1.0e5
"""Force with which a jammed belt stands (N)."""
ROLLING = 0.08
"""Friction along a track without belt, as a share of that with it: bare wheels roll."""


class BeltFault(NamedTuple):
    """What does not work of a drive and its belts.

    Attributes
    ----------
    share : float
        Of force and power that is left.
    jammed : bool
        Nothing turns.
    limp : bool
        Neither motor nor brake holds the belt.
    thrown : bool
        The belt is off: the wheels roll on the ground, the motor turns freely.
    """

    share: float = 1.0
    jammed: bool = False
    limp: bool = False
    thrown: bool = False


SOUND = BeltFault()


class _JammedDrive(BeltDrive):
    """Stands still, whatever is asked."""

    __slots__ = ()

    def follow(self, command: float, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.follow`."""
        self._stand(traction)

    def push(self, force: float, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.push`."""
        self._stand(traction)

    def brake(self, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.brake`."""
        self._stand(traction)

    def _stand(self, traction: Callable[[float], float]) -> None:
        self._reach(0.0, traction, lambda speed: _JAM)


class _LimpDrive(BeltDrive):
    """Is turned by the ground alone."""

    __slots__ = ()

    def follow(self, command: float, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.follow`."""
        self.push(0.0, traction)

    def brake(self, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.brake`."""
        self.push(0.0, traction)

    def push(self, force: float, traction: Callable[[float], float]) -> None:
        """See `BeltDrive.push`."""
        super().push(0.0, traction)


def make_drive(
    config: BeltDriveConfig, friction: float, damping: float, step_size: float, fault: BeltFault
) -> BeltDrive:
    """Make the drive of a belt; parameters as of `BeltDrive`."""
    kind = _JammedDrive if fault.jammed else _LimpDrive if fault.limp else BeltDrive
    weak = replace(config, force=fault.share * config.force, power=fault.share * config.power)
    return kind(weak, friction, damping, step_size)
