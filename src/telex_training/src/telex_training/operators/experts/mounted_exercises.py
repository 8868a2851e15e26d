"""Exercises of the arm at what is mounted and looks at the robot: valve, pipes, door."""

from __future__ import annotations

import math
from typing import Any, Mapping, Tuple

import numpy as np

from telex_control.common.geometry.matrices import homogeneous, inverse
from telex_sim.scene.library.tasks.panels import InspectionPipes

from .. import driving
from ..handling import GRIPPER_CAMERA, TOOL, Hand, aimed
from ..tasks.task import heading_of
from .brief import Brief
from .standing import seen_from_base, stand_before

_VALVE_REACH = 0.85  # m, from base_link to the wheel's plane
_WHEEL_AHEAD = 0.16  # m, of the wheel before the valve's middle
_CRANK = 0.060  # m, from the axis, where the fingers push a spoke
_THROUGH, _BEFORE = -0.03, 0.14  # m, of the tool past the wheel's plane; and before it
_TURN, _PIECES = 2.0 * math.pi + 0.9, 28
"""How far the fingers go round (rad): a part of it until they meet a spoke."""

CLOSED = 0.02
"""Of a finger's base joint (rad): narrow enough to pass between two spokes."""

_PIPES_STAND = 0.85  # m, from base_link to where the camera is before the middle pipe
_LOOK_FROM = 0.28  # m, of the camera before a pipe's mouth
_LOOK = 0.6
"""At the bottom of each pipe (s)."""

_PUSHING = (0.85, -0.20, 0.65)
"""Of the closed fingers, ahead of base_link and towards the leaf's free edge (m)."""
_PUSH_SPEED = 0.25  # m/s
_BEHIND_DOOR = 2.0
"""How far behind the door no leaf touches the robot any more (m)."""


def valve(hand: Hand, brief: Brief) -> None:
    """Open the valve: lead the closed fingers round between two spokes."""
    entry = brief.entries["valve"]
    stand_at_wheel(hand, entry)
    turn_wheel(hand, entry)


def stand_at_wheel(hand: Hand, entry: Mapping[str, Any]) -> None:
    """Drive before a valve, with the arm ready and the fingers closed."""
    hand.station.mode("CARTESIAN")
    stand_before(hand, entry, _WHEEL_AHEAD + _VALVE_REACH, CLOSED)


def wheel_from_base(hand: Hand, entry: Mapping[str, Any]) -> Tuple[np.ndarray, float]:
    """Middle of a valve's wheel, and the heading of its axis away from the robot, in base_link."""
    here = seen_from_base(hand, entry)
    centre = (here @ (-_WHEEL_AHEAD, 0.0, float(entry["height"]), 1.0))[:3]
    return centre, heading_of(here)


def turn_wheel(hand: Hand, entry: Mapping[str, Any]) -> None:
    """Turn a valve's wheel once round, from before it, and withdraw."""
    centre, turn = wheel_from_base(hand, entry)

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


def inspect(hand: Hand, brief: Brief) -> None:
    """Look along the axis of each pipe in turn, and say what the brief says of it."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["pipes"]
    pipes = InspectionPipes(entry["layout"], float(entry["length"]), float(entry["height"]))
    mouths = pipes.mouths()
    (x, _, _), _ = mouths[0]
    stand_before(hand, entry, _LOOK_FROM - x + _PIPES_STAND, 0.02)
    here = seen_from_base(hand, entry)
    # The tool as the camera sees it.
    tool = inverse(station.place_of(GRIPPER_CAMERA)) @ station.place_of(TOOL)
    for number, (mouth, towards) in enumerate(mouths, 1):
        axis = here[:3, :3] @ towards
        eye = (here @ (*mouth, 1.0))[:3] + _LOOK_FROM * axis
        hand.to(_looking(eye, -axis) @ tool, tolerance=0.01)
        station.wait(_LOOK)
        station.port.answer(f"pipe_{number}", brief.answers[f"pipe_{number}"])


def _looking(eye: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Pose of a camera's optical frame at a place, upright, that looks along a direction."""
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return homogeneous(np.column_stack((right, np.cross(ahead, right), ahead)), eye)


def door(hand: Hand, brief: Brief) -> None:
    """Push the leaf open with the closed fingers, and drive on through, the arm before the leaf."""
    station = hand.station
    station.mode("CARTESIAN")
    entry = brief.entries["door"]
    hand.to_named_pose("ready")
    hand.open(0.02)
    hand.to(aimed(*_PUSHING), tolerance=0.02)
    x, y = entry["position"][:2]
    driving.run_to(station, (x + _BEHIND_DOOR, y), _PUSH_SPEED, heading=0.0)
    station.stop()
    station.wait(0.7)
