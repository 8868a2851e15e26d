"""Lines, points and boxes for `guard`: plain tuples, which are faster than arrays."""

from __future__ import annotations

import math
from typing import Iterable, NamedTuple, Sequence, Tuple

from telex_control.common.geometry.vectors import cross, difference, dot

from ..engine.world import Vector

Box = Tuple[Vector, Vector]
"""Lowest and highest corner of a box along the world's axes (m)."""


class Axis(NamedTuple):
    """A joint's axis in the world: a point on it (m), and its direction, of length 1."""

    origin: Vector
    direction: Vector
    prismatic: bool


def turned(matrix: Sequence[float], vector: Vector) -> Vector:
    """Return a vector after the rotation of a matrix of 9 numbers, as PyBullet gives it."""
    x, y, z = vector
    return (
        matrix[0] * x + matrix[1] * y + matrix[2] * z,
        matrix[3] * x + matrix[4] * y + matrix[5] * z,
        matrix[6] * x + matrix[7] * y + matrix[8] * z,
    )


def slope(axis: Axis, point: Vector, direction: Vector) -> float:
    """Velocity of a point along a direction, by a unit velocity of the joint."""
    if axis.prismatic:
        return dot(axis.direction, direction)
    return dot(cross(axis.direction, difference(point, axis.origin)), direction)


class Motion(NamedTuple):
    """Velocity of a point (m/s), and angular velocity (rad/s) of the body that it belongs to."""

    linear: Vector
    angular: Vector


def motion(axis: Axis, point: Vector, velocity: float) -> Motion:
    """Return how a joint's velocity (rad/s, m/s) moves a point, and what it belongs to."""
    x, y, z = axis.direction
    turning = (x * velocity, y * velocity, z * velocity)
    if axis.prismatic:
        return Motion(turning, (0.0, 0.0, 0.0))
    return Motion(cross(turning, difference(point, axis.origin)), turning)


def fastest(motions: Iterable[Motion], radius: float) -> float:
    """Speed (m/s) that nothing within a radius (m) of a point exceeds, under several motions."""
    vx = vy = vz = wx = wy = wz = 0.0
    for (x, y, z), (p, q, r) in motions:
        vx, vy, vz = vx + x, vy + y, vz + z
        wx, wy, wz = wx + p, wy + q, wz + r
    return math.hypot(vx, vy, vz) + radius * math.hypot(wx, wy, wz)


def sphere(box: Box) -> Tuple[Vector, float]:
    """Centre and radius (m) of the sphere around a box."""
    (ax, ay, az), (bx, by, bz) = box
    return (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz)), 0.5 * math.dist(*box)


def apart(a: Box, b: Box, gap: float) -> bool:
    """Whether two boxes are certainly further than `gap` (m) from each other."""
    (ax, ay, az), (bx, by, bz) = a
    (cx, cy, cz), (dx, dy, dz) = b
    return (
        cx - bx > gap
        or ax - dx > gap
        or cy - by > gap
        or ay - dy > gap
        or cz - bz > gap
        or az - dz > gap
    )


def inside(point: Vector, box: Box, slack: float) -> bool:
    """Whether a point is in a box, or not further than `slack` (m) beyond one of its sides."""
    (ax, ay, az), (bx, by, bz) = box
    x, y, z = point
    return (
        ax - slack <= x <= bx + slack
        and ay - slack <= y <= by + slack
        and az - slack <= z <= bz + slack
    )
