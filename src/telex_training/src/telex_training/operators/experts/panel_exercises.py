"""Exercises of the arm at panels: dots to touch, points to wipe, caps to turn, plugs to pull."""

from __future__ import annotations

import math

import numpy as np

from telex_control.common.geometry.matrices import (
    homogeneous,
    inverse,
    rotation_from_rpy,
    rotation_matrix,
)
from telex_sim.scene.library.shapes import TOWARDS_US
from telex_sim.scene.library.tasks.panels import columns

from .. import driving
from ..handling import Hand, aimed
from ..tasks.task import heading_of
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

_BAR = 0.155
"""Of the tool before the panel's origin (m): the fingertips reach over the bar of a cap, and stay
off its disc."""
_BAR_FORCE = 30.0  # N
_BAR_OPENING = 0.12  # rad
_PART, _PARTS = 0.33 * math.pi, 3
"""A cap's half turn, short of its stop, is made in parts (rad), and the bar gripped anew for each:
contacts that last keep the direction of their forces, so that a hand which turns far with what it
holds presses on it from aside."""

_RIM = 0.06  # m, of the caps' holes before the panel's origin
_HOLD = 0.078
"""Where a cap is held, from its rim (m): so far out that the fingertips stay over the tray."""
_CAP_OPENING = 0.24  # rad
_CAP_FORCE = 40.0  # N
_PULLED, _OVER = 0.10, 0.14  # m, that a cap is taken out of its hole, and carried over the tray
_IN_TRAY = 0.043
"""Height of a cap's rim over the bottom of its hole in the tray, as it is let go (m)."""
_TRAY_DEPTH = 0.06  # m, of its holes
_DOWN = 0.5 * math.pi

_SOCKET = 0.065  # m, from the connector's origin to its socket's rim
_PLUG_HOLD = 0.075  # m, of the tool before the rim
_PLUG_OPENING = 0.20  # rad
_PLUG_FORCE = 60.0  # N
_AWAY = 0.16
"""How far the plug is taken from its socket (m)."""
_LINED_UP = 0.055
"""Before its place (m), the plug is still wholly out of the socket."""

_SHEET_REACH = 0.85  # m, from base_link to the sheet
_SWAB_GRIP, _SWAB_OVER = 0.18, 0.20  # m, of the tool over the swab's foot, and over that
_SWAB_OPENING = 0.24  # rad
_SWAB_FORCE = 40.0  # N
_WIPE, _WIPING = 0.012, 1.3
"""How far the stick is pressed in (m), and for how long (s)."""
_ABOVE_SHEET, _SHEET = 0.03, 0.01
"""Of the foot on its way to the next point, and thickness of the sheet (m)."""
_ABOVE_RACK, _IN_TUBE = 0.16, 0.02
"""Of the foot over the bottom of its hole, on the way there and as it is let go (m)."""


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


def rotate(hand: Hand, brief: Brief) -> None:
    """Take one cap after the other across its bar, and turn it by rolling the hand."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["panel"]
    stand_before(hand, entry, _BAR + _REACH, _CAP_OPENING)
    for cap in columns(int(entry.get("count", 5))):
        # What turns against friction pushes the robot a little, and the arm is stiff.
        here = seen_from_base(hand, entry) @ homogeneous(np.eye(3), (0.0, cap, entry["height"]))

        def at(before: float, turned: float, here: np.ndarray = here) -> np.ndarray:
            """Tool so far (m) before its grip at the cap, rolled as it has turned (rad)."""
            roll = rotation_from_rpy((-turned, 0.0, 0.0))
            return here @ homogeneous(roll, (-_BAR - before, 0.0, 0.0))

        hand.to(at(_BEFORE, 0.0), tolerance=0.01)
        hand.to(at(0.0, 0.0), tolerance=0.002)
        for part in range(1, _PARTS + 1):
            hand.grip(_BAR_FORCE)
            hand.to(at(0.0, part * _PART), tolerance=0.008)
            hand.open(_BAR_OPENING)
        hand.to(at(_BEFORE, _PARTS * _PART), tolerance=0.02)
        # Back as it came: from half a turn, the shortest way may be the other one.
        hand.to(at(_BEFORE, 0.5 * _PARTS * _PART), tolerance=0.02)


def extract_place(hand: Hand, brief: Brief) -> None:
    """Pull one cap after the other out of the panel, and stand it in the tray's next hole."""
    station = hand.station
    station.mode("CARTESIAN")
    panel, tray = brief.entries["panel"], brief.entries["tray"]
    stand_before(hand, panel, _RIM + _HOLD + _REACH, _CAP_OPENING)
    here, there = seen_from_base(hand, panel), seen_from_base(hand, tray)
    bottom = float(tray["height"]) - _TRAY_DEPTH

    def before(cap: float, out: float) -> np.ndarray:
        """Tool at a cap that is so far out of its hole (m)."""
        place = (-_RIM - _HOLD - out, cap, float(panel["height"]))
        return here @ homogeneous(np.eye(3), place)

    # The hand points down, and its fingers open across the row of holes: neighbours stand along it.
    down = aimed(0.0, 0.0, 0.0, heading_of(there) - _DOWN, _DOWN)[:3, :3]
    upright = down @ rotation_matrix(TOWARDS_US)

    def over(hole: float, height: float, in_hand: np.ndarray) -> np.ndarray:
        """Tool that holds a cap upright, its rim so high over the bottom of a hole (m)."""
        place = (there @ (0.0, hole, bottom + height, 1.0))[:3]
        return homogeneous(upright, place) @ inverse(in_hand)

    for number, cap in enumerate(columns(int(panel.get("count", 5)))):
        hole = columns(5)[number]
        if number:
            # Else the forearm, led to and fro in straight lines, winds up to its limit.
            hand.to_named_pose("ready")
        hand.to(before(cap, _PULLED), tolerance=0.01)
        hand.to(before(cap, 0.0))
        hand.grip(_CAP_FORCE)
        hand.to(before(cap, _PULLED), tolerance=0.02)
        name = f"panel/cap_{number + 1}"
        hand.to(over(hole, _OVER, _in_hand(hand, name)), tolerance=0.02)
        # On the way it swings between the pads.
        station.wait(0.3)
        in_hand = _in_hand(hand, name)
        hand.to(over(hole, _OVER, in_hand), tolerance=0.003)
        hand.to(over(hole, _IN_TRAY, in_hand))
        hand.open(_CAP_OPENING)
        hand.to(over(hole, _OVER, in_hand), tolerance=0.02)


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


