"""Exercises of the arm: briefcase, pallet, cube, valve. The places of all objects are known."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from telex_control.common.geometry.matrices import inverse

from .. import driving
from ..handling import Hand, aimed
from ..tasks import briefcase as case
from ..tasks.pallet import HEIGHT, PalletSide
from ..tasks.task import heading_of
from .brief import Brief

_LEVEL, _DOWN = 0.0, 0.5 * math.pi
_AXLE = 0.11  # m, of base_link over the floor

# The briefcase's place, and how far before the base its case is carried (m).
_TARGET: Tuple[float, float] = (-0.7, 0.0)
_CARRIED, _BACK = 0.90, 1.2
_CARRY_SPEED, _GENTLE = 0.5, 0.25  # m/s
_CASE_LIFT = 0.16

_CUBE_REACH = 0.80  # m, from base_link to the cube
_CUBE_FORCE = 40.0  # N
_ABOVE_CUBE = 0.034  # m, of the tool over the cube's middle: the fingertips reach 5 cm beyond it
_OVER = 0.22  # m
_CUBE_OPENING = 0.24  # rad

_PALLET_LENGTH = 1.2  # m

_VALVE_REACH = 0.85  # m, from base_link to the wheel's plane
_WHEEL_AHEAD = 0.16  # m, of the wheel before the valve's middle
_CRANK = 0.060  # m, from the axis, where the fingers push a spoke
_THROUGH, _BEFORE = -0.03, 0.14  # m, of the tool past the wheel's plane; and before it
_TURN, _PIECES = 2.0 * math.pi + 0.9, 28
"""How far the fingers go round (rad): a part of it until they meet a spoke."""


def briefcase(hand: Hand, brief: Brief) -> None:
    """Take the case by its handle, carry it backwards to its place, and set it down."""
    station = hand.station
    station.mode("CARTESIAN")
    case.take(hand)
    heading = station.pose.yaw
    back = (
        station.pose.x - _BACK * math.cos(heading),
        station.pose.y - _BACK * math.sin(heading),
    )
    driving.run_to(station, back, _CARRY_SPEED, True)
    station.stop()
    station.wait(0.6)
    goal = (_TARGET[0] - _CARRIED, _TARGET[1])
    away = math.atan2(station.pose.y - goal[1], station.pose.x - goal[0])
    driving.turn_to(station, away, 0.03)
    reach = float(np.linalg.norm((hand.tool())[:2, 3]))
    goal = (_TARGET[0] - reach * math.cos(away), _TARGET[1] - reach * math.sin(away))
    driving.run_to(station, goal, _CARRY_SPEED, True)
    station.stop()
    station.wait(1.0)
    tool = hand.tool()
    low = tool.copy()
    low[2, 3] -= _CASE_LIFT
    hand.to(low, tolerance=0.01, enough=lambda: station.object_pose("briefcase")[2, 3] < 0.004)
    hand.open(0.35)
    hand.to(tool, tolerance=0.03)


def pallet(hand: Hand, brief: Brief) -> None:
    """Lift the end of the pallet, hold it, let it down, and withdraw."""
    station = hand.station
    station.mode("CARTESIAN")
    PalletSide().act(hand)
    tool = hand.tool()
    angle = math.asin(HEIGHT / _PALLET_LENGTH)
    yaw = math.atan2(tool[1, 0], tool[0, 0])
    shift = _PALLET_LENGTH * (1.0 - math.cos(angle))
    x, y, z = tool[:3, 3] - shift * np.array([math.cos(yaw), math.sin(yaw), 0.0])
    hand.to(aimed(x, y, z - HEIGHT, yaw, 0.0, _DOWN), tolerance=0.01)
    hand.open(0.20)
    back = 0.12 * np.array([math.cos(yaw), math.sin(yaw)])
    hand.to(aimed(x - back[0], y - back[1], z - HEIGHT, yaw, 0.0, _DOWN), tolerance=0.02)


def cube_to_bin(hand: Hand, brief: Brief) -> None:
    """Put the cube from the table into the bin."""
    station = hand.station
    station.mode("CARTESIAN")
    edge = float(brief.entries["cube"]["edge"])
    cube = station.object_pose("cube")
    # Low: raised ones would meet the edge of the table.
    station.hold_preset("flat")
    hand.to_named_pose("ready")
    hand.to(aimed(_CUBE_REACH - 0.1, 0.0, 0.62, 0.0, 1.3), tolerance=0.03)
    driving.run_to(station, (cube[0, 3] - _CUBE_REACH, 0.0), 0.3, heading=0.0)
    station.stop()
    station.wait(0.4)
    station.hold_preset("")
    hand.open(_CUBE_OPENING)
    here = inverse(station.base()) @ station.object_pose("cube")
    x, y, z = (here @ (0.0, 0.0, 0.5 * edge, 1.0))[:3]
    z += _ABOVE_CUBE
    yaw = _upright_turn(heading_of(here))
    hand.to(aimed(x, y, z + _OVER, yaw, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z, yaw, _DOWN), tolerance=0.006)
    hand.grip(_CUBE_FORCE)
    hand.to(aimed(x, y, z + _OVER, yaw, _DOWN), tolerance=0.01)
    box = inverse(station.base()) @ station.object_pose("bin")
    x, y = box[:2, 3]
    hand.to(aimed(x, y, z + _OVER, 0.0, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z + 0.05, 0.0, _DOWN), tolerance=0.01)
    hand.open(_CUBE_OPENING)
    hand.to(aimed(x, y, z + _OVER, 0.0, _DOWN), tolerance=0.02)


def _upright_turn(angle: float) -> float:
    """Turn (rad) of a hand that grips a cube turned by `angle` by the nearest pair of sides."""
    quarter = 0.5 * math.pi
    return angle - quarter * round(angle / quarter)


def valve(hand: Hand, brief: Brief) -> None:
    """Open the valve: lead the closed fingers round between two spokes."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["valve"]
    place, yaw = entry["position"], float(entry.get("yaw", 0.0))
    height = float(entry["height"])
    wheel = (
        place[0] - _WHEEL_AHEAD * math.cos(yaw),
        place[1] - _WHEEL_AHEAD * math.sin(yaw),
    )

    def before(distance: float) -> driving.Point:
        return (wheel[0] - distance * math.cos(yaw), wheel[1] - distance * math.sin(yaw))

    driving.drive_to(station, before(_VALVE_REACH + 0.4))
    driving.turn_to(station, yaw)
    station.hold_preset("approach")
    hand.to_named_pose("ready")
    hand.open(0.02)
    driving.run_to(station, before(_VALVE_REACH), 0.3, heading=yaw)
    station.stop()
    station.wait(0.4)
    station.hold_preset("")
    centre = inverse(station.base()) @ (wheel[0], wheel[1], height, 1.0)
    turn = yaw - station.pose.yaw

    def at(angle: float, depth: float) -> np.ndarray:
        """Tool beside the axis, `angle` from above against the clock as it is seen.

        The hand rolls along, for closed fingers are narrow in one direction only; half a turn
        ahead, so that its joint comes round without meeting its end.
        """
        aside, up = _CRANK * math.sin(angle), _CRANK * math.cos(angle)
        return aimed(
            centre[0] + depth * math.cos(turn) - aside * math.sin(turn),
            centre[1] + depth * math.sin(turn) + aside * math.cos(turn),
            centre[2] + up,
            turn,
            0.0,
            math.pi - angle,
        )

    x, y, z = at(0.0, -_BEFORE)[:3, 3]
    hand.to(aimed(x, y, z, turn, 0.0, 0.5 * math.pi), tolerance=0.02)
    hand.to(at(0.0, -_BEFORE), tolerance=0.01)
    hand.to(at(0.0, _THROUGH), tolerance=0.01)
    for piece in range(1, _PIECES + 1):
        hand.to(at(_TURN * piece / _PIECES, _THROUGH), tolerance=0.015)
    hand.to(at(_TURN - 0.2, _THROUGH), tolerance=0.02)
    hand.to(at(_TURN - 0.2, -_BEFORE), tolerance=0.02)
