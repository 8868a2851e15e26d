"""Exercises of the arm at task panels: dots to touch, a plug to pull out."""

from __future__ import annotations

import math

import numpy as np

from telex_control.common.geometry.matrices import (
    homogeneous,
    inverse,
    rotation_from_rpy,
)
from telex_sim.scene.library.tasks.panels import columns

from ..handling import Hand
from .brief import Brief
from .standing import seen_from_base, stand_before

_REACH = 0.90  # m, from base_link to the panel's middle
_BEFORE = 0.08  # m, of the tool before what it is about to touch
_CLOSED = 0.007  # rad

_FACE = 0.12  # m, of the blocks before the panel's origin
_TURNED, _NOSE_DOWN = 0.25 * math.pi, 0.35
"""Rolled by an eighth with the nose a little down (rad), one corner of the fingertips is foremost,
and the gripper's camera sees it."""
_CORNER = (0.040, 0.0, 0.022)  # m, in the frame of a tool that is not rolled
_PRESS = 0.006
"""How far a block is pushed in (m)."""

_SOCKET = 0.065  # m, from the connector's origin to its socket's rim
_PLUG_HOLD = 0.075  # m, of the tool before the rim
_PLUG_OPENING = 0.20  # rad
_PLUG_FORCE = 60.0  # N
_AWAY = 0.16
"""How far the plug is taken from its socket (m)."""
_LINED_UP = 0.055
"""Before its place (m), the plug is still wholly out of the socket."""


def touch(hand: Hand, brief: Brief) -> None:
    """Touch one dot after the other with the foremost corner of the closed fingers."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["panel"]
    stand_before(hand, entry, _FACE + _REACH, _CLOSED)
    here = seen_from_base(hand, entry)
    pitched = rotation_from_rpy((0.0, _NOSE_DOWN, 0.0))
    rolled = pitched @ rotation_from_rpy((_TURNED, 0.0, 0.0))

    def at(dot: float, before: float) -> np.ndarray:
        """Tool with its corner so far (m) before a dot."""
        corner = np.array([-_FACE - before, dot, float(entry["height"])])
        return here @ homogeneous(rolled, corner - pitched @ _CORNER)

    for dot in columns(int(entry.get("count", 5))):
        hand.to(at(dot, _BEFORE), tolerance=0.005)
        hand.to(at(dot, -_PRESS), tolerance=0.003)
        hand.to(at(dot, _BEFORE), tolerance=0.02)


def connector(hand: Hand, brief: Brief) -> None:
    """Pull the plug out of its socket, and put it in again as it is seen in the hand."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["connector"]
    stand_before(hand, entry, _SOCKET + _PLUG_HOLD + _REACH, _PLUG_OPENING)
    here = seen_from_base(hand, entry)

    place = inverse(station.base()) @ station.object_pose("connector")
    grasp = here @ homogeneous(np.eye(3), (-_SOCKET - _PLUG_HOLD, 0.0, float(entry["height"])))
    hand.to(_shifted(grasp, -_BEFORE), tolerance=0.01)
    hand.to(grasp, tolerance=0.0015)
    hand.grip(_PLUG_FORCE)
    hand.to(_shifted(hand.tool(), -_AWAY), tolerance=0.01)
    station.wait(0.5)
    home = place @ inverse(_in_hand(hand, "connector"))
    hand.to(_shifted(home, -_LINED_UP), tolerance=0.0015)
    hand.to(home, tolerance=0.002)
    station.wait(1.2)
    hand.open(_PLUG_OPENING)


def _in_hand(hand: Hand, name: str) -> np.ndarray:
    """Pose of something (see `Station.object_pose`) in the tool's frame."""
    return inverse(hand.tool_in_world()) @ hand.station.object_pose(name)


def _shifted(tool: np.ndarray, ahead: float) -> np.ndarray:
    """Pose of a tool that is so much (m) further ahead, along its own axis."""
    return tool @ homogeneous(np.eye(3), (ahead, 0.0, 0.0))
