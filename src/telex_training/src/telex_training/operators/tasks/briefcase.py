"""Grasping a briefcase by its handle, and carrying it away."""

from __future__ import annotations

import math
from typing import Any, Dict

import numpy as np

from telex_control.common.geometry.matrices import inverse

from .. import driving
from ..handling import Hand, aimed
from ..station import Station
from .task import OperatorTask, Verdict, heading_of, placed

WAY = 3.0  # m, that it is carried
HANDLE = 0.3925  # m, middle of the bar above the floor

_AHEAD, _SCATTER = 2.3, (0.15, 0.30, 0.35)  # m, m, m, rad
_APPROACH, _REACH = 1.6, 0.90  # m, from base_link to the handle, before and at the grasp
_DOWN = 1.1  # rad, that the tool looks down
_OPENING = 0.40  # rad
_FORCE = 120.0  # N
_OVER, _LIFT = 0.10, 0.16  # m
_CLEAR = 0.05  # m, under the case, of one that is carried
_SPEED = 0.5  # m/s
_SPARE = 0.1  # m, driven beyond the way: the robot stops a little early


class Briefcase(OperatorTask):
    """Case of 5 kg, gripped by the bar of its handle from above and carried 3 m backwards."""

    measure = "carried (m)"
    subject = "briefcase"
    view = ("follow", -0.9, 0.25, 3.0, (0.5, 0.0, 0.2))

    def __init__(self) -> None:
        self._start = np.eye(4)

    def lay_out(self, rng: np.random.Generator) -> Dict[str, Dict[str, Any]]:
        """Put the case before the robot; see `OperatorTask.lay_out`."""
        return {"briefcase": {"type": "briefcase", **placed(rng, _AHEAD, _SCATTER)}}

    def begin(self, station: Station) -> None:
        """See `OperatorTask.begin`."""
        self._start = station.object_pose("briefcase")

    def act(self, hand: Hand) -> None:
        """Carry it; see `OperatorTask.act`."""
        take(hand)
        station = hand.station
        base, way = station.pose, WAY + _SPARE
        away = (base.x - way * math.cos(base.yaw), base.y - way * math.sin(base.yaw))
        driving.run_to(station, away, _SPEED, True)
        station.stop()
        station.wait(1.0)

    def judge(self, station: Station) -> Verdict:
        """See `OperatorTask.judge`: at least 3 m away, upright and off the floor."""
        pose = station.object_pose("briefcase")
        way = float(np.linalg.norm(pose[:2, 3] - self._start[:2, 3]))
        lift = float(pose[2, 3])
        done = way >= WAY and lift > _CLEAR and pose[2, 2] > 0.9
        return Verdict(done, way, f"{way:.2f} m away, {100.0 * lift:.0f} cm off the floor")


def take(hand: Hand) -> None:
    """Drive to the case, grip it by its handle, and lift it.

    Raises
    ------
    NotManagedError
    """
    station = hand.station
    case = station.object_pose("briefcase")
    heading = heading_of(case)
    # The handle is gripped across: from either end of the case, whichever is nearer.
    if abs(math.remainder(heading - station.pose.yaw, 2.0 * math.pi)) > 0.5 * math.pi:
        heading += math.pi

    def before(distance: float) -> driving.Point:
        return (
            case[0, 3] - distance * math.cos(heading),
            case[1, 3] - distance * math.sin(heading),
        )

    driving.drive_to(station, before(_APPROACH))
    driving.turn_to(station, heading)
    station.hold_preset("approach")
    hand.to_named_pose("ready")
    hand.open(_OPENING)
    station.hold_preset("")
    hand.to(aimed(_REACH, 0.0, HANDLE - 0.11 + 0.14, 0.0, _DOWN), tolerance=0.02)
    driving.run_to(station, before(_REACH), 0.3, heading=heading)
    station.stop()
    station.wait(0.4)

    case_here = inverse(station.base()) @ station.object_pose("briefcase")
    x, y, z = (case_here @ (0.0, 0.0, HANDLE, 1.0))[:3]
    # The bar points the same way after half a turn.
    yaw = math.remainder(heading_of(case_here), math.pi)
    hand.to(aimed(x, y, z + _OVER, yaw, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z, yaw, _DOWN))
    hand.grip(_FORCE)
    hand.to(aimed(x, y, z + _LIFT, yaw, _DOWN), tolerance=0.01)
