"""How far a robot may still rotate before it tips over, with what would catch it on its way.

The force-angle measure of `telex_sim.stability` looks at what carries the robot now. On stairs that
is an edge or two, which change from moment to moment, and a robot that rocks from one onto the next
is not about to tip over. So this looks at what stands near the tracks as well: rotated about an
edge of its support, the robot comes to rest on it, or passes it by.

Vectors are in any one frame whose z axis is vertical. Nothing here knows of PyBullet.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Optional, Sequence, Tuple

from .stability import ForceAngle, Vector, force_angles

_CARRIES = 0.2
"""Least upward part of a foothold's normal."""
_FARTHEST = math.radians(60.0)
"""Most that a robot rotates until it is caught, and most that it may be tilted then: beyond, it
falls.
"""
_LEVER = 0.02
"""Least distance (m) over the edge, and least way of a foothold towards the ground per rotation
(m/rad), with which it catches anything.
"""


class Foothold(NamedTuple):
    """A place near a track that could carry it.

    Attributes
    ----------
    point, ground : Vector
        Nearest points of the track and of what stands there (m).
    normal : Vector
        Unit vector, towards the track.
    gap : float
        Between them (m); below 0 where they touch.
    """

    point: Vector
    ground: Vector
    normal: Vector
    gap: float

    @property
    def carries(self) -> bool:
        """Whether it can hold the robot up."""
        return self.normal[2] >= _CARRIES


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
    polygon: Sequence[Vector],
    center_of_mass: Vector,
    force: Vector,
    moment: Vector,
    footholds: Sequence[Foothold],
    axes: Any,
) -> Optional[TippingAngle]:
    """Least rotations over the edges of the support with which a robot tips over.

    Parameters
    ----------
    polygon : sequence of Vector
        As `telex_sim.stability.support_polygon` returns it (m).
    center_of_mass : Vector
        m.
    force, moment : Vector
        Of all that acts on it but its support and its inertia: their sum (N), and its moment about
        the centre of mass (N m).
    footholds : sequence of Foothold
    axes : array_like, shape (3, 3)
        The robot's x, y and z axis, one a row.

    Returns
    -------
    TippingAngle or None
        None when fewer than two points carry it.
    """
    able = [foothold for foothold in footholds if foothold.carries]
    edges = force_angles(polygon, center_of_mass, force, moment)
    if not edges:
        return None
    least = [(math.inf, 0.0), (math.inf, 0.0)]
    for edge in edges:
        x, y = (_Side(edge).turned(axis)[0] for axis in axes[:2])
        side = int(abs(y) > abs(x))
        found = _over(edge, center_of_mass, able, axes[2]), math.atan2(y, x)
        least[side] = min(least[side], found)
    (ahead, ahead_direction), (sideways, sideways_direction) = least
    return TippingAngle(ahead, sideways, ahead_direction, sideways_direction)


def _over(
    edge: ForceAngle, center: Vector, footholds: Sequence[Foothold], up: Sequence[float]
) -> float:
    """Rotation with which the robot tips over this edge, or over what catches it behind it."""
    side = _Side(edge)
    caught, catcher = _FARTHEST, None
    for foothold in footholds:
        outer, height = side.of(foothold.point)
        ahead, above = side.turned(foothold.normal)
        closing = outer * above - height * ahead
        if outer > _LEVER and closing > _LEVER and foothold.gap < caught * closing:
            caught, catcher = max(0.0, foothold.gap / closing), (outer, height)
    if catcher is None:
        return edge.angle
    ahead, above = side.turned(up)
    if above * math.cos(caught) - ahead * math.sin(caught) < math.cos(_FARTHEST):
        return edge.angle
    outer, height = _rotated(side.of(center), caught)
    beyond, below = _rotated(catcher, caught)
    # What else acts on the robot than its weight turns the net force; it does so after, too.
    own_outer, own_height = side.of(center)
    turned = edge.angle - math.atan2(-own_outer, own_height)
    return max(edge.angle, math.atan2(beyond - outer, height - below) + turned)


class _Side:
    """The vertical plane across an edge: outwards and up, from the edge."""

    def __init__(self, edge: ForceAngle) -> None:
        self._start, self._outward = edge.start, edge.outward

    def of(self, point: Vector) -> Tuple[float, float]:
        x, y, z = self._start
        return self.turned((point[0] - x, point[1] - y, point[2] - z))

    def turned(self, direction: Sequence[float]) -> Tuple[float, float]:
        return (
            direction[0] * self._outward[0] + direction[1] * self._outward[1],
            direction[2],
        )


def _rotated(place: Tuple[float, float], angle: float) -> tuple[float, float]:
    """Rotate over the edge by so much (rad)."""
    outer, height = place
    sine, cosine = math.sin(angle), math.cos(angle)
    return outer * cosine + height * sine, height * cosine - outer * sine