def swab(hand: Hand, brief: Brief) -> None:
    """Press the swab on one point after the other, then put it into its tube."""
    station = hand.station
    station.mode("CARTESIAN")
    station.hold_preset("flat")
    hand.to(aimed(_SHEET_REACH - 0.15, 0.0, 0.62, 0.0, 1.3), tolerance=0.03)
    hand.open(_SWAB_OPENING)
    driving.run_to(station, (brief.entries["sheet"]["position"][0] - _SHEET_REACH, 0.0), 0.4)
    station.stop()
    station.wait(0.4)
    station.hold_preset("")
    base = inverse(station.base())
    x, y, z = (base @ station.object_pose("swab"))[:3, 3]
    hand.to(aimed(x, y, z + _SWAB_GRIP + _SWAB_OVER, 0.0, _DOWN), tolerance=0.01)
    hand.to(aimed(x, y, z + _SWAB_GRIP, 0.0, _DOWN))
    hand.grip(_SWAB_FORCE)
    hand.to(aimed(x, y, z + _SWAB_GRIP + _SWAB_OVER, 0.0, _DOWN), tolerance=0.01)
    down = aimed(0.0, 0.0, 0.0, 0.0, _DOWN)[:3, :3]

    def over(place: np.ndarray, height: float) -> np.ndarray:
        """Tool with the swab's foot, as it lies in the hand now, so high (m) over a place."""
        foot = down @ _in_hand(hand, "swab")[:3, 3]
        return homogeneous(down, place - foot + np.array((0.0, 0.0, height)))

    sheet = seen_from_base(hand, brief.entries["sheet"])
    marks = [part["position"] for part in brief.entries["sheet"]["links"][0]["parts"][1:]]
    for across, along, _ in marks:
        place = (sheet @ (across, along, _SHEET, 1.0))[:3]
        hand.to(over(place, _ABOVE_SHEET), tolerance=0.006)
        hand.to(over(place, -_WIPE), tolerance=0.003)
        station.wait(_WIPING)
        hand.to(over(place, _ABOVE_SHEET), tolerance=0.01)
    entry = brief.entries["rack"]
    bottom = float(entry["height"]) - float(entry["depth"])
    tube = (seen_from_base(hand, entry) @ (0.0, columns(2)[1], bottom, 1.0))[:3]
    hand.to(over(tube, _ABOVE_RACK), tolerance=0.01)
    station.wait(0.3)
    hand.to(over(tube, _ABOVE_RACK), tolerance=0.0015)
    hand.to(over(tube, _IN_TUBE), tolerance=0.003)
    hand.open(_SWAB_OPENING)
    hand.to(over(tube, _ABOVE_RACK), tolerance=0.03)


def _in_hand(hand: Hand, name: str) -> np.ndarray:
    """Pose of something (see `Station.object_pose`) in the tool's frame."""
    return inverse(hand.tool_in_world()) @ hand.station.object_pose(name)


def _shifted(tool: np.ndarray, ahead: float) -> np.ndarray:
    """Pose of a tool that is so much (m) further ahead, along its own axis."""
    return tool @ homogeneous(np.eye(3), (ahead, 0.0, 0.0))
