"""Statics of a grip, computed without the simulation."""

from __future__ import annotations

import math
from typing import Tuple

from .things import Thing

_BASE, _MIDDLE, _LEAN = 0.045, 0.075, math.radians(25.0)
"""Links of a finger (m), and how far they lean inwards with closed pads (rad)."""
_OPEN = 0.55
"""Angle of the open finger (rad)."""
JOINT_FRICTION = 0.03 * (1.0 + 1.0 + 2.0)
"""Of a finger's joints, by their way in closing (Nm)."""


def pull_share(opening: float) -> float:
    """What a pull along the fingers takes from a pad's force, by the pull.

    The pads swing on arcs: where they close by dy, they also move along the fingers by dx, so that
    a pull along the fingers does work on the drives' angle. Their effort does not know of it.
    """
    closing, along = _ways(opening)
    return along / closing


def pad_force(force: float, pull: float, opening: float) -> float:
    """Force of a pad (N) that is commanded a force, with a pull along its finger (N)."""
    return max(0.0, force - pull_share(opening) * pull)


def friction_band(opening: float) -> float:
    """How much the friction of a finger's joints may add to a pad's force, or take from it (N)."""
    return JOINT_FRICTION / _ways(opening)[0]


def load(thing: Thing, force: float, pitch: float, friction: float) -> float:
    """Weight of a thing as a share of what friction carries between pads of a commanded force.

    Parameters
    ----------
    force : float
        Commanded (N).
    pitch : float
        How far down the hand points (rad).
    friction : float
        Of the pads, on a surface of friction 1.
    """
    pull = 0.5 * thing.weight * math.sin(pitch)
    left = pad_force(force, pull, thing.width)
    return thing.force(1.0, friction) / left if left > 0.0 else math.inf


def _ways(opening: float) -> Tuple[float, float]:
    """How far a pad closes, and how far it goes along its finger, by the finger's angle (m)."""
    low, high = 0.0, _OPEN
    for _ in range(40):
        angle = 0.5 * (low + high)
        wide = _BASE * _lateral(angle) + _MIDDLE * _lateral(2.0 * angle)
        low, high = (angle, high) if 2.0 * wide < opening else (low, angle)
    closing = _BASE * math.cos(_LEAN - angle) + 2.0 * _MIDDLE * math.cos(_LEAN - 2.0 * angle)
    along = _BASE * math.sin(_LEAN - angle) + 2.0 * _MIDDLE * math.sin(_LEAN - 2.0 * angle)
    return closing, along


def _lateral(angle: float) -> float:
    return math.sin(_LEAN) - math.sin(_LEAN - angle)
