"""Following a line without a stop, by looking a little ahead along it."""

from __future__ import annotations

import math
from typing import Sequence

from ..driving import Point
from ..station import Station

_GAIN, _MOST = 2.5, 0.9  # 1/s, rad/s
_ARRIVED = 0.05  # m
_SLOWEST = 0.25
"""Share of the speed that is kept in a bend."""
_SPACING = 0.02  # m


def pursue(station: Station, points: Sequence[Point], speed: float, ahead: float = 0.30) -> None:
    """Drive along a line of points, and stop at its end.

    Parameters
    ----------
    points : sequence of tuple of 2 floats
        Corners of the line, in the station's course (m).
    speed : float
        At most (m/s).
    ahead : float
        How far ahead along the line it is looked (m).

    Raises
    ------
    NotManagedError
        The end is not reached.
    """
    line = _dense([(station.pose.x, station.pose.y), *points])
    nearest = 0

    def left() -> float:
        return (len(line) - 1 - nearest) * _SPACING

    def steer() -> None:
        nonlocal nearest
        here = (station.pose.x, station.pose.y)
        # Only a little further on: a line may come back beside itself.
        window = range(nearest, min(len(line), nearest + round(0.5 / _SPACING)))
        nearest = min(window, key=lambda index: math.dist(here, line[index]))
        goal = line[min(len(line) - 1, nearest + round(ahead / _SPACING))]
        bearing = math.atan2(goal[1] - here[1], goal[0] - here[0])
        error = math.remainder(bearing - station.pose.yaw, 2.0 * math.pi)
        pace = speed * max(_SLOWEST, math.cos(1.5 * error)) if abs(error) < 1.0 else 0.0
        station.drive(pace, max(-_MOST, min(_MOST, _GAIN * error)))

    length = len(line) * _SPACING
    station.until(
        lambda: left() < _ARRIVED,
        10.0 + 4.0 * length / speed,
        f"the end of a line of {length:.1f} m",
        steer,
    )
    station.stop()
    station.wait(0.2)


def _dense(points: Sequence[Point]) -> Sequence[Point]:
    made = [points[0]]
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        count = max(1, round(math.dist((ax, ay), (bx, by)) / _SPACING))
        made += [
            (ax + (bx - ax) * step / count, ay + (by - ay) * step / count)
            for step in range(1, count + 1)
        ]
    return made
