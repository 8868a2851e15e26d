"""Stairs: up, whole onto the landing, and down again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional

from ..port import NotManagedError
from ..robot_size import AXLE_HEIGHT, HALF_LENGTH
from ..scripted_operator import Operator

SPEED, SLOW = 0.35, 0.20  # m/s

APPROACH = (0.80, 0.10)
ON_STEPS = (0.02, -0.03)
CREST = ((-0.30, -1.00), (-0.40, -0.25))
STANDING = (0.90, 0.90)
OVER_EDGE = ((-0.70, 0.0), (-0.85, 0.10))
TIPPING = (-0.10, -0.30)
DOWN = (0.05, 0.0)
FOOT = (0.05, 0.35)
"""The rear comes down on its raised flippers; without the front ones the nose would drop."""

_CREST_AHEAD = 0.32  # m, before the landing's edge, where the flippers reach for it


@dataclass(frozen=True)
class Stairs:
    """Stairs along x, up and down over a landing.

    Attributes
    ----------
    rise, run : float
        Of a step (m).
    landing : float
        Its length (m).
    friction : float
        Of treads and floor.
    foot : float
        Where they begin (m).
    """

    rise: float
    run: float
    steps: int = 8
    landing: float = 2.0
    friction: float = 1.0
    foot: float = 0.6

    @property
    def slope(self) -> float:
        """Of the line over the edges (rad)."""
        return math.atan2(self.rise, self.run)

    @property
    def height(self) -> float:
        """Of the landing (m)."""
        return self.rise * self.steps

    @property
    def crest(self) -> float:
        """Where the landing begins (m)."""
        return self.foot + self.run * (self.steps - 1)

    @property
    def edge(self) -> float:
        """Where the landing ends (m)."""
        return self.crest + self.landing

    @property
    def end(self) -> float:
        """Where the last step down ends (m)."""
        return self.edge + self.run * (self.steps - 1)

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        middle = 0.5 * (self.foot + self.end)
        return [
            {
                "type": "stairs",
                "name": "stairs",
                "position": [middle, 0.0, 0.0],
                "rise": self.rise,
                "run": self.run,
                "steps": self.steps,
                "landing": self.landing,
                "form": "up_and_down",
                "railings": "none",
                "friction": self.friction,
            }
        ]


def climb(operator: Operator, stairs: Stairs) -> None:
    """Climb from the floor onto the landing, and stand there.

    Raises
    ------
    NotManagedError
        The robot gets stuck, tips over, or does not stand whole on the landing.
    """
    start_climb(operator)
    operator.work_on(
        lambda: operator.pose.x > stairs.crest - _CREST_AHEAD,
        (ON_STEPS, (0.15, -0.15)),
        40.0,
        "the crest",
    )
    operator.work_on(
        lambda: operator.pose.x > stairs.crest + 0.3 and abs(operator.pose.rise) < 0.2,
        CREST,
        25.0,
        "over the crest",
    )
    operator.flippers(*STANDING)
    stand_on_landing(operator, stairs)


def start_climb(operator: Operator) -> None:
    """Drive to the first step and put the front onto it."""
    operator.flippers(*APPROACH)
    operator.keep_lane(SPEED)
    operator.until(lambda: operator.pose.rise > 0.25, 20.0, "the front on the first step")


def stand_on_landing(
    operator: Operator, stairs: Stairs, meanwhile: Optional[Callable[[], None]] = None
) -> None:
    """Stop on the landing, and make sure that all of the robot is there; see `Operator.until`."""
    operator.until(
        lambda: operator.pose.x > stairs.crest + HALF_LENGTH + 0.10,
        8.0,
        "whole on the landing",
        meanwhile,
    )
    operator.stop()
    operator.wait(2.0)
    pose = operator.pose
    height = pose.z - stairs.height - AXLE_HEIGHT
    if abs(height) > 0.02 or abs(pose.rise) > 0.05 or abs(pose.roll) > 0.05:
        raise NotManagedError(f"does not stand level on the landing; {operator.where()}")


def descend(operator: Operator, stairs: Stairs) -> None:
    """Go on from the landing down to the floor behind.

    Raises
    ------
    NotManagedError
    """
    start_descent(operator, stairs)
    operator.until(lambda: operator.pose.x > stairs.end, 25.0, "the last steps")
    operator.flippers(*FOOT)
    operator.until(
        lambda: operator.pose.x > stairs.end + 0.7 and abs(operator.pose.rise) < 0.05,
        12.0,
        "on the floor",
    )
    operator.stop()
    operator.wait(0.4)


def start_descent(operator: Operator, stairs: Stairs) -> None:
    """Go on from the landing over its edge, until all of the robot is on the steps."""
    operator.keep_lane(SPEED)
    operator.flippers(0.0, 0.0)
    operator.until(lambda: operator.pose.x > stairs.edge - 0.80, 15.0, "the edge")
    operator.keep_lane(SLOW)
    operator.work_on(
        lambda: operator.pose.x > stairs.edge + HALF_LENGTH, OVER_EDGE, 30.0, "over the edge"
    )
    operator.flippers(*TIPPING)
    operator.until(
        lambda: operator.pose.rise < -0.8 * stairs.slope or operator.pose.x > stairs.end,
        8.0,
        "down on the steps",
    )
    operator.flippers(*DOWN)
    operator.keep_lane(SPEED)
