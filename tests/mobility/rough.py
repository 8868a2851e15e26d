"""Rough ground: ramps that cross, and fields of posts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

from .robot import AXLE_HEIGHT
from .scripted_operator import NotManagedError, Operator

SPEED = 0.25  # m/s

START = 1.0
"""Where the ground gets rough (m)."""

ON_RAMPS = ((-0.25, -0.25), (0.10, 0.10), (-0.50, -0.50))
"""Flat flippers hang between two ridges, raised ones leave the belly on one."""
ON_POSTS = ((0.45, 0.0), (0.15, -0.45), (-0.70, -0.70), (0.50, -0.90), (-0.90, 0.30), (0.75, 0.20))
LEVEL = (0.35, 0.35)
TURNING = (1.00, 1.00)

CHANGING = ((0.35, 0.35), (-0.30, -0.30), (0.0, 0.0))

EARLY = 0.20
"""How far before the place where the columns are level it turns, for it slides down (m)."""


@dataclass(frozen=True)
class CrossingRamps:
    """Two columns of ramps of 15 degrees; where one rises, the other falls.

    By default as wide as the test method has them for a lane of 2.4 m.

    Attributes
    ----------
    rows : int
        Ramps in a column.
    length, width : float
        Of a ramp (m).
    friction : float
    """

    rows: int = 2
    length: float = 2.4
    width: float = 1.2
    friction: float = 1.0

    @property
    def end(self) -> float:
        """Where they end (m)."""
        return START + (self.rows + 1) * self.length

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "crossing_ramps",
                "name": "ramps",
                "position": [0.5 * (START + self.end), 0.0, 0.0],
                "rows": self.rows,
                "length": self.length,
                "width": self.width,
                "friction": self.friction,
            }
        ]

    def ridges(self) -> List[Tuple[float, float]]:
        """Where the ridges are, in their order along x: x and y of their middles (m)."""
        half = 0.5 * self.width
        return [
            (START + (row + 1) * self.length, -half if row % 2 == 0 else half)
            for row in range(self.rows)
        ]


@dataclass(frozen=True)
class Stepfield:
    """Posts of 0.1 to 0.4 m, see the type of this name.

    Attributes
    ----------
    pattern : str
    pallets, seed : int
    friction : float
    """

    pattern: str = "hill"
    pallets: int = 1
    seed: int = 5
    friction: float = 1.0

    @property
    def end(self) -> float:
        """Where it ends (m)."""
        return START + 1.2 * self.pallets

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "stepfield",
                "name": "posts",
                "position": [0.5 * (START + self.end), 0.0, 0.0],
                "pattern": self.pattern,
                "pallets": self.pallets,
                "seed": self.seed,
                "friction": self.friction,
            }
        ]


def cross_ramps(operator: Operator, ramps: CrossingRamps) -> None:
    """Drive over every ridge, from one column to the other behind each, where they are level.

    Raises
    ------
    NotManagedError
    """
    ridges = ramps.ridges()
    for (ridge, y), (_, beside) in zip(ridges, ridges[1:]):
        _along(operator, y, ridge + 0.5 * ramps.length - EARLY)
        _change_column(operator, y, beside)
    _along(operator, ridges[-1][1], ramps.end + 0.8)
    _arrive(operator)


def _change_column(operator: Operator, y: float, beside: float) -> None:
    """Turn across the ramps, drive over to the middle of the other column, and turn back."""
    side = math.copysign(1.0, beside - y)
    _turn(operator, side * 0.5 * math.pi)
    operator.keep_lane(SPEED, (operator.pose.x, y), side * 0.5 * math.pi)

    def left() -> float:
        return side * (beside - operator.pose.y)

    operator.work_on(lambda: left() < 0.05, CHANGING, 20.0, "the other column", way=lambda: -left())
    _turn(operator, 0.0)


def _turn(operator: Operator, heading: float) -> None:
    operator.stop()
    operator.flippers(*TURNING)
    operator.wait(1.0)
    operator.turn_to(heading)


def _along(operator: Operator, y: float, end: float) -> None:
    """Drive along a column to x = `end`."""
    operator.keep_lane(SPEED, (0.0, y))
    operator.work_on(lambda: operator.pose.x > end, ON_RAMPS, 40.0, f"x {end:.1f} m")


def cross_posts(operator: Operator, field: Stepfield) -> None:
    """Drive straight over the posts, trying what the flippers can do.

    Raises
    ------
    NotManagedError
    """
    operator.keep_lane(SPEED)
    operator.flippers(*ON_POSTS[0])
    operator.until(lambda: operator.pose.x > START - 0.8, 15.0, "the posts")
    operator.work_on(
        lambda: operator.pose.x > field.end + 0.5,
        ON_POSTS,
        40.0 * field.pallets,
        "the end of the posts",
        patience=2.0,
    )
    operator.wait(2.0)
    _arrive(operator)


def _arrive(operator: Operator) -> None:
    operator.flippers(*LEVEL)
    operator.stop()
    operator.wait(3.0)
    if operator.pose.z > AXLE_HEIGHT + 0.03 or abs(operator.pose.rise) > 0.05:
        raise NotManagedError(f"does not stand on the floor; {operator.where()}")
