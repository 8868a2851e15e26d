"""Rotation that is left until a robot tips over, with what would catch it on its way.

The measure of `force_angle` looks at what carries the robot now. On stairs that is an edge or two,
which change from moment to moment, and a robot that rocks from one onto the next is not about to
tip over. So this looks at what stands near the tracks as well: rotated about an edge of its
support, the robot comes to rest on it, or passes it by.

Vectors are in any one frame whose z axis is vertical. Nothing here knows of PyBullet.
"""

from __future__ import annotations

import math
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .force_angle import ForceAngle, Vector

CARRIES = 0.2
"""Least upward part of a foothold's normal."""
_FARTHEST = math.radians(60.0)
"""Most that a robot rotates until it is caught, and most that it may be tilted then: beyond, it
falls.
"""
LEVER = 0.02
"""Least distance (m) over the edge, and least way of a foothold towards the ground per rotation
(m/rad), with which it catches anything.
"""


class Footholds(NamedTuple):
    """Places near the tracks and the hull that could carry the robot.

    Attributes
    ----------
    points, grounds : ndarray, shape (n, 3)
        Nearest points of the robot and of what stands there (m).
    normals : ndarray, shape (n, 3)
        Unit vectors, towards the robot.
    gaps : ndarray, shape (n,)
        Between them (m); below 0 where they touch.
    """

    points: np.ndarray
    grounds: np.ndarray
    normals: np.ndarray
    gaps: np.ndarray

    def those(self, which: np.ndarray) -> Footholds:
        """Return a part of them, by number or by a mask."""
        return Footholds(*(column[which] for column in self))


NO_FOOTHOLDS = Footholds(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3)), np.empty(0))


class TippingAngle(NamedTuple):
    """Least rotations (rad) with which a robot tips over; below 0 it falls, and nothing catches it.

    Attributes
    ----------
    ahead, sideways : float
        Over its nose or rear, and over its sides; infinite where no edge of the support lies there.
    ahead_direction, sideways_direction : float
        Where it would tip then, in its x-y plane (rad).
    """

    ahead: float
    sideways: float
    ahead_direction: float
    sideways_direction: float


def tipping_angle(
    edges: Sequence[ForceAngle], center_of_mass: Vector, footholds: Footholds, axes: Any
) -> Optional[TippingAngle]:
    """Least rotations over the edges of the support with which a robot tips over.

    Parameters
    ----------
    edges : sequence of ForceAngle
        Of the support, as `force_angle.force_angles` returns them for all that acts on the robot
        but its support and its inertia.
    center_of_mass : Vector
        m.
    axes : array_like, shape (3, 3)
        The robot's x, y and z axis, one a row.

    Returns
    -------
    TippingAngle or None
        None where there is no edge.
    """
    if not edges:
        return None
    least = [(math.inf, 0.0), (math.inf, 0.0)]
    for edge, catch in zip(edges, _catches(edges, footholds)):
        x, y = (_turned(edge, axis)[0] for axis in axes[:2])
        side = int(abs(y) > abs(x))
        angle = edge.angle if catch is None else _over(edge, catch, center_of_mass, axes[2])
        least[side] = min(least[side], (angle, math.atan2(y, x)))
    (ahead, ahead_direction), (sideways, sideways_direction) = least
    return TippingAngle(ahead, sideways, ahead_direction, sideways_direction)


class _Catch(NamedTuple):
    """By what the robot is caught that rotates over an edge: after so much (rad), and where (m)."""

    rotation: float
    outer: float
    height: float


def _catches(edges: Sequence[ForceAngle], footholds: Footholds) -> List[Optional[_Catch]]:
    """What catches it first over each edge, if anything does."""
    points, _, normals, gaps = footholds
    if not len(gaps):
        return [None] * len(edges)
    outward = np.array([edge.outward for edge in edges]).T
    starts = np.array([edge.start for edge in edges])
    outer = points[:, :2] @ outward - (starts[:, :2] * outward.T).sum(axis=1)
    height = points[:, 2:] - starts[:, 2]
    closing = outer * normals[:, 2:] - height * (normals[:, :2] @ outward)
    able = (outer > LEVER) & (closing > LEVER) & (normals[:, 2:] >= CARRIES)
    rotations = np.where(able, gaps[:, None] / np.maximum(closing, LEVER), math.inf)
    found: List[Optional[_Catch]] = []
    for column, row in enumerate(rotations.argmin(axis=0).tolist()):
        rotation = float(rotations[row, column])
        place = float(outer[row, column]), float(height[row, column])
        found.append(_Catch(max(0.0, rotation), *place) if rotation < _FARTHEST else None)
    return found


def _over(edge: ForceAngle, catch: _Catch, center: Vector, up: Sequence[float]) -> float:
    """Rotation with which the robot tips over this edge, or over what catches it behind it."""
    ahead, above = _turned(edge, up)
    caught = catch.rotation
    if above * math.cos(caught) - ahead * math.sin(caught) < math.cos(_FARTHEST):
        return edge.angle
    x, y, z = edge.start
    own_outer, own_height = _turned(edge, (center[0] - x, center[1] - y, center[2] - z))
    outer, height = _rotated((own_outer, own_height), caught)
    beyond, below = _rotated(catch[1:], caught)
    # What else acts on the robot than its weight turns the net force; it does so after, too.
    turned = edge.angle - math.atan2(-own_outer, own_height)
    return max(edge.angle, math.atan2(beyond - outer, height - below) + turned)


def _turned(edge: ForceAngle, direction: Sequence[float]) -> Tuple[float, float]:
    """Parts of a vector in the vertical plane across an edge: outwards, and up."""
    along = direction[0] * edge.outward[0] + direction[1] * edge.outward[1]
    return along, direction[2]


def _rotated(place: Tuple[float, float], angle: float) -> Tuple[float, float]:
    """Rotate over the edge by so much (rad)."""
    outer, height = place
    sine, cosine = math.sin(angle), math.cos(angle)
    return outer * cosine + height * sine, height * cosine - outer * sine
