"""Reference generator: a commanded velocity becomes the position that a controller has to hold.

The controllers take positions only (paper, section 4.1). A raw step of the position makes a joint
overshoot by 20 to 60 %, so the reference is limited in velocity AND in acceleration, when it
starts, turns round and stops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

# Closer than this the goal of a displacement counts as reached (rad or m); far below any encoder's
# resolution.
GOAL_TOLERANCE = 1e-9
# A displacement that takes this many times as long as a free joint needs is given up: nobody holds
# a key for it.
PATIENCE = 2.0


@dataclass(frozen=True)
class MotionLimits:
    """Bounds of one reference; rad for revolute, m for prismatic joints.

    Attributes
    ----------
    lower, upper
        Position limits of the reference, infinite where there is none.
    max_velocity
        Rate at speed scale 1 (per second).
    max_acceleration
        Of the reference, also when it stops (per second squared).
    max_lead
        How far the reference may be ahead of the measured position. It must exceed the braking
        distance from `max_velocity`, which would else never be reached. Infinite where nothing is
        measured.
    hold_tolerance
        A resting joint that leaves its reference by more than this was moved by somebody else.

    Raises
    ------
    ValueError
        When the bounds contradict each other.
    """

    lower: float
    upper: float
    max_velocity: float
    max_acceleration: float
    max_lead: float
    hold_tolerance: float

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise ValueError(f"lower limit {self.lower:g} must be below upper limit {self.upper:g}")
        for name in ("max_velocity", "max_acceleration"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} is {value!r}; must be a finite number above 0")
        for name in ("max_lead", "hold_tolerance"):
            value = getattr(self, name)
            if not value > 0.0:
                raise ValueError(f"{name} is {value!r}; must be above 0")
        if self.max_lead <= self.braking_distance:
            raise ValueError(
                f"max_lead {self.max_lead:g} must exceed {self.braking_distance:g}, the braking "
                f"distance from {self.max_velocity:g}/s at {self.max_acceleration:g}/s2; raise it, "
                "lower max_velocity or shorten acceleration_time"
            )

    @property
    def braking_distance(self) -> float:
        """Way from `max_velocity` to rest (rad or m)."""
        return self.max_velocity**2 / (2.0 * self.max_acceleration)


class ReferenceGenerator:
    """Moves the reference of one joint.

    It is idle until `jog`, `displace` or `seek` ask for motion, and again once that has come to
    rest.

    Parameters
    ----------
    limits
        Bounds that every update keeps. Two of them yield to what is measured: a joint found outside
        its position limits may move inwards only, and a joint that is thrown back by more than the
        lead stops its reference at once, faster than `max_acceleration`.
    """

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._reference: Optional[float] = None
        self._velocity = 0.0
        self._rate = 0.0
        self._goal: Optional[float] = None
        self._increment = 0.0
        self._goal_time_left = 0.0
        self._nearest = math.inf
        self._resting = True
        self._limited = False

    @property
    def reference(self) -> Optional[float]:
        """Last reference (rad or m), None when there is none to go on from."""
        return self._reference

    @property
    def velocity(self) -> float:
        """Velocity of the reference in the last update (rad/s or m/s)."""
        return self._velocity

    @property
    def limited(self) -> bool:
        """Whether a position limit or the lead held the reference back in the last update."""
        return self._limited

    @property
    def moving(self) -> bool:
        """Whether motion is asked for or still dies away."""
        return self._rate != 0.0 or self._velocity != 0.0 or self.displacing

    @property
    def displacing(self) -> bool:
        """Whether the way to a goal is not done yet."""
        return self._goal is not None or self._increment != 0.0

    def jog(self, rate: float) -> None:
        """Move at a rate (rad/s or m/s, clamped to the maximum) until told otherwise; 0 stops."""
        self._rate = _clamp(rate, -self.limits.max_velocity, self.limits.max_velocity)
        self._goal = None
        self._increment = 0.0

    def stop(self) -> None:
        """Come to rest along the braking distance."""
        self.jog(0.0)

    def displace(self, increment: float) -> None:
        """Move the reference once by an increment (rad or m); increments add up."""
        self._rate = 0.0
        self._increment += increment

    def seek(self, goal: float) -> None:
        """Move to a position (rad or m, clamped to the limits) until told otherwise."""
        goal = _clamp(goal, self.limits.lower, self.limits.upper)
        at_goal = self._reference is not None and abs(goal - self._reference) <= GOAL_TOLERANCE
        if at_goal and not self.moving:
            return
        self._rate = 0.0
        self._increment = 0.0
        self._goal = goal
        self._goal_time_left = math.inf

    def drop(self) -> None:
        """Stop at once and forget the reference: what comes next starts where the joint is."""
        self.jog(0.0)
        self._reference = None
        self._velocity = 0.0
        self._resting = True
        self._limited = False

    def rest_at(self, reference: float) -> None:
        """Take over a reference that somebody else of this node has moved there."""
        self.drop()
        self._reference = reference
        self._nearest = math.inf

    def start_from(self, position: float) -> float:
        """Return where a new motion of a joint measured at `position` starts (rad or m)."""
        if self._reference is None:
            return position
        # a joint that is pressed rests at the lead itself, which rounding must not exceed
        near = abs(self._reference - position) <= self.limits.max_lead + GOAL_TOLERANCE
        return self._reference if near else position

    def update(self, dt: float, position: float, speed_scale: float = 1.0) -> Optional[float]:
        """Move the reference by one step.

        Parameters
        ----------
        dt
            Time since the last update (s), above 0.
        position
            Measured position (rad or m).
        speed_scale
            Factor on the commanded rate, above 0, at most 1.

        Returns
        -------
        float or None
            The reference to send; None while idle.
        """
        if not self.moving:
            self._watch(position)
            return None
        if self._resting:
            self._begin(position)
        reference = self._reference
        assert reference is not None
        self._take_increment(reference, speed_scale)
        wanted = self._wanted_velocity(dt, reference, speed_scale)
        moved = self._step(dt, reference, position, wanted)
        self._resting = not self.moving
        return moved

    def _watch(self, position: float) -> None:
        """Forget the reference of a resting joint that somebody else moves."""
        self._resting = True
        self._limited = False
        if self._reference is None:
            return
        deviation = abs(self._reference - position)
        # A joint that presses on something rests off its reference; what counts is that it went
        # further off.
        self._nearest = min(self._nearest, deviation)
        if deviation > self._nearest + self.limits.hold_tolerance:
            self._reference = None

    def _begin(self, position: float) -> None:
        self._reference = self.start_from(position)
        self._resting = False
        self._nearest = math.inf

    def _take_increment(self, reference: float, speed_scale: float) -> None:
        if self._increment == 0.0:
            return
        start = reference if self._goal is None else self._goal
        lower, upper = min(self.limits.lower, reference), max(self.limits.upper, reference)
        self._goal = _clamp(start + self._increment, lower, upper)
        self._increment = 0.0
        speed = self.limits.max_velocity * speed_scale
        free = abs(self._goal - reference) / speed + 2.0 * speed / self.limits.max_acceleration
        self._goal_time_left = PATIENCE * free

    def _wanted_velocity(self, dt: float, reference: float, speed_scale: float) -> float:
        if self._goal is None:
            return self._rate * speed_scale
        way = self._goal - reference
        self._goal_time_left -= dt
        arrived = abs(way) <= GOAL_TOLERANCE
        slow = abs(self._velocity) <= self.limits.max_acceleration * dt
        if (arrived and slow) or self._goal_time_left <= 0.0:
            self._goal = None
            return 0.0
        speed = min(self._stoppable(abs(way), dt), self.limits.max_velocity * speed_scale)
        return math.copysign(speed, way)

    def _step(self, dt: float, reference: float, position: float, wanted: float) -> float:
        limits = self.limits
        # a reference that is already outside may stay there, but goes no further
        top = max(reference, min(limits.upper, position + limits.max_lead))
        bottom = min(reference, max(limits.lower, position - limits.max_lead))
        allowed = _clamp(
            wanted,
            -self._stoppable(reference - bottom, dt),
            self._stoppable(top - reference, dt),
        )
        change = limits.max_acceleration * dt
        velocity = _clamp(allowed, self._velocity - change, self._velocity + change)
        moved = _clamp(reference + velocity * dt, bottom, top)
        if moved != reference + velocity * dt:
            velocity = (moved - reference) / dt
        self._reference = moved
        self._velocity = velocity
        self._limited = abs(allowed) < abs(wanted)
        return moved

    def _stoppable(self, distance: float, dt: float) -> float:
        return stoppable_speed(self.limits.max_acceleration, distance, dt)


def stoppable_speed(acceleration: float, distance: float, dt: float) -> float:
    """Return the largest speed from which a reference can come to rest within a distance.

    The way of this step at that speed v and the braking distance after it must fit: ``v dt +
    v^2 / (2 a) = distance``. Then braking by ``a dt`` keeps the condition in every later step,
    whatever its length.
    """
    change = acceleration * dt
    return math.sqrt(change**2 + 2.0 * acceleration * distance) - change


def _clamp(value: float, low: float, high: float) -> float:
    return max(low, min(high, value))
