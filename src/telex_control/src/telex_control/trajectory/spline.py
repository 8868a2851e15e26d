"""Polynomials in time between two states of one joint."""

from __future__ import annotations

from typing import NamedTuple, Optional, Tuple

Sample = Tuple[float, float, float]
"""Position, velocity and acceleration."""


class State(NamedTuple):
    """State of one joint at one instant (rad, m), with what is known of its derivatives."""

    position: float
    velocity: Optional[float] = None
    acceleration: Optional[float] = None


class SplineSegment:
    """The way from one state to another.

    Linear when only positions are known of both, cubic with velocities, quintic with accelerations
    too.

    Parameters
    ----------
    start_time, end_time : float
        (s); the end is not before the start.
    """

    __slots__ = ("_coefficients", "end", "end_time", "start", "start_time")

    def __init__(self, start_time: float, start: State, end_time: float, end: State) -> None:
        if end_time < start_time:
            raise ValueError(f"a segment from {start_time} s to {end_time} s ends before it starts")
        self.start_time = start_time
        self.start = start
        self.end_time = end_time
        self.end = end
        self._coefficients = _coefficients(end_time - start_time, start, end)

    def shifted(self, by: float) -> SplineSegment:
        """Return the same way, later by so much (s)."""
        start = self.start_time + by
        return SplineSegment(start, self.start, start + (self.end_time - self.start_time), self.end)

    def sample(self, time: float) -> Sample:
        """Return the state at `time` (s); at rest before the start and after the end."""
        if time > self.end_time:
            return self.end.position, 0.0, 0.0
        if time < self.start_time:
            return self.start.position, 0.0, 0.0
        a0, a1, a2, a3, a4, a5 = self._coefficients
        t = time - self.start_time
        return (
            a0 + t * (a1 + t * (a2 + t * (a3 + t * (a4 + t * a5)))),
            a1 + t * (2.0 * a2 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5))),
            2.0 * a2 + t * (6.0 * a3 + t * (12.0 * a4 + t * 20.0 * a5)),
        )


def _coefficients(duration: float, start: State, end: State) -> Tuple[float, ...]:
    """Return a0 to a5 of the polynomial in the time since the start."""
    p0, p1 = start.position, end.position
    if duration <= 0.0:
        # Nothing to interpolate: the end is there at once.
        return p1, end.velocity or 0.0, 0.5 * (end.acceleration or 0.0), 0.0, 0.0, 0.0
    way = p1 - p0
    if start.velocity is None or end.velocity is None:
        return p0, way / duration, 0.0, 0.0, 0.0, 0.0
    # In the unit of the duration, so that all have the dimension of a position.
    v0, v1 = start.velocity * duration, end.velocity * duration
    if start.acceleration is None or end.acceleration is None:
        unit = (p0, v0, 3.0 * way - 2.0 * v0 - v1, -2.0 * way + v0 + v1, 0.0, 0.0)
    else:
        square = duration * duration
        w0, w1 = start.acceleration * square, end.acceleration * square
        unit = (
            p0,
            v0,
            0.5 * w0,
            10.0 * way - 6.0 * v0 - 4.0 * v1 - 1.5 * w0 + 0.5 * w1,
            -15.0 * way + 8.0 * v0 + 7.0 * v1 + 1.5 * w0 - w1,
            6.0 * way - 3.0 * (v0 + v1) - 0.5 * (w0 - w1),
        )
    return tuple(value / duration**power for power, value in enumerate(unit))
