"""Width of what the tool points at, as a training aid: no robot measures it."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import pybullet

from telex_control.common.geometry.quaternions import Vector3, rotate

from ..engine.world import Body
from .range_finder import first_met

MOST = 0.4
"""Width (m) from which on it is all the same."""
_DEPTHS = (0.001, 0.005, 0.015, 0.03, 0.045)
"""How far behind the nearest surface (m) fingers reach, and it is measured."""
_MOST_OTHERS = 3
"""Things beside it that are looked through."""
_BEHIND = 1e-3  # m, beyond the surface of one of them


def object_width(body: Body, finder: str, tool: str, reach: float) -> float:
    """Measure across the fingers' motion what stands along the axis of the range finder.

    Parameters
    ----------
    body : Body
        The robot's.
    finder : str
        Link that looks along its x axis.
    tool : str
        Link along whose y axis the fingers close.
    reach : float
        How far it is looked for (m).

    Returns
    -------
    float
        Width (m), at most `MOST`; NaN where nothing stands there, or a part of the robot itself.
    """
    met = first_met(body, finder, reach)
    if met is None or met[1][0] == body.uid:
        return math.nan
    distance, thing = met
    origin, orientation = body.pose(finder)
    ahead = rotate(orientation, (1.0, 0.0, 0.0))
    across = rotate(body.pose(tool)[1], (0.0, 1.0, 0.0))
    widths: List[float] = []
    for depth in _DEPTHS:
        middle = _along(origin, ahead, distance + depth)
        sides = [_outside(body, thing, middle, across, sign) for sign in (1.0, -1.0)]
        found = [0.5 * MOST if side is None else side for side in sides]
        # Of what is not so deep nothing is met; nor is it of what is wider than it is looked for.
        if sides != [None, None] or not widths:
            widths.append(sum(found) if min(found) > 0.0 else 0.0)
    return min(max(widths), MOST)


def _outside(
    body: Body, thing: Tuple[int, int], middle: Vector3, across: Vector3, sign: float
) -> Optional[float]:
    """Distance (m) from a point inside a thing to its surface on one side; None: it is not met."""
    begin = 0.5 * MOST
    end = _along(middle, across, -sign * 0.5 * MOST)
    for _ in range(_MOST_OTHERS):
        start = _along(middle, across, sign * begin)
        (hit,) = pybullet.rayTest(start, end, physicsClientId=body.client)
        if hit[0] < 0:
            return None
        place = begin - hit[2] * (begin + 0.5 * MOST)
        if (hit[0], hit[1]) == thing:
            return place
        begin = place - _BEHIND
    return None


def _along(point: Vector3, direction: Vector3, way: float) -> Vector3:
    x, y, z = (at + way * part for at, part in zip(point, direction))
    return x, y, z
