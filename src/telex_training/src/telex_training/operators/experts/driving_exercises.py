"""Exercises of driving: slalom, confinement, gap, hurdle, stairs, ramps, rails, posts, survey."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List

from .. import driving
from ..driving import Point
from ..handling import Hand
from ..station import Station
from ..terrain import gap, hurdle, rough, slope, stairs
from .brief import Brief
from .pursuit import pursue

_SPEED, _NARROW = 0.45, 0.30  # m/s
_ASIDE = 0.62
"""How far from the cones' line a cone is passed (m)."""
_TURNING = 1.25
"""How far behind the last cone the robot turns (m)."""
_POINTS = 8
_ON_SLOPE = 0.12
"""Difference of the hull's rise from the slope's with which it lies on it (rad)."""
_BEYOND_MIDDLE = 0.1
"""How far behind the platform's middle the robot turns (m)."""
_CLEAR = 1.3
"""How far behind the last step no flipper touches it any more (m)."""
_RAMPS, _ON_RAILS = 0.30, 0.25  # m/s
_OVER_POSTS = 0.20
"""Speed over posts (m/s): more slowly, the robot hangs on them."""
_RUN_UP = 1.0
"""How far before posts the robot slows down, with its tips still off them (m)."""
_BEHIND_POSTS = 1.5
"""How far behind the posts the robot turns (m)."""
_BEHIND_RAMPS = 1.5
"""How far behind the last ramp the robot turns (m)."""
_SURVEY, _FROM_LINE = 0.30, 1.0  # m/s, m
_BEHIND_SIGN = 1.5
"""How far behind the last sign the survey ends (m)."""


def slalom(hand: Hand, brief: Brief) -> None:
    """Around the cones along x, in turn to their left and right, and back on the other sides."""
    station = hand.station
    station.hold_preset("folded")
    cones = sorted(
        entry["position"][0] for name, entry in brief.entries.items() if name.startswith("cone_")
    )
    pursue(station, _wave(cones), _SPEED)
    driving.turn_to(station, math.pi, 0.05)
    home = [(x, -y) for x, y in reversed(_wave(cones)[:-1])]
    pursue(station, [*home, (0.0, 0.0)], _SPEED)


def _wave(cones: List[float]) -> List[Point]:
    """Points of a line around cones at these x (m), the first passed with it to the right."""
    points: List[Point] = []
    pitch = cones[1] - cones[0]
    for number, x in enumerate(cones):
        side = 1.0 if number % 2 == 0 else -1.0
        for step in range(_POINTS + 1):
            along = step / _POINTS - 0.5
            points.append((x + along * pitch, side * _ASIDE * math.cos(math.pi * along)))
    return [*points, (cones[-1] + _TURNING, 0.0)]


def confinement(hand: Hand, brief: Brief) -> None:
    """Along the corridor, round its corner, through the narrow part, and back backwards."""
    station = hand.station
    station.hold_preset("folded")
    station.wait(2.0)
    corner = float(brief.entries["narrow_left"]["position"][0]) - _half_thickness(brief)
    x = corner + 0.6
    driving.run_to(station, (x, 0.0), _SPEED, heading=0.0)
    driving.turn_to(station, 0.5 * math.pi)
    driving.run_to(station, (x, 5.4), _NARROW, heading=0.5 * math.pi)
    station.stop()
    station.wait(0.7)
    driving.run_to(station, (x, 0.0), _NARROW, backwards=True, heading=0.5 * math.pi)
    driving.turn_to(station, 0.0)
    driving.run_to(station, (0.0, 0.0), _SPEED, backwards=True, heading=0.0)
    station.stop()
    station.wait(0.7)


def _half_thickness(brief: Brief) -> float:
    return 0.5 * float(brief.entries["narrow_left"]["thickness"])


def over_gap(hand: Hand, brief: Brief) -> None:
    """Over the gap, and back."""
    entry = brief.entries["gap"]
    ground = gap.Gap(
        width=float(entry["gap"]),
        height=float(entry["height"]),
        platform=float(entry["platform"]),
        ramp=float(entry["ramp"]),
        middle=float(entry["position"][0]),
    )
    gap.cross(hand.station, ground)
    back = _turned(hand.station, 2.0 * ground.middle, 7.0)
    gap.cross(back, ground)
    _home(back, 2.0 * ground.middle)


def over_hurdle(hand: Hand, brief: Brief) -> None:
    """Over the hurdle, and back."""
    entry = brief.entries["hurdle"]
    middle, length = float(entry["position"][0]), float(entry["length"])
    barrier = hurdle.Hurdle(float(entry["height"]), length, edge=middle - 0.5 * length)
    hurdle.cross(hand.station, barrier)
    back = _turned(hand.station, 2.0 * middle, 4.3)
    hurdle.cross(back, barrier)
    _home(back, 2.0 * middle)


def _turned(station: Station, there: float, x: float) -> Station:
    """Drive on to an x (m), turn round, and return a station on the course back from `there`."""
    station.hold_preset("drive")
    driving.run_to(station, (x, 0.0), _SPEED, heading=0.0)
    driving.turn_to(station, math.pi)
    station.release()
    back = Station(station.port)
    back.enter((there, 0.0, math.pi))
    return back


def _home(station: Station, x: float) -> None:
    driving.run_to(station, (x, 0.0), _SPEED, heading=0.0)
    station.stop()


