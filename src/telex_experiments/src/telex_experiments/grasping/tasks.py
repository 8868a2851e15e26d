"""Grasping tasks: those of the paper (a briefcase, a pallet), a valve, stairs."""

from __future__ import annotations

import math
from typing import NamedTuple, Tuple

import pybullet

from telex_training.operators.robot_size import AXLE_HEIGHT
from telex_training.operators.terrain.stairs import Stairs, climb

from .holding import Sway, rig_for, sway
from .rig import FRONT, GraspRig
from .things import THINGS, Thing

CARRY_FORCE = 150.0
"""Of the pads, for what is heavy (N)."""
STAIRS = Stairs(0.15, 0.30, steps=4)
_ON_STAIRS = (0.62, 0.0, 0.62)
"""Where a load is held on stairs, in base_link (m)."""


class CarriedLoad(NamedTuple):
    """How something was carried.

    Attributes
    ----------
    way : float
        That the object was moved by, along the floor (m).
    slip : float
        At most, in the hand (m).
    """

    way: float
    slip: float
    held: bool


def briefcase() -> CarriedLoad:
    """Take a briefcase from the floor by its handle, lift it, and carry it 3 m."""
    case = THINGS["briefcase"]
    handle = case.grip
    with GraspRig(place=(0.85, 0.0, handle - AXLE_HEIGHT), opening=case.opening) as rig:
        x, y, _ = rig.tool()[0]
        rig.advance_hand(-0.2)
        name = rig.spawn({**case.entry(), "position": [x, y, 0.0]})
        rig.advance_hand(0.2)
        rig.grip(CARRY_FORCE)
        start = rig.pose(name)[0]

        def carry() -> None:
            rig.line((0.0, 0.0, 0.15))
            rig.drive(-0.3, 0.0, 6.0)
            rig.drive(0.0, 0.5, 2.0)
            rig.drive(-0.3, 0.0, 6.0)

        found = sway(rig, name, carry, rest=1.0)
        end = rig.pose(name)[0]
        return CarriedLoad(math.dist(start[:2], end[:2]), found.most, rig.contact().object == name)


def pallet() -> Tuple[CarriedLoad, float]:
    """Take a pallet at a side, drag it back, and lift that side.

    Returns
    -------
    CarriedLoad
    float
        By how much the side came up (m).
    """
    # The pads lie level, one under the boards, one over them.
    length, deck = 1.2, 0.5 * (0.144 + 0.100)
    with GraspRig(place=(1.0, 0.0, deck - AXLE_HEIGHT), opening=0.09, roll=0.5 * math.pi) as rig:
        x, y, _ = rig.tool()[0]
        rig.advance_hand(-0.12)
        entry = {
            "type": "pallet",
            "name": "pallet",
            "position": [x - 0.02 + 0.5 * length, y + 0.2, 0.0],
        }
        name = rig.spawn(entry)
        rig.advance_hand(0.12)
        rig.grip(200.0)
        start, held = rig.pose(name)[0], rig.held_at(name)
        rig.line((0.0, 0.0, 0.05), 0.05)
        rig.drive(-0.2, 0.0, 2.5)
        rig.wait(0.5)
        dragged = rig.pose(name)[0]
        rig.line((0.0, 0.0, 0.20), 0.05)
        rig.wait(1.0)
        _, orientation = rig.pose(name)
        axis = pybullet.getMatrixFromQuaternion(orientation)[6]
        carried = CarriedLoad(
            math.dist(start[:2], dragged[:2]),
            rig.slip(name, held).distance,
            rig.contact().object == name,
        )
        return carried, length * abs(axis)


class Turned(NamedTuple):
    """How far a valve was turned (rad), and how far its lever should have been."""

    angle: float
    wanted: float


def valve(friction: float, force: float = CARRY_FORCE) -> Turned:
    """Take a valve's lever between the pads, and lead its end up.

    Parameters
    ----------
    friction : float
        Of the valve (N m).
    force : float
        Of the pads (N).
    """
    radius, hold_at, angle = 0.24, 0.20, 0.6
    with GraspRig(opening=0.06) as rig:
        x, y, z = rig.tool()[0]
        rig.advance_hand(-0.2)
        entry = {
            "type": "valve",
            "handle": "lever",
            "radius": radius,
            "height": z,
            "friction": friction,
            # It faces aside, its lever towards the hand.
            "yaw": -0.5 * math.pi,
            "start": -0.5 * math.pi,
            "position": [x + hold_at, y - 0.16, 0.0],
        }
        name = rig.spawn(entry)
        rig.advance_hand(0.2)
        rig.grip(force)
        began = rig.simulation.objects.joint_position(name, "wheel_hinge")
        rig.swing_up(hold_at, angle)
        rig.wait(1.0)
        turned = abs(rig.simulation.objects.joint_position(name, "wheel_hinge") - began)
        return Turned(turned, angle)


def stairs(thing: Thing, force: float) -> Sway:
    """Carry a thing up a flight of stairs, and stand on the landing."""
    start = {"x": STAIRS.foot - 1.5}
    with rig_for(thing, FRONT, objects=STAIRS.objects(), start=start, place=_ON_STAIRS) as rig:
        name = rig.present(thing.entry(), force)
        rig.wait(1.0)
        found = sway(rig, name, lambda: climb(rig.operator, STAIRS))
        assert rig.contact().object == name
        return found
