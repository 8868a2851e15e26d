"""Shapes set points that arrive slower than the control cycle, or far from where the joint is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

from ..common.params import Declared, number, required
from ..common.stateful import Stateful
from ..hardware.joint_limits import clamp

JUMP_TIME = 0.05
"""What a set point moves at most in this time (s), at the velocity limit, is no jump."""


STANDSTILL = 1e-9
"""Speed of a reference that rests (rad/s, m/s)."""


class ReferenceFilter(Stateful):
    """A critically damped low-pass of second order.

    Between two set points the input is constant, so the motion has a closed form (with e the
    distance to the set point, v the speed and w the frequency)::

        e(t) = (e + (v + w e) t) exp(-w t)
        v(t) = (v - w (v + w e) t) exp(-w t)

    It is exact and stable for any cycle time, and never overshoots from rest. A ramp is followed
    with a delay of 2 / w.

    Parameters
    ----------
    frequency : float
        w (rad/s), above 0.
    """

    __slots__ = ("_decay", "_frequency", "_period", "position", "velocity")
    SAVED = ("position", "velocity")

    def __init__(self, frequency: float) -> None:
        if not 0.0 < frequency < math.inf:
            raise ValueError(f"the filter's frequency is {frequency} rad/s; it must be above 0")
        self._frequency = frequency
        self._period = 0.0
        self._decay = 1.0
        self.reset(0.0)

    def reset(self, position: float) -> None:
        """Rest at `position`."""
        self.position = position
        self.velocity = 0.0

    def update(self, set_point: float, period: float) -> Tuple[float, float]:
        """Advance by `period` (s) towards `set_point`.

        Returns
        -------
        position, velocity : float
            The smoothed reference and its derivative.
        """
        if set_point == self.position and abs(self.velocity) < STANDSTILL:
            self.velocity = 0.0
            return set_point, 0.0
        if period != self._period:
            self._period = period
            self._decay = math.exp(-self._frequency * period)
        distance = self.position - set_point
        drift = self.velocity + self._frequency * distance
        self.position = set_point + (distance + drift * period) * self._decay
        self.velocity = (self.velocity - self._frequency * drift * period) * self._decay
        return self.position, self.velocity


@dataclass(frozen=True)
class ReferenceLimits(Declared):
    """How fast a joint is led to a set point far away."""

    velocity: float = number(required, "Limit (rad/s; m/s).", above=0.0)
    acceleration: float = number(required, "Limit (rad/s^2; m/s^2).", above=0.0)


class ReferenceLimiter(Stateful):
    """Leads a reference to a set point that jumps, in the shortest time that its limits allow.

    A set point that moves on in small steps is followed at once: whoever sends a stream has shaped
    it, and a limiter that must be able to stop at each of its points would lag behind. One that
    jumps is approached with limited velocity and acceleration, and reached without overshoot.
    """

    __slots__ = ("_approaching", "_limits", "position", "velocity")
    SAVED = ("_approaching", "position", "velocity")

    def __init__(self, limits: ReferenceLimits) -> None:
        self._limits = limits
        self.reset(0.0)

    def reset(self, position: float) -> None:
        """Rest at `position`."""
        self.position = position
        self.velocity = 0.0
        self._approaching = False

    def update(self, set_point: float, period: float) -> float:
        """Advance by `period` (s) towards `set_point`, and return the reference."""
        if period <= 0.0:
            return self.position
        if set_point == self.position and abs(self.velocity) < STANDSTILL:
            self.velocity = 0.0
            return set_point
        limits = self._limits
        distance = set_point - self.position
        if not self._approaching and abs(distance) <= limits.velocity * JUMP_TIME:
            # The mean over a stream's steps, which come in every fifth cycle or so: what a jump
            # finds the joint doing.
            share = min(period / JUMP_TIME, 1.0)
            self.velocity += (distance / period - self.velocity) * share
            self.position = set_point
            return set_point
        self._approaching = True
        # From rest after n cycles of braking by a each: the distance is a n (n + 1) / 2.
        change = limits.acceleration * period
        cycles = math.sqrt(0.25 + 2.0 * abs(distance) / (change * period)) - 0.5
        wanted = math.copysign(min(limits.velocity, cycles * change), distance)
        velocity = clamp(wanted, self.velocity - change, self.velocity + change)
        self.velocity = velocity
        self.position += velocity * period
        if abs(set_point - self.position) < change * period and abs(velocity) <= 2.0 * change:
            self._approaching = False
        return self.position
