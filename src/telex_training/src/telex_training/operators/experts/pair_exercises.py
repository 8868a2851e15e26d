"""Exercises for two robots: each operator sees his own, and of the other what the load shows."""

from __future__ import annotations

import math

import numpy as np

from telex_control.common.geometry.matrices import inverse

from .. import driving
from ..handling import Hand, aimed
from ..station import Station
from ..tasks.task import heading_of
from .brief import Brief

_DOWN, _ACROSS = 0.5 * math.pi, 0.5 * math.pi
_GRIPPED = 0.95  # m, from the beam's middle to each red mark
_REACH = 0.85  # m, from base_link to the beam
_OPENING = 0.32  # rad
_FORCE = 70.0  # N
_ABOVE = 0.045  # m, of the tool over the beam's underside: the fingertips reach 5 cm beyond it
_OVER, _LIFT = 0.15, 0.16  # m
_SIGN, _SEEN = 0.02, 0.01  # m, that an end is raised as a sign, and that the other one sees
_LONG = 90.0  # s, for which one waits for the other
_SPEED, _CREEP, _SLOWING = 0.15, 0.03, 1.0  # m/s, m/s, 1/s
_RAMP = 1.5  # s, until that speed
_ABREAST = 1.5  # 1/s, of the speed by how far the own end is ahead
_LYING = 0.006  # m, over its stands, from where on it lies


class _End:
    """An operator's end of the beam, as he sees it.

    Attributes
    ----------
    side : float
        1 for the left end, -1 for the right one.
    """

    def __init__(self, station: Station) -> None:
        self._station = station
        here = inverse(self.pose()) @ station.base()
        self.side = math.copysign(1.0, here[1, 3])
        self.lying = self.height()

    def pose(self) -> np.ndarray:
        """Of the beam's middle, on its underside, in the world."""
        return self._station.object_pose("beam")

    def place(self, side: float = 0.0) -> np.ndarray:
        """Where the mark of a side is in the world (m); the own one by default."""
        return (self.pose() @ (0.0, (side or self.side) * _GRIPPED, 0.0, 1.0))[:3]

    def height(self, side: float = 0.0) -> float:
        """Of a mark over the floor (m)."""
        return float(self.place(side)[2])

    def raised(self, side: float = 0.0) -> float:
        """How far a mark is above where it lay (m)."""
        return self.height(side) - self.lying

    def ahead(self, heading: float) -> float:
        """How far the own end is ahead of the middle (m), where the beam lay at a heading (rad)."""
        turned = math.remainder(heading_of(self.pose()) - heading, 2.0 * math.pi)
        return -self.side * _GRIPPED * math.sin(turned)


def beam(hand: Hand, brief: Brief) -> None:
    """Carry a beam together: one does this for each robot.

    They agree by what both see of the beam. Who holds his end raises it a little; once both ends
    are up, both lift; once it is up and level, both drive, and who is ahead drives slower; where it
    rests over its goal, both lower.
    """
    station = hand.station
    station.mode("CARTESIAN")
    end = _End(station)
    _grip(hand, end)
    _lift(hand, end)
    goal = float(brief.entries["left_goal"]["position"][0])
    _carry(station, end, goal)
    _lay_down(hand, end)


def _grip(hand: Hand, end: _End) -> None:
    station = hand.station
    hand.to_named_pose("ready")
    hand.open(_OPENING)
    hand.to(aimed(_REACH - 0.1, 0.0, 0.62, _ACROSS, _DOWN), tolerance=0.03)
    x, y, _ = end.place()
    driving.run_to(station, (x - _REACH, y), 0.3, heading=0.0)
    station.stop()
    station.wait(0.5)
    here = inverse(station.base())
    x, y, z = (here @ np.append(end.place(), 1.0))[:3]
    yaw = heading_of(here @ end.pose()) + _ACROSS
    hand.to(aimed(x, y, z + _ABOVE + _OVER, yaw, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z + _ABOVE, yaw, _DOWN), tolerance=0.006)
    hand.grip(_FORCE)


def _lift(hand: Hand, end: _End) -> None:
    station = hand.station
    _raise(hand, _SIGN)
    other = -end.side
    station.until(
        lambda: min(end.raised(), end.raised(other)) > _SEEN, _LONG, "the other end of the beam up"
    )
    station.wait(0.5)
    _raise(hand, _LIFT - _SIGN)
    station.until(
        lambda: min(end.raised(), end.raised(other)) > _LIFT - _SEEN, _LONG, "the beam up and level"
    )
    station.wait(0.5)


def _raise(hand: Hand, height: float) -> None:
    tool = hand.tool()
    tool[2, 3] += height
    hand.to(tool, tolerance=0.006)


def _carry(station: Station, end: _End, goal: float) -> None:
    lane = (station.pose.x, station.pose.y)
    heading, began = heading_of(end.pose()), station.time

    def left() -> float:
        return goal - float(end.pose()[0, 3])

    def drive() -> None:
        pace = min(_SPEED, max(_CREEP, _SLOWING * left()))
        pace *= min(1.0, (station.time - began) / _RAMP)
        station.keep_lane(max(0.0, pace - _ABREAST * end.ahead(heading)), lane)

    station.until(lambda: left() < 0.01, 60.0, "the beam over its goal", drive)
    station.stop()
    station.wait(1.0)


def _lay_down(hand: Hand, end: _End) -> None:
    station, other = hand.station, -end.side
    tool = hand.tool()
    low = tool.copy()
    low[2, 3] -= _LIFT + 0.02
    hand.to(low, tolerance=0.01, enough=lambda: end.raised() < _LYING)
    station.until(
        lambda: max(end.raised(), end.raised(other)) < _LYING, _LONG, "the other end laid down"
    )
    station.wait(0.3)
    hand.open(_OPENING)
    hand.to(tool, tolerance=0.03)
