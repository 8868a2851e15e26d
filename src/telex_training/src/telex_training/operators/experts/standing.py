"""Standing square before what is mounted and looks towards the robot."""

from __future__ import annotations

import math
from typing import Any, Mapping

import numpy as np

from telex_control.common.geometry.matrices import homogeneous, inverse, rotation_from_rpy

from .. import driving
from ..handling import Hand

_RUN_UP = 0.4
"""How far the robot drives up to its place in a straight line (m)."""


def stand_before(hand: Hand, entry: Mapping[str, Any], distance: float, opening: float) -> None:
    """Drive so far before what is mounted (m), square to it, with the arm ready."""
    station = hand.station
    place, yaw = entry["position"], float(entry.get("yaw", 0.0))

    def before(way: float) -> driving.Point:
        return (place[0] - way * math.cos(yaw), place[1] - way * math.sin(yaw))

    driving.drive_to(station, before(distance + _RUN_UP))
    driving.turn_to(station, yaw)
    station.hold_preset("approach")
    hand.to_named_pose("ready")
    hand.open(opening)
    driving.run_to(station, before(distance), 0.3, heading=yaw)
    station.stop()
    station.wait(0.4)
    station.hold_preset("")


def seen_from_base(hand: Hand, entry: Mapping[str, Any]) -> np.ndarray:
    """Pose of a thing of the scene's file in base_link, 4x4."""
    turn = rotation_from_rpy((0.0, 0.0, float(entry.get("yaw", 0.0))))
    return inverse(hand.station.base()) @ homogeneous(turn, entry["position"])
