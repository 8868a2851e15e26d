"""Rigid poses as plain tuples: a position (m) and a quaternion x y z w of length 1."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

from .model import ORIGIN, UPRIGHT, Quaternion, Vector3

Pose = Tuple[Vector3, Quaternion]

IDENTITY: Pose = (ORIGIN, UPRIGHT)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation `b`, then `a`; normalised, so that long products stay rotations."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    w = aw * bw - ax * bx - ay * by - az * bz
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return (x / length, y / length, z / length, w / length)


def conjugate(q: Quaternion) -> Quaternion:
    """The opposite rotation."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Sequence[float]) -> Vector3:
    """The vector `v`, turned by `q`."""
    x, y, z, w = q
    # v + 2 w (u x v) + 2 u x (u x v), with u the quaternion's vector part
    cx, cy, cz = y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]
    return (
        v[0] + 2.0 * (w * cx + y * cz - z * cy),
        v[1] + 2.0 * (w * cy + z * cx - x * cz),
        v[2] + 2.0 * (w * cz + x * cy - y * cx),
    )


def compose(a: Pose, b: Pose) -> Pose:
    """The pose `b`, given in the frame `a`, in the frame that `a` is given in."""
    x, y, z = rotate(a[1], b[0])
    return (a[0][0] + x, a[0][1] + y, a[0][2] + z), product(a[1], b[1])


def invert(pose: Pose) -> Pose:
    """The pose that `compose` makes the identity of."""
    turned = conjugate(pose[1])
    x, y, z = rotate(turned, pose[0])
    return (-x, -y, -z), turned


def about(axis: Sequence[float], angle: float) -> Quaternion:
    """A turn by `angle` (rad) about a unit vector."""
    sine = math.sin(angle / 2.0)
    return (axis[0] * sine, axis[1] * sine, axis[2] * sine, math.cos(angle / 2.0))


def twist(q: Quaternion, axis: Sequence[float]) -> Quaternion:
    """The part of the turn `q` that is about the unit vector `axis`."""
    along = q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2]
    length = math.hypot(along, q[3])
    if length < 1e-12:
        return UPRIGHT
    sine = along / length
    return (axis[0] * sine, axis[1] * sine, axis[2] * sine, q[3] / length)
