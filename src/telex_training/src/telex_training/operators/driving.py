"""Driving by where the base is seen: turning, driving to a place, following a way."""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

from .station import Station

Point = Tuple[float, float]

_TURNED = 0.015  # rad
_TURN_GAIN, _MOST_TURN, _LEAST_TURN = 1.8, 0.8, 0.10  # 1/s, rad/s
_STEER_GAIN, _MOST_STEER = 2.0, 0.6  # 1/s, rad/s
_SLOWING = 1.2  # 1/s, of the speed by the way that is left
_CREEP = 0.06  # m/s
_FACING = 0.25  # rad; from there on driving and turning at once
_NEAR = 0.012  # m
_LATE = 0.3  # m
_SETTLING = 0.35  # s


def turn_to(station: Station, heading: float, tolerance: float = _TURNED) -> None:
    """Turn in place to a heading (rad), and stand.

    Raises
    ------
    NotManagedError
        The heading is not reached.
    """

    def error() -> float:
        return math.remainder(heading - station.pose.yaw, 2.0 * math.pi)

    def steer() -> None:
        rate = min(_MOST_TURN, max(_LEAST_TURN, _TURN_GAIN * abs(error())))
        station.drive(0.0, math.copysign(rate, error()))

    # It may turn on a little as it stops: then once more.
    for _ in range(4):
        station.until(
            lambda: abs(error()) < tolerance,
            3.0 + 3.0 * abs(error()),
            f"heading {heading:.2f} rad",
            steer,
        )
        station.stop()
        station.wait(_SETTLING)
        if abs(error()) < 2.0 * tolerance:
            return


def drive_to(station: Station, goal: Point, speed: float = 0.5, backwards: bool = False) -> None:
    """Turn towards a place and drive there.

    Parameters
    ----------
    goal : tuple of 2 floats
        For base_link, in the station's course (m).
    speed : float
        At most (m/s).

    Raises
    ------
    NotManagedError
        The place is not reached.
    """
    way = math.dist((station.pose.x, station.pose.y), goal)
    if way > _NEAR:
        turn_to(station, _bearing(station, goal, backwards), _FACING)
    run_to(station, goal, speed, backwards)
    station.stop()
    station.wait(_SETTLING)


def follow(station: Station, points: Sequence[Point], speed: float = 0.5) -> None:
    """Drive along corners of a way, turning in place at each.

    Raises
    ------
    NotManagedError
        A corner is not reached; the message has its number.
    """
    for point in points:
        turn_to(station, _bearing(station, point, False), 0.05)
        run_to(station, point, speed, False)
        station.stop()
        station.wait(0.2)


def run_to(
    station: Station,
    goal: Point,
    speed: float,
    backwards: bool = False,
    heading: Optional[float] = None,
) -> None:
    """Drive to a place that lies ahead, or behind, and steer meanwhile; does not stop there.

    Parameters
    ----------
    goal : tuple of 2 floats
        For base_link (m).
    speed : float
        At most (m/s).
    heading : float, optional
        Of the line that leads there (rad), for one who has to arrive so; without it, the line is
        that from where the robot is.

    Raises
    ------
    NotManagedError
        The place is not reached.
    """
    start = (station.pose.x, station.pose.y)
    length = math.dist(start, goal)
    if length < _NEAR:
        return
    sign = -1.0 if backwards else 1.0
    along = ((goal[0] - start[0]) / length, (goal[1] - start[1]) / length)
    if heading is not None:
        along = (sign * math.cos(heading), sign * math.sin(heading))

    def left() -> float:
        return (goal[0] - station.pose.x) * along[0] + (goal[1] - station.pose.y) * along[1]

    def steer() -> None:
        aside = along[0] * (station.pose.y - goal[1]) - along[1] * (station.pose.x - goal[0])
        line = math.atan2(along[1], along[0]) + (math.pi if backwards else 0.0)
        # Near the place it is too late to come nearer to the line, and the heading counts.
        back = max(-0.4, min(0.4, 2.0 * aside)) * min(1.0, max(0.0, left() / _LATE))
        error = math.remainder(line - back - station.pose.yaw, 2.0 * math.pi)
        rate = max(-_MOST_STEER, min(_MOST_STEER, _STEER_GAIN * error))
        pace = min(speed, max(_CREEP, _SLOWING * left()))
        # Slower while it does not look along its way yet.
        station.drive(sign * pace * max(0.2, math.cos(2.0 * error)), rate)

    station.until(
        lambda: left() < _NEAR,
        5.0 + 3.0 * length / speed,
        f"x {goal[0]:.2f} y {goal[1]:.2f} m",
        steer,
    )


def _bearing(station: Station, goal: Point, backwards: bool) -> float:
    angle = math.atan2(goal[1] - station.pose.y, goal[0] - station.pose.x)
    return angle + math.pi if backwards else angle
