"""Inclined planes: driving up, standing along and across, sliding."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import numpy as np

from ..robot_size import AXLE_HEIGHT
from ..scripted_operator import Operator

FLAT = (0.0, 0.0)
ONTO = (0.45, 0.0)


@dataclass(frozen=True)
class Slope:
    """A plane that rises along x.

    Attributes
    ----------
    angle : float
        rad.
    length : float
        Along it (m).
    friction : float
        Of it and of the floor.
    foot : float
        Where it begins (m).
    """

    angle: float
    length: float = 8.0
    friction: float = 1.0
    foot: float = 0.8

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        run = self.length * math.cos(self.angle)
        return [
            {
                "type": "inclined_plane",
                "name": "slope",
                "position": [self.foot + 0.5 * run, 0.0, 0.0],
                "angle": self.angle,
                "length": self.length,
                "width": 4.0,
                "platform": 0.0,
                "friction": self.friction,
            }
        ]

    def pose(self, along: float, heading: float) -> Tuple[List[float], List[float]]:
        """Of base_link, standing `along` m up the slope: position, quaternion (x, y, z, w).

        Parameters
        ----------
        along : float
            m.
        heading : float
            In the plane, from uphill towards y (rad).
        """
        upward = np.array([math.cos(self.angle), 0.0, math.sin(self.angle)])
        normal = np.array([-math.sin(self.angle), 0.0, math.cos(self.angle)])
        position = np.array([self.foot, 0.0, 0.0]) + along * upward + AXLE_HEIGHT * normal
        half, turn = -0.5 * self.angle, 0.5 * heading
        # Pitch by the slope after a turn in its plane.
        orientation = [
            math.sin(half) * math.sin(turn),
            math.sin(half) * math.cos(turn),
            math.cos(half) * math.sin(turn),
            math.cos(half) * math.cos(turn),
        ]
        return list(position), orientation


def drive_up(operator: Operator, slope: Slope, speed: float, distance: float) -> float:
    """Drive up from the floor; returns the speed (m/s) over the last `distance` m.

    Raises
    ------
    NotManagedError
        The robot does not get up.
    """
    operator.flippers(*ONTO)
    operator.keep_lane(0.6 * speed)
    operator.until(
        lambda: abs(operator.pose.rise - slope.angle) < 0.12 and operator.pose.x > slope.foot,
        20.0,
        "on the slope",
    )
    operator.flippers(*FLAT)
    operator.keep_lane(speed)
    operator.wait(2.0)

    def way() -> float:
        return (operator.pose.x - slope.foot) / math.cos(slope.angle)

    begin, start = way(), operator.time
    operator.until(lambda: way() > begin + distance, 3.0 * distance / speed, "up the slope")
    return (way() - begin) / (operator.time - start)
