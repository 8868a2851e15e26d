"""A barrier across the way: up, over, and down behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List

from ..robot_size import BELLY, DROOP, FLIPPER_LENGTH, PIVOT, TIP_RADIUS
from ..scripted_operator import FlipperAngles, Operator
from . import step as stepping

SLOW, SPEED = 0.15, 0.30  # m/s

# For a hurdle of stepping.TALL; for lower ones in proportion.
REACH_DOWN = ((-1.10, 0.0), (-1.30, -0.20))
LOWER = ((-0.50, -0.20), (-0.80, 0.10), (-0.30, -0.60))
AWAY = (0.40, 0.40)

_SHORT = 2.0 * PIVOT
"""Length (m) up to which the front leaves a hurdle before its rear is up, and pulls no more."""
_CLEARANCE = 0.04  # m, under the belly


@dataclass(frozen=True)
class Hurdle:
    """A block across x, with square edges.

    Attributes
    ----------
    height, length : float
        m.
    friction : float
        Of it and of the floor.
    edge : float
        Where it rises (m).
    """

    height: float
    length: float = 0.6
    friction: float = 1.0
    edge: float = 0.0

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "hurdle",
                "name": "hurdle",
                "position": [self.edge + 0.5 * self.length, 0.0, 0.0],
                "height": self.height,
                "length": self.length,
                "width": 2.4,
                "friction": self.friction,
            }
        ]


def _astride(height: float) -> FlipperAngles:
    """Angles at which all tips stand on the floor, and the belly is clear of a hurdle."""
    axles = height + BELLY + _CLEARANCE
    angle = DROOP - math.asin(min(1.0, (axles - TIP_RADIUS) / FLIPPER_LENGTH))
    return (angle, angle)


def cross(operator: Operator, hurdle: Hurdle) -> None:
    """Climb it, and come down behind it.

    Raises
    ------
    NotManagedError
    """
    tall = hurdle.height / stepping.TALL
    step = stepping.Step(hurdle.height, hurdle.friction, edge=hurdle.edge)
    stepping.mount(operator, step, () if hurdle.length > _SHORT else (_astride(hurdle.height),))
    far = hurdle.edge + hurdle.length
    operator.keep_lane(SLOW)
    operator.work_on(
        lambda: operator.pose.x > far + 0.05 or operator.pose.rise < -0.25 * tall,
        [(tall * front, tall * rear) for front, rear in REACH_DOWN],
        12.0,
        "the front down behind the hurdle",
    )
    operator.keep_lane(SPEED)
    operator.work_on(
        lambda: operator.pose.x > far + 0.45,
        [(tall * front, tall * rear) for front, rear in LOWER],
        20.0,
        "the rear off the hurdle",
    )
    operator.flippers(*AWAY)
    operator.until(
        lambda: operator.pose.x > far + 0.9 and abs(operator.pose.rise) < 0.1,
        8.0,
        "level behind the hurdle",
    )
    operator.stop()
    operator.wait(0.4)
