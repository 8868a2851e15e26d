"""Exercises of the arm: briefcase, pallet, cube. The places of all objects are known."""

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

_POT_REACH = 0.85  # m, from base_link to the pot
_CAPSULE_GRIP = 0.10  # m, of the tool over the capsule's foot: the fingertips reach 5 cm beyond it
_INTO_POT = 0.04  # m, of the capsule's foot below the rim when it is let go
_BESIDE_LID, _PUSHED = (
    0.40,
    0.10,
)  # m, beside the pot's middle, before the push at the lid and after

_PALLET_LENGTH = 1.2  # m


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


def source_to_pot(hand: Hand, brief: Brief) -> None:
    """Put the capsule into its pot, shut the lid, and drive back."""
    station = hand.station
    station.mode("CARTESIAN")
    pot = brief.entries["pot"]
    px, py, pz = pot["position"]
    rim = np.array([px, py, pz + float(pot["height"]), 1.0])
    # Prepared from afar: beside the source every second counts.
    station.hold_preset("flat")
    hand.to(aimed(_POT_REACH - 0.15, 0.0, 0.55, 0.0, 1.3), tolerance=0.03)
    hand.open(_CUBE_OPENING)
    driving.run_to(station, (rim[0] - _POT_REACH, 0.0), 0.4, heading=0.0)
    station.stop()
    station.wait(0.4)
    station.hold_preset("")
    here = inverse(station.base())
    x, y, z = (here @ station.object_pose("capsule") @ (0.0, 0.0, _CAPSULE_GRIP, 1.0))[:3]
    hand.to(aimed(x, y, z + _OVER, 0.0, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z, 0.0, _DOWN), tolerance=0.006)
    hand.grip(_CUBE_FORCE)
    over = (here @ rim)[:3] + (0.0, 0.0, _CAPSULE_GRIP)
    high = over[2] + 0.04
    hand.to(aimed(x, y, high, 0.0, _DOWN), tolerance=0.01)
    hand.to(aimed(over[0], over[1], high, 0.0, _DOWN), tolerance=0.008)
    hand.to(aimed(over[0], over[1], over[2] - _INTO_POT, 0.0, _DOWN), tolerance=0.008)
    hand.open(_CUBE_OPENING)
    hand.to(aimed(over[0], over[1], high, 0.0, _DOWN), tolerance=0.02)
    # Around the open lid, and against it from outside.
    before, beside = over[0] - 0.30, over[1] + _BESIDE_LID
    hand.to(aimed(before, over[1], high, 0.0, 0.6), tolerance=0.03)
    hand.to(aimed(before, beside, high, 0.0, 0.6), tolerance=0.03)
    hand.to(aimed(over[0] - 0.03, beside, over[2], 0.0, 0.6), tolerance=0.02)
    hand.to(aimed(over[0] - 0.03, over[1] + _PUSHED, over[2], 0.0, 0.6), tolerance=0.02)
    hand.to(aimed(before, beside, high, 0.0, 0.6), tolerance=0.03)
    driving.run_to(station, (0.0, 0.0), 0.5, True)
    station.stop()


def _upright_turn(angle: float) -> float:
    """Turn (rad) of a hand that grips a cube turned by `angle` by the nearest pair of sides."""
    quarter = 0.5 * math.pi
    return angle - quarter * round(angle / quarter)