def over_stairs(hand: Hand, brief: Brief) -> None:
    """Up the stairs, whole onto the landing, and down behind it."""
    entry = brief.entries["stairs"]
    rise, run, steps = float(entry["rise"]), float(entry["run"]), int(entry["steps"])
    landing = float(entry["landing"])
    foot = float(entry["position"][0]) - 0.5 * landing - run * (steps - 1)
    flight = stairs.Stairs(rise, run, steps, landing, foot=foot)
    stairs.climb(hand.station, flight)
    stairs.descend(hand.station, flight)
    driving.run_to(hand.station, (flight.end + _CLEAR, 0.0), _SPEED, heading=0.0)
    hand.station.stop()


def incline(hand: Hand, brief: Brief) -> None:
    """Up the plane, a turn on top, and down."""
    station = hand.station
    entry = brief.entries["plane"]
    angle, length = float(entry["angle"]), float(entry["length"])
    top = float(entry["position"][0]) + 0.5 * length * math.cos(angle)
    foot = top - 0.5 * float(entry["platform"]) - length * math.cos(angle)
    station.flippers(*slope.ONTO)
    station.keep_lane(_NARROW)
    station.until(
        lambda: station.pose.x > foot and abs(station.pose.rise - angle) < _ON_SLOPE,
        20.0,
        "on the slope",
    )
    station.flippers(*slope.FLAT)
    station.until(lambda: station.pose.x > top + _BEYOND_MIDDLE, 20.0 + 4.0 * length, "on top")
    station.stop()
    station.wait(0.5)
    station.hold_preset("folded")
    station.wait(1.5)
    driving.turn_to(station, math.pi)
    station.hold_preset("")
    station.flippers(*slope.FLAT)
    station.wait(1.5)
    driving.run_to(station, (0.0, 0.0), _NARROW, heading=math.pi)
    station.stop()
    station.wait(0.7)


def over_ramps(hand: Hand, brief: Brief) -> None:
    """Over ramps that rise and fall across the whole lane, and back."""
    entry = brief.entries["ramps"]
    length, rows = float(entry["length"]), int(entry["rows"])
    ridge = length * math.tan(float(entry.get("angle", math.radians(15.0))))
    middle, end = float(entry["position"][0]), float(entry["position"][0]) + 0.5 * rows * length

    def height(x: float, y: float) -> float:
        # Both ways alike: the lane is the same from either end.
        along = abs(x - middle) / length
        if along >= 0.5 * rows:
            return 0.0
        share = (0.5 * rows - along) % 2.0
        return ridge * (share if share < 1.0 else 2.0 - share)

    rough.cross(hand.station, height, end, _RAMPS)
    back = _turned(hand.station, 2.0 * middle, end + _BEHIND_RAMPS)
    rough.cross(back, height, end, _RAMPS)
    _home(back, 2.0 * middle)


def over_crossing_ramps(hand: Hand, brief: Brief) -> None:
    """Over ramps of which one side rises where the other falls, and back."""
    entry = brief.entries["ramps"]
    angle = float(entry.get("angle", rough.CrossingRamps.angle))
    rows, length, width = int(entry["rows"]), float(entry["length"]), float(entry["width"])
    middle = float(entry["position"][0])
    start = middle - 0.5 * (rows + 1) * length
    ramps = rough.CrossingRamps(rows, length, width, angle=angle, start=start)
    rough.cross(hand.station, ramps.height, ramps.end)
    back = _turned(hand.station, 2.0 * middle, ramps.end + _BEHIND_RAMPS)
    rough.cross(back, rough.from_behind(ramps.height, middle), ramps.end)
    _home(back, 2.0 * middle)


def over_rails(hand: Hand, brief: Brief) -> None:
    """Over the rails to the far platform, a turn on it, and back."""
    station = hand.station
    far = float(brief.entries["far_platform"]["position"][0])
    for goal, heading in ((far, 0.0), (0.0, math.pi)):
        driving.turn_to(station, heading)
        driving.run_to(station, (goal, 0.0), _ON_RAILS, heading=heading)
        station.stop()
        station.wait(0.7)


def radiation_survey(hand: Hand, brief: Brief) -> None:
    """Along the beam line with the detector ahead, at the survey's speed, and tell the hot spot."""
    station = hand.station
    station.hold_preset("folded")
    line = float(brief.entries["line"]["position"][1])
    end = float(brief.entries["sign_10"]["position"][0]) + _BEHIND_SIGN
    driving.run_to(station, (end, line - _FROM_LINE), _SURVEY, heading=0.0)
    station.stop()
    station.wait(0.5)
    station.port.answer("hottest", brief.answers["hottest"])


def over_posts(hand: Hand, brief: Brief) -> None:
    """Over the field of posts, and back."""
    station, entry = hand.station, brief.entries["posts"]
    posts = rough.Stepfield(entry["pattern"], int(entry["pallets"]), int(entry["seed"]))
    middle, half = float(entry["position"][0]), 0.5 * (posts.end - posts.start)
    posts = replace(posts, start=middle - half)
    _up_to(station, posts.start)
    rough.cross(station, posts.height, posts.end, _OVER_POSTS)
    back = _turned(station, 2.0 * middle, posts.end + _BEHIND_POSTS)
    _up_to(back, posts.start)
    rough.cross(back, rough.from_behind(posts.height, middle), posts.end, _OVER_POSTS)
    _home(back, 2.0 * middle)


def _up_to(station: Station, edge: float) -> None:
    """Drive up to rough ground, if it is still far."""
    station.keep_lane(_SPEED)
    station.until(lambda: station.pose.x > edge - _RUN_UP, 20.0, "the run-up")
