"""The grasp suite: things are picked from a post, from several sides, and lifted."""

from __future__ import annotations

from typing import NamedTuple

from .holding import LOST
from .rig import FRONT, OBLIQUE, TOP, Rig
from .things import PAD_FRICTION, Thing, post

APPROACHES = {"front": FRONT, "oblique": OBLIQUE, "top": TOP}
FRICTIONS = (0.4, 0.8)
SHARE = 0.7
"""Of what the shipped pads' friction carries under the force that the suite grips with."""
LEAST_FORCE = 10.0  # N
BACK = 0.16
"""Way along which the hand approaches (m)."""
LIFT = 0.12  # m
HOLDING = 1.0  # s


class Grasp(NamedTuple):
    """What came of a grasp.

    Attributes
    ----------
    force : float
        Of the pads (N).
    load : float
        The weight, as a share of what friction can carry by Coulomb's law.
    lifted : bool
        Whether the thing went up with the hand.
    slip : float
        In the hand, from the grip to the end (m).
    """

    force: float
    load: float
    lifted: bool
    slip: float

    @property
    def predicted(self) -> bool:
        """Whether it is lifted by Coulomb's law."""
        return self.load < 1.0

    @property
    def agrees(self) -> bool:
        """Whether it went as Coulomb's law says."""
        return self.predicted == self.lifted


def grasp(thing: Thing, pitch: float, friction: float) -> Grasp:
    """Pick a thing from a post, lift and hold it.

    Parameters
    ----------
    thing : Thing
    pitch : float
        How far down the hand points (rad).
    friction : float
        Of the pads, on a surface of friction 1.
    """
    force = max(LEAST_FORCE, thing.force(SHARE, PAD_FRICTION))
    with Rig(pitch=pitch, opening=thing.opening, friction=friction) as rig:
        x, y, z = rig.by_tool((-thing.aside, 0.0, -thing.grip))
        rig.advance_hand(-BACK)
        rig.spawn({**post(z, thing.width), "position": [x + thing.aside, y, 0.0]})
        name = rig.spawn({**thing.entry(), "position": [x, y, z]})
        height = rig.pose(name)[0][2]
        rig.advance_hand(BACK)
        rig.grip(force)
        before = rig.held_at(name)
        rig.line((0.0, 0.0, LIFT))
        rig.wait(HOLDING)
        slip = rig.slip(name, before).distance
        lifted = slip < LOST and rig.pose(name)[0][2] - height > LIFT - LOST
        return Grasp(force, thing.force(1.0, friction) / force, lifted, slip)
