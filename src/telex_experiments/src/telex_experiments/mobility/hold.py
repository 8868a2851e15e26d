"""Standing on a slope, along and across, and on stairs."""

from __future__ import annotations

import math

import numpy as np

from telex_training.operators.port import NotManagedError
from telex_training.operators.terrain.slope import Slope
from telex_training.operators.terrain.stairs import Stairs, start_climb

from .offline import OfflineTrial

_PLACE = 3.0
"""Where on the slope (m)."""

_SLID = 0.02
"""Way in `_PROOF` (s) that tells sliding from settling (m)."""
_PROOF = 2.0

_FINEST = math.radians(0.25)


def drift(trial: OfflineTrial, seconds: float, settle: float = 2.0) -> float:
    """How far a robot moves that is told to stand still (m)."""
    operator = trial.operator
    operator.stop()
    operator.wait(settle)
    before = trial.position()
    operator.wait(seconds)
    return float(np.linalg.norm(trial.position() - before))


def on_slope(angle: float, heading: float, friction: float, seconds: float) -> float:
    """Drift (m) of a robot with its flippers flat, placed on a slope; see `Slope.pose`."""
    slope = Slope(angle, friction=friction)
    with OfflineTrial(slope.objects(), friction=friction, pose="look_front") as trial:
        trial.place(*slope.pose(_PLACE, heading))
        trial.operator.flippers(0.0, 0.0)
        return drift(trial, seconds)


def on_stairs(stairs: Stairs, seconds: float) -> float:
    """Drift (m) of a robot that has stopped half-way up the stairs."""
    with OfflineTrial(stairs.objects(), {"x": stairs.foot - 1.2}, stairs.friction) as trial:
        operator = trial.operator
        start_climb(operator)
        operator.flippers(0.02, -0.03)
        operator.until(
            lambda: operator.pose.x > 0.5 * (stairs.foot + stairs.crest), 20.0, "half-way"
        )
        if abs(operator.pose.rise - stairs.slope) > 0.15:
            raise NotManagedError(f"does not lie on the edges; {operator.where()}")
        return drift(trial, seconds)


def slip_angle(friction: float, heading: float, around: float) -> float:
    """Steepest slope (rad) on which the robot stands, to a quarter of a degree.

    Parameters
    ----------
    friction : float
        Of the slope.
    heading : float
        See `Slope.pose`.
    around : float
        Where it is looked for, 4 degrees to both sides (rad).
    """
    stands, slides = around - math.radians(4.0), around + math.radians(4.0)
    while slides - stands > 1.01 * _FINEST:
        angle = 0.5 * (stands + slides)
        if _slides(angle, heading, friction):
            slides = angle
        else:
            stands = angle
    return 0.5 * (stands + slides)


def _slides(angle: float, heading: float, friction: float) -> bool:
    try:
        return on_slope(angle, heading, friction, _PROOF) > _SLID
    except NotManagedError:
        return True
