"""Keeps the arm off what it would run into: the nearer, the slower, down to a stop.

The robot tells which pairs of bodies are near, how far apart they are and how that distance changes
with each joint (``sim/proximity``). From these, and from how fast the joints want to move, follows
how fast they may: a velocity damper (Faverjon and Tournassoud, 1987). Moving apart is always free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.params import Declared, number, parameter

# Below this share of its speed a motion is said to be stopped.
STOPPED_SHARE = 0.02


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
    base_gradient
        What a unit twist of the base adds to it: linear, then angular (m/m, m/rad), along the
        base's axes about its origin. Zero where both bodies ride on the base.
    """

    link: str
    other: str
    touchable: bool
    distance: float
    gradient: Mapping[str, float]
    base_gradient: Tuple[float, ...] = (0.0,) * 6


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
        All that are near enough to matter; their gradients name no other joints.
    """

    stamp: float
    positions: Mapping[str, float]
    pairs: Tuple[ProximityPair, ...]


@dataclass(frozen=True)
class ProximitySettings(Declared):
    """How the arm keeps its distance."""

    enabled: bool = parameter(True, "Whether it does at first; an operator can switch it.")
    stop_distance: float = number(
        0.005, "Distance (m) at which two bodies that must not touch stop approaching.", 0.0
    )
    deceleration: float = number(
        0.5, "With which the approach is slowed at most (m/s^2).", above=0.0
    )
    time_constant: float = number(
        0.15, "Of the last, exponential part of the approach (s).", above=0.0
    )
    touch_speed: float = number(
        0.05, "Speed (m/s) at which bodies may touch that are there to be touched.", above=0.0
    )
    touch_depth: float = number(
        0.015,
        "How far (m) such a body may be led into another by its references. They cannot"
        " go there, so it is how far they press ahead, and what they have to come back "
        "when the arm is to let go.",
        above=0.0,
    )
    max_age: float = number(
        0.25, "A report older than this (s of sim time) counts as none.", above=0.0
    )


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
        return f"{'stopped' if self.factor < STOPPED_SHARE else 'slowed'}: {self.where}"

    @property
    def where(self) -> str:
        """Which two bodies are how far apart."""
        pair, millimetres = self.pair, round(1000.0 * self.distance)
        if pair.touchable and millimetres <= 0:
            return f"{pair.link} presses on {pair.other}"
        return f"{pair.link} is {millimetres} mm from {pair.other}"


class Clearance:
    """What is near allows of the motion of some joints now.

    Parameters
    ----------
    gradients : ndarray, shape (m, n)
        Of the pairs' distances by the joints (m/rad, m/m).
    distances : ndarray, shape (m,)
        Of the pairs at the joints' references (m).
    allowed : ndarray, shape (m,)
        How fast the joints may bring the pairs nearer (m/s), 0 or more.
    """

    def __init__(
        self,
        pairs: Sequence[ProximityPair],
        gradients: np.ndarray,
        distances: np.ndarray,
        allowed: np.ndarray,
    ) -> None:
        self._pairs = pairs
        self._distances = distances
        self.gradients = gradients
        self.allowed = allowed

    def __len__(self) -> int:
        return len(self._pairs)

    def share(self, rates: np.ndarray, slack: float = 0.0) -> Tuple[float, Optional[Nearness]]:
        """Return how much of a motion in which all joints move together is allowed.

        Parameters
        ----------
        rates : ndarray, shape (n,)
            Of the joints, as they are wanted (per second).
        slack
            So much faster (m/s) they may come nearer.

        Returns
        -------
        share, reason
            From 0 to 1, and why it is below 1.
        """
        if not self._pairs:
            return 1.0, None
        closing = -(self.gradients @ rates)
        allowed = self.allowed + slack
        over = closing > allowed
        if not over.any():
            return 1.0, None
        shares = np.where(over, allowed / np.where(over, closing, 1.0), 1.0)
        worst = int(np.argmin(shares))
        return float(shares[worst]), self.nearness(worst, float(shares[worst]))

    def nearness(self, index: int, share: float) -> Nearness:
        """Say that a pair leaves a share of the speed."""
        return Nearness(self._pairs[index], float(self._distances[index]), share)

    def joint_shares(self, rates: np.ndarray) -> Tuple[np.ndarray, Optional[Nearness]]:
        """Return the same for joints that move independently: only what closes in is slowed.

        Parameters
        ----------
        rates : ndarray, shape (n,)
            See `share`.

        Returns
        -------
        shares, reason
            Of each joint (shape (n,)), and why one is below 1.
        """
        shares = np.ones(len(rates))
        worst: Optional[Nearness] = None
        for index, parts in enumerate(self.gradients * rates):
            closing = -float(parts[parts < 0.0].sum())
            free = float(self.allowed[index]) + float(parts[parts > 0.0].sum())
            if closing <= free:
                continue
            share = free / closing
            shares[parts < 0.0] = np.minimum(shares[parts < 0.0], share)
            if worst is None or share < worst.factor:
                worst = self.nearness(index, share)
        return shares, worst


class ProximityGuard:
    """Says how much of a wanted motion is allowed."""

    def __init__(self, settings: ProximitySettings) -> None:
        self._settings = settings
        self._state: Optional[ProximityState] = None
        self._joints: Tuple[str, ...] = ()
        self._gradients = np.zeros((0, 0))
        self._positions = np.zeros(0)
        self.enabled = settings.enabled

    def take(self, state: ProximityState) -> None:
        """Take what the robot says is near."""
        if tuple(state.positions) != self._joints:
            self._joints = tuple(state.positions)
        self._state = state
        self._positions = np.array(list(state.positions.values()), dtype=float)
        self._gradients = np.array(
            [[pair.gradient.get(joint, 0.0) for joint in self._joints] for pair in state.pairs]
        ).reshape(len(state.pairs), len(self._joints))

    def forget(self) -> None:
        """Forget what was near, because the robot is somewhere else now."""
        self._state = None

    def silent(self, stamp: float) -> bool:
        """Tell whether the guard should work at `stamp` (s of sim time) but is told nothing."""
        if not self.enabled:
            return False
        return self._state is None or stamp - self._state.stamp > self._settings.max_age

    def clearance(
        self,
        stamp: float,
        joints: Sequence[str],
        references: np.ndarray,
        base_twist: Optional[np.ndarray] = None,
    ) -> Clearance:
        """Return what is allowed to some joints; to all of them everything where nothing is near.

        Parameters
        ----------
        stamp
            Present sim time (s).
        joints
            Names; what is not among them rests.
        references : ndarray, shape (n,)
            Where they are told to be (rad or m): ahead of what is measured.
        base_twist : ndarray, shape (6,), optional
            Velocity of the base's origin and its rotation, along its own axes (m/s, rad/s).
        """
        state = self._state
        watched = self.enabled and state is not None and bool(state.pairs and self._joints)
        if not watched or state is None or self.silent(stamp):
            return Clearance((), np.zeros((0, len(joints))), np.zeros(0), np.zeros(0))
        columns = [self._joints.index(joint) if joint in self._joints else -1 for joint in joints]
        known = np.array([column >= 0 for column in columns])
        gradients = np.where(known, self._gradients[:, columns], 0.0)
        moved = np.where(known, references - self._positions[columns], 0.0)
        measured = np.array([pair.distance for pair in state.pairs])
        distances = measured + gradients @ moved
        allowed = [self._speed(pair, d) for pair, d in zip(state.pairs, distances.tolist())]
        if base_twist is not None:
            # What the base brings nearer the joints may not, and what it takes away they may.
            by_base = np.array([pair.base_gradient for pair in state.pairs]) @ base_twist
            allowed = np.maximum(0.0, allowed + by_base).tolist()
        return Clearance(state.pairs, gradients, distances, np.array(allowed))

    def approach(self, stamp: float, base_twist: np.ndarray) -> Optional[Nearness]:
        """Return what the base alone drives the arm against, faster than the arm may move there.

        Parameters
        ----------
        stamp, base_twist
            See `clearance`.
        """
        if not self.enabled or self._state is None or self.silent(stamp):
            return None
        worst: Optional[Nearness] = None
        for pair in self._state.pairs:
            closing = -float(np.dot(pair.base_gradient, base_twist))
            allowed = self._speed(pair, pair.distance)
            if closing > allowed and (worst is None or allowed / closing < worst.factor):
                worst = Nearness(pair, pair.distance, allowed / closing)
        return worst

    def _speed(self, pair: ProximityPair, distance: float) -> float:
        """Return how fast the two may approach (m/s)."""
        settings = self._settings
        room = max(0.0, distance - (0.0 if pair.touchable else settings.stop_distance))
        braking = math.sqrt(2.0 * settings.deceleration * room)
        speed = min(braking, room / settings.time_constant)
        if not pair.touchable:
            return speed
        depth = settings.touch_depth
        pressing = settings.touch_speed * max(0.0, min(1.0, (distance + depth) / depth))
        return max(speed, pressing)
