"""Keeps the arm off what it would run into: the nearer, the slower, down to a stop.

The robot tells which pairs of bodies are near, how far apart they are and how that distance changes
with each joint (``sim/proximity``). From these, and from how fast the joints want to move, follows
how fast they may: a velocity damper (Faverjon and Tournassoud, 1987). Moving apart is always free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Mapping, Optional, Tuple

from telex_control.params import require_range

__all__ = ["Nearness", "ProximityGuard", "ProximityPair", "ProximitySettings", "ProximityState"]


@dataclass(frozen=True)
class ProximityPair:
    """Two bodies that are near each other.

    Attributes
    ----------
    link, other
        Their names.
    touchable
        They may touch, but slowly: fingers and what they are to grasp.
    distance
        Between them (m), below 0 when they overlap, at `ProximityState.positions`.
    gradient
        Joint to what a unit of its motion adds to the distance (m/rad, m/m).
    """

    link: str
    other: str
    touchable: bool
    distance: float
    gradient: Mapping[str, float]


@dataclass(frozen=True)
class ProximityState:
    """What is near the arm.

    Attributes
    ----------
    stamp
        Sim time (s) at which it was measured.
    positions
        Joint to its position then (rad or m).
    pairs
        All that are near enough to matter.
    """

    stamp: float
    positions: Mapping[str, float]
    pairs: Tuple[ProximityPair, ...]


@dataclass(frozen=True)
class ProximitySettings:
    """How the arm keeps its distance.

    Attributes
    ----------
    enabled
        Whether it does at first; an operator can switch it.
    stop_distance
        Distance (m) at which two bodies that must not touch stop approaching.
    deceleration
        With which the approach is slowed at most (m/s^2).
    time_constant
        Of the last, exponential part of the approach (s).
    touch_speed
        Speed (m/s) at which bodies may touch that are there to be touched.
    max_age
        A report older than this (s of sim time) counts as none.
    """

    enabled: bool = True
    stop_distance: float = 0.005
    deceleration: float = 0.5
    time_constant: float = 0.15
    touch_speed: float = 0.05
    max_age: float = 0.25

    def __post_init__(self) -> None:
        require_range(self, "stop_distance", 0.0)
        for name in ("deceleration", "time_constant", "touch_speed", "max_age"):
            require_range(self, name, above=0.0)


@dataclass(frozen=True)
class Nearness:
    """Why the guard slows a motion.

    Attributes
    ----------
    pair
        The two bodies that slow it most.
    distance
        Between them at the references (m).
    factor
        Share of the speed that is left, 0 when it stops.
    """

    pair: ProximityPair
    distance: float
    factor: float

    def __str__(self) -> str:
        what = "stopped" if self.factor < 0.02 else "slowed"
        millimetres = 1000.0 * self.distance
        return f"{what}: {self.pair.link} is {millimetres:.0f} mm from {self.pair.other}"


class ProximityGuard:
    """Says how much of a wanted motion is allowed.

    Parameters
    ----------
    settings
        Its distances and speeds.
    """

    def __init__(self, settings: ProximitySettings) -> None:
        self._settings = settings
        self._state: Optional[ProximityState] = None
        self.enabled = settings.enabled

    def take(self, state: ProximityState) -> None:
        """Take what the robot says is near."""
        self._state = state

    def forget(self) -> None:
        """Forget what was near, because the robot is somewhere else now."""
        self._state = None

    def silent(self, stamp: float) -> bool:
        """Tell whether the guard should work at `stamp` (s of sim time) but is told nothing."""
        if not self.enabled:
            return False
        return self._state is None or stamp - self._state.stamp > self._settings.max_age

    def motion_factor(
        self, stamp: float, references: Mapping[str, float], rates: Mapping[str, float]
    ) -> Tuple[float, Optional[Nearness]]:
        """Return how much of a motion in which all joints move together is allowed.

        Parameters
        ----------
        stamp
            Present sim time (s).
        references
            Joint to where it is told to be (rad or m): ahead of what is measured.
        rates
            Joint to the rate that is wanted (per second); joints that are not in it rest.

        Returns
        -------
        factor, reason
            From 0 to 1, and why it is below 1.
        """
        worst: Optional[Nearness] = None
        for pair in self._pairs(stamp):
            closing = -sum(pair.gradient.get(joint, 0.0) * rate for joint, rate in rates.items())
            if closing <= 0.0:
                continue
            distance = self._distance(pair, references)
            factor = self._speed(pair, distance) / closing
            if factor < 1.0 and (worst is None or factor < worst.factor):
                worst = Nearness(pair, distance, factor)
        return (1.0, None) if worst is None else (worst.factor, worst)

    def joint_factors(
        self, stamp: float, references: Mapping[str, float], rates: Mapping[str, float]
    ) -> Tuple[Dict[str, float], Optional[Nearness]]:
        """Return the same for joints that move independently: only what closes in is slowed.

        Parameters
        ----------
        stamp, references, rates
            See `motion_factor`.

        Returns
        -------
        factors, reason
            Joint to its factor; joints that may move freely are not in it.
        """
        factors: Dict[str, float] = {}
        worst: Optional[Nearness] = None
        for pair in self._pairs(stamp):
            parts = {joint: pair.gradient.get(joint, 0.0) * rate for joint, rate in rates.items()}
            closing = -sum(part for part in parts.values() if part < 0.0)
            opening = sum(part for part in parts.values() if part > 0.0)
            if closing <= opening:
                continue
            distance = self._distance(pair, references)
            factor = (self._speed(pair, distance) + opening) / closing
            if factor >= 1.0:
                continue
            for joint, part in parts.items():
                if part < 0.0:
                    factors[joint] = min(factor, factors.get(joint, 1.0))
            if worst is None or factor < worst.factor:
                worst = Nearness(pair, distance, factor)
        return factors, worst

    def _pairs(self, stamp: float) -> Tuple[ProximityPair, ...]:
        if not self.enabled or self._state is None or self.silent(stamp):
            return ()
        return self._state.pairs

    def _distance(self, pair: ProximityPair, references: Mapping[str, float]) -> float:
        assert self._state is not None
        moved = sum(
            slope * (references[joint] - self._state.positions[joint])
            for joint, slope in pair.gradient.items()
            if joint in references
        )
        return pair.distance + moved

    def _speed(self, pair: ProximityPair, distance: float) -> float:
        """Return how fast the two may approach (m/s)."""
        settings = self._settings
        room = max(0.0, distance - (0.0 if pair.touchable else settings.stop_distance))
        braking = math.sqrt(2.0 * settings.deceleration * room)
        speed = min(braking, room / settings.time_constant)
        return max(speed, settings.touch_speed) if pair.touchable else speed
