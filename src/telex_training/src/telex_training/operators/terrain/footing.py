"""Setting each flipper to the ground under it, so that the hull goes level over rough ground."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Tuple

from ..robot_size import (
    AXLE_HEIGHT,
    BELLY,
    BELT_INNER,
    BELT_OUTER,
    DROOP,
    FLIPPER_LENGTH,
    HALF_LENGTH,
    PIVOT,
    TIP_RADIUS,
)

Ground = Callable[[float, float], float]
"""Height (m) of the ground at x and y (m), as one sees it who stands beside the lane."""

_GRID = 0.02  # m, along x
_REACH = PIVOT + FLIPPER_LENGTH + TIP_RADIUS
_SPREAD = (0.0, 0.5, 1.0)
"""Where the ground is looked at under a belt, as shares of its width."""
_UP, _DOWN, _FINENESS = 0.80, -1.00, 0.04
"""Angles that a flipper is tried at, from the top (rad)."""
_TIP = (-1.2, -0.8, -0.4, 0.0, 0.4, 0.8, 1.2)
"""Places round the lower side of the tip: angle from straight down (rad).

As far as that, or a tip is let down between posts that it does not fit between, and has to climb
out of there.
"""
_RUN = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Places on the belt's lower run, as shares of the way from hub to tip."""
_HUB_BACK = [(back, math.sqrt(AXLE_HEIGHT**2 - back**2)) for back in (0.06, 0.10)]
"""Lower side of a rear hub: how far behind its axle, and how far under it (m).

So that the rear is let down an edge slowly, as its hubs roll off it.
"""


def settings(ground: Ground, x: float, y: float, clearance: float) -> Dict[str, float]:
    """Angles of the four flippers with which the hull stands level, its belly clear of the ground.

    The robot is taken to look along x.

    Parameters
    ----------
    x, y : float
        Of base_link (m).
    clearance : float
        Under the belly (m).

    Returns
    -------
    dict
        Joint, without ``_joint``, to angle (rad): that at which the flipper, coming from above,
        meets the ground; its lowest where it does not reach it.
    """
    sides = {
        "left": _Strip(ground, x, y + BELT_INNER, y + BELT_OUTER),
        "right": _Strip(ground, x, y - BELT_OUTER, y - BELT_INNER),
    }
    height = _level(_Strip(ground, x, y - BELT_INNER, y + BELT_INNER), sides, clearance)
    return {
        f"{end}_{side}_flipper": _meeting(strip, forwards, height)
        for side, strip in sides.items()
        for end, forwards in (("front", 1.0), ("rear", -1.0))
    }


def let_down(angles: Dict[str, float], high: str) -> Dict[str, float]:
    """Angles at which the flippers of the high side reach no lower than those beside them.

    Parameters
    ----------
    angles : dict
        See `settings`.
    high : str
        left or right.
    """
    low = "right" if high == "left" else "left"
    return {name: max(angle, angles[name.replace(high, low)]) for name, angle in angles.items()}


class _Strip:
    """The ground's highest places across a strip along x, from tip to tip of the robot."""

    def __init__(self, ground: Ground, x: float, right: float, left: float) -> None:
        places = [right + share * (left - right) for share in _SPREAD]
        self._count = math.ceil(_REACH / _GRID)
        self._heights: List[float] = [
            max(ground(x + _GRID * step, y) for y in places)
            for step in range(-self._count, self._count + 1)
        ]

    def height(self, ahead: float) -> float:
        """Height so far ahead of base_link (m)."""
        return self._heights[round(ahead / _GRID) + self._count]

    def highest(self, begin: float, end: float) -> float:
        """Highest place between two distances ahead of base_link (m)."""
        first, last = (round(each / _GRID) + self._count for each in (begin, end))
        return max(self._heights[first : last + 1])


def _level(middle: _Strip, sides: Dict[str, _Strip], clearance: float) -> float:
    """Height of base_link at which belly and hubs of a level hull are over the ground (m)."""
    belly = HALF_LENGTH - AXLE_HEIGHT
    needed = middle.highest(-belly, belly) + BELLY + clearance
    for strip in sides.values():
        needed = max(needed, strip.highest(-belly, belly) + BELLY + clearance)
        for hub in (-PIVOT, PIVOT):
            needed = max(needed, strip.height(hub) + AXLE_HEIGHT)
        needed = max(needed, *(strip.height(-PIVOT - back) + up for back, up in _HUB_BACK))
    return needed


def _outlines() -> List[Tuple[float, List[Tuple[float, float]]]]:
    """Lower side of a flipper from its pivot, outwards and upwards (m), at every angle tried."""
    found = []
    for step in range(round((_UP - _DOWN) / _FINENESS) + 1):
        angle = _UP - _FINENESS * step
        line = angle - DROOP
        along, up = FLIPPER_LENGTH * math.cos(line), FLIPPER_LENGTH * math.sin(line)
        tip = [(along + TIP_RADIUS * math.sin(at), up - TIP_RADIUS * math.cos(at)) for at in _TIP]
        run = [
            (share * along + radius * math.sin(angle), share * up - radius * math.cos(angle))
            for share in _RUN
            for radius in (AXLE_HEIGHT + share * (TIP_RADIUS - AXLE_HEIGHT),)
        ]
        found.append((angle, tip + run))
    return found


_OUTLINES = _outlines()


def _meeting(strip: _Strip, forwards: float, height: float) -> float:
    """Angle at which a flipper meets the ground, its pivot at a height (m)."""
    for angle, outline in _OUTLINES:
        for outwards, up in outline:
            if height + up <= strip.height(forwards * (PIVOT + outwards)):
                return angle
    return _DOWN
