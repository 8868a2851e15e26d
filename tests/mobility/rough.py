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

_HALF_WIDTH = 0.2  # m


@dataclass(frozen=True)
class CrossingRamps:
    """Two columns of ramps; where one rises, the other falls.

    Attributes
    ----------
    rows : int
        Ramps in a column.
    length, width : float
        Of a ramp (m).
    friction : float
    """

    rows: int = 4
    length: float = 1.2
    width: float = 0.6
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
        """Where to pass the ridges, in their order along x (m): a robot's half width aside."""
        return [
            (START + (row + 1) * self.length, -_HALF_WIDTH if row % 2 == 0 else _HALF_WIDTH)
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
    """Drive from ridge to ridge, from one column to the other and back.

    Raises
    ------
    NotManagedError
    """
    ridges = ramps.ridges()
    first, last = ridges[0], ridges[-1]
    corners = [(START - 0.8, first[1]), *ridges, (ramps.end + 1.0, last[1])]
    for begin, end in zip(corners, corners[1:]):
        yaw = math.atan2(end[1] - begin[1], end[0] - begin[0])
        operator.keep_lane(SPEED, begin, yaw)
        operator.work_on(
            lambda end=end: operator.pose.x > end[0],  # type: ignore[misc]
            ON_RAMPS,
            20.0,
            f"the corner at x {end[0]:.1f} m",
        )
        # How far aside it may be: a track has to be on each side of the ridge's middle.
        if abs(operator.pose.y - end[1]) > 0.5 * ramps.width:
            raise NotManagedError(f"lost the way; {operator.where()}")
    _arrive(operator)


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
