"""A gap between two platforms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List

from ..port import NotManagedError
from ..robot_size import AXLE_HEIGHT
from ..scripted_operator import Operator

SPEED = 0.30  # m/s

UP_RAMP = (0.40, 0.0)
FLAT = (0.0, 0.0)


@dataclass(frozen=True)
class Gap:
    """Two platforms with a gap between them, and ramps up to both.

    Attributes
    ----------
    width : float
        From edge to edge (m).
    height : float
        Of the platforms (m).
    platform, ramp : float
        Lengths (m).
    middle : float
        Of the gap, along x (m).
    """

    width: float = 0.4
    height: float = 0.2
    platform: float = 1.4
    ramp: float = 0.8
    friction: float = 1.0
    middle: float = 3.0

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "gap",
                "name": "gap",
                "position": [self.middle, 0.0, 0.0],
                "gap": self.width,
                "height": self.height,
                "platform": self.platform,
                "ramp": self.ramp,
                "width": 2.0,
                "friction": self.friction,
            }
        ]


def cross(operator: Operator, gap: Gap) -> None:
    """Up the ramp, flat over the gap, and down the other ramp.

    Raises
    ------
    NotManagedError
    """
    top = gap.height + AXLE_HEIGHT
    operator.keep_lane(SPEED)
    operator.flippers(*UP_RAMP)
    near = gap.middle - 0.5 * gap.width
    operator.until(lambda: operator.pose.x > near - 0.9, 20.0, "the platform")
    operator.flippers(*FLAT)
    deepest = top
    while operator.pose.x < gap.middle + 0.5 * gap.width + 0.5:
        if operator.time > 40.0:
            raise NotManagedError(f"stuck; {operator.where()}")
        operator.tick()
        if operator.pose.x > near:
            deepest = min(deepest, operator.pose.z)
    if deepest < top - 0.05:
        raise NotManagedError(f"sank {top - deepest:.2f} m into the gap")
    operator.until(
        lambda: operator.pose.z < AXLE_HEIGHT + 0.02 and abs(operator.pose.rise) < 0.1,
        15.0,
        "the floor behind",
    )
    operator.stop()
    operator.wait(0.4)
