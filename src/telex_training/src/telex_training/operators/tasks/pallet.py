"""Lifting one side of a pallet."""

from __future__ import annotations

import math
from typing import Any, Dict

import numpy as np

from telex_control.common.geometry.matrices import inverse

from .. import driving
from ..handling import CLOSING_ON, Hand, aimed
from ..station import Station
from .task import OperatorTask, Verdict, heading_of, placed

HEIGHT = 0.15  # m, that the side is lifted by
REQUIRED = 0.12  # m, for how long the operator holds it there, all the time
HOLD = 2.0  # s

_LENGTH = 1.2  # m
_SIDE, _ACROSS = -0.6, 0.186  # m, in the pallet's frame: its end, between two of its blocks
_BOARDS = 0.122  # m, middle of the two boards at its end above the floor
_BITE = 0.022  # m, of the pads' middle past the end
_AHEAD, _SCATTER = 2.5, (0.15, 0.25, 0.30)  # m, m, m, rad
_APPROACH, _NEAR, _REACH = 1.6, 0.93, 0.85  # m, from base_link to the end; to the tool before it
_ON_EDGE = 0.5 * math.pi  # rad, roll with which one finger is above, one below
# rad: the fingers close on to 0.2, which leaves either of them 7 mm beside the boards.
_OPENING = 0.20 + CLOSING_ON
_FORCE = 80.0  # N; on boards of 44 mm gripper_teleop presses with some 90 N at most
_PIECES = 10  # of the arc
_AXLE = 0.11  # m


class PalletSide(OperatorTask):
    """Pallet of 25 kg, gripped by the boards of its end and lifted there by 15 cm."""

    measure = "lifted and held (m)"
    subject = "pallet"
    view = ("follow", -0.8, 0.25, 3.0, (0.7, 0.0, 0.15))

    def __init__(self) -> None:
        self._lowest = 0.0

    def lay_out(self, rng: np.random.Generator) -> Dict[str, Dict[str, Any]]:
        """Put the pallet before the robot; see `OperatorTask.lay_out`."""
        return {"pallet": {"type": "pallet", **placed(rng, _AHEAD, _SCATTER)}}

    def begin(self, station: Station) -> None:
        """See `OperatorTask.begin`."""
        self._lowest = 0.0

    def act(self, hand: Hand) -> None:
        """Lift it; see `OperatorTask.act`."""
        station = hand.station
        pallet = station.object_pose("pallet")
        end = (pallet @ (_SIDE, _ACROSS, 0.0, 1.0))[:3]
        heading = heading_of(pallet)

        def before(distance: float) -> driving.Point:
            return (end[0] - distance * math.cos(heading), end[1] - distance * math.sin(heading))

        driving.drive_to(station, before(_APPROACH))
        driving.turn_to(station, heading)
        # Out of the way of a hand that reaches down before them.
        station.hold_preset("approach")
        hand.to_named_pose("ready")
        hand.open(_OPENING)
        low = _BOARDS - _AXLE
        hand.to(aimed(_REACH, 0.0, low + 0.19, 0.0, 0.2, _ON_EDGE), tolerance=0.03)
        hand.to(aimed(_REACH, 0.0, low, 0.0, 0.0, _ON_EDGE))
        station.hold_preset("")
        driving.run_to(station, before(_NEAR), 0.3, heading=heading)
        station.stop()
        station.wait(0.4)

        here = inverse(station.base()) @ station.object_pose("pallet")
        yaw = heading_of(here)
        here = here @ (_SIDE, _ACROSS, 0.0, 1.0)
        hand.to(aimed(here[0] + _BITE, here[1], low, yaw, 0.0, _ON_EDGE))
        hand.grip(_FORCE)
        self._raise(hand, here, yaw)
        self._lowest = math.inf
        until = station.time + HOLD
        station.until(
            lambda: station.time >= until, 2.0 * HOLD, "the time", lambda: self._look(station)
        )

    def _raise(self, hand: Hand, end: np.ndarray, yaw: float) -> None:
        """Lead the tool about the pallet's far edge, piece by piece, and turn it along."""
        far = end[:3] + _LENGTH * np.array([math.cos(yaw), math.sin(yaw), 0.0])
        tool = hand.tool()[:3, 3] - far
        ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        along, up = float(tool @ ahead), float(tool[2])
        for piece in range(1, _PIECES + 1):
            angle = math.asin(HEIGHT / _LENGTH) * piece / _PIECES
            x = along * math.cos(angle) + up * math.sin(angle)
            z = up * math.cos(angle) - along * math.sin(angle)
            place = far + x * ahead + (0.0, 0.0, z)
            aside = tool - along * ahead - np.array([0.0, 0.0, up])
            at = place + aside
            hand.to(aimed(at[0], at[1], at[2], yaw, angle, _ON_EDGE), tolerance=0.008)

    def _look(self, station: Station) -> None:
        self._lowest = min(self._lowest, _lifted(station))

    def judge(self, station: Station) -> Verdict:
        """See `OperatorTask.judge`: the end was held up all the time that the operator meant to."""
        height = 0.0 if math.isinf(self._lowest) else min(self._lowest, _lifted(station))
        far = (station.object_pose("pallet") @ (-_SIDE, 0.0, 0.0, 1.0))[2]
        done = height >= REQUIRED and abs(far) < 0.02
        return Verdict(done, height, f"one end {100.0 * height:.1f} cm up, the other on the floor")


def _lifted(station: Station) -> float:
    """Height of the middle of the end over the floor (m)."""
    return float((station.object_pose("pallet") @ (_SIDE, 0.0, 0.0, 1.0))[2])
