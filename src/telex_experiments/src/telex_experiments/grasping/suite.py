"""The grasp suite: things are picked from a post, from several sides, and lifted."""

from __future__ import annotations

from typing import NamedTuple

from . import statics
from .holding import LOST
from .rig import FRONT, OBLIQUE, TOP, GraspRig
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
_LIFTING = 0.02
"""What the hand's acceleration adds to the weight."""


class Grasp(NamedTuple):
    """What came of a grasp.

    Attributes
    ----------
    force : float
        Of the pads (N).
    load : float
        The weight, as a share of what friction can carry by Coulomb's law, see `statics.load`.
    least, most : float
        The same with what the friction of the fingers' joints adds to the force, or takes from it;
        the second while the hand starts, too.
    lifted : bool
        Whether the thing went up with the hand.
    slip : float
        In the hand, from the grip to the end (m).
    """

    force: float
    load: float
    least: float
    most: float
    lifted: bool
    slip: float

    @property
    def predicted(self) -> bool:
        """Whether it is lifted by Coulomb's law."""
        return self.load < 1.0

    @property
    def agrees(self) -> bool:
        """Whether it went as Coulomb's law says; between `least` and `most` either may be."""
        return self.lifted if self.most < 1.0 else not self.lifted if self.least > 1.0 else True


def grasp(
    thing: Thing, pitch: float, friction: float, share: float = SHARE, least: float = LEAST_FORCE
) -> Grasp:
    """Pick a thing from a post, lift and hold it.

    Parameters
    ----------
    pitch : float
        How far down the hand points (rad).
    friction : float
        Of the pads, on a surface of friction 1.
    share : float
        Of what the shipped pads' friction carries that the weight is, in a level hand.
    least : float
        Force that the pads are given in any case (N).
    """
    force = max(least, thing.force(share, PAD_FRICTION))
    band = statics.friction_band(thing.width)
    with GraspRig(pitch=pitch, opening=thing.opening, friction=friction) as rig:
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
        loads = [
            factor * statics.load(thing, force + off, pitch, friction)
            for off, factor in ((0.0, 1.0), (band, 1.0), (-band, 1.0 + _LIFTING))
        ]
        return Grasp(force, *loads, lifted, slip)
