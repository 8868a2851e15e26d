"""Rotations as unit quaternions and rigid poses as plain tuples, computed without numpy.

A pose is a position (m) and a quaternion x, y, z, w of length 1. It stands for a frame: `compose`
takes what is given in that frame into the frame that the pose is given in.
"""

from __future__ import annotations

import math
from typing import Sequence, Tuple

Vector3 = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]
Pose = Tuple[Vector3, Quaternion]
Rows = Tuple[Vector3, Vector3, Vector3]
"""A rotation matrix, row by row."""

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
"""The rotation that turns nothing."""
IDENTITY: Pose = (ORIGIN, UPRIGHT)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation `b` followed by `a`, both about the axes of the frame outside.

    It is normalised, so that long products stay rotations; neither factor may be zero.
    """
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    w = aw * bw - ax * bx - ay * by - az * bz
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return (x / length, y / length, z / length, w / length)


def conjugate(q: Quaternion) -> Quaternion:
    """Return the opposite rotation."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Sequence[float]) -> Vector3:
    """Return the vector `v` (3 numbers) turned by the unit quaternion `q`."""
    x, y, z, w = q
    # v + 2 w (u x v) + 2 u x (u x v), with u the quaternion's vector part
    cx, cy, cz = y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]
    return (
        v[0] + 2.0 * (w * cx + y * cz - z * cy),
        v[1] + 2.0 * (w * cy + z * cx - x * cz),
        v[2] + 2.0 * (w * cz + x * cy - y * cx),
    )


def compose(a: Pose, b: Pose) -> Pose:
    """Return the pose `b`, given in the frame `a`, in the frame that `a` is given in."""
    x, y, z = rotate(a[1], b[0])
    return (a[0][0] + x, a[0][1] + y, a[0][2] + z), product(a[1], b[1])


def invert(pose: Pose) -> Pose:
    """Return the pose that `compose` makes the identity of."""
    turned = conjugate(pose[1])
    x, y, z = rotate(turned, pose[0])
    return (-x, -y, -z), turned


def about(axis: Sequence[float], angle: float) -> Quaternion:
    """Return the rotation by `angle` (rad) about a unit vector."""
    sine = math.sin(angle / 2.0)
    return (axis[0] * sine, axis[1] * sine, axis[2] * sine, math.cos(angle / 2.0))


def twist(q: Quaternion, axis: Sequence[float]) -> Quaternion:
    """Return the part of the rotation `q` that is about the unit vector `axis`.

    Nothing is turned where `q` is half a turn about an axis across it: any part would do.
    """
    along = q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2]
    length = math.hypot(along, q[3])
    if length < 1e-12:
        return UPRIGHT
    sine = along / length
    return (axis[0] * sine, axis[1] * sine, axis[2] * sine, q[3] / length)


def angle_between(a: Quaternion, b: Quaternion) -> float:
    """Return the angle (rad, 0 to pi) of the rotation between two unit quaternions.

    By the vector part of the difference: the arc cosine of the scalar part is blind near 0.
    """
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    w = aw * bw + ax * bx + ay * by + az * bz
    x = aw * bx - ax * bw - ay * bz + az * by
    y = aw * by - ay * bw - az * bx + ax * bz
    z = aw * bz - az * bw - ax * by + ay * bx
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def quaternion_from_rpy(rpy: Sequence[float]) -> Quaternion:
    """Return the rotation of URDF's roll, pitch and yaw (rad)."""
    (sin_r, cos_r), (sin_p, cos_p), (sin_y, cos_y) = (
        (math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in rpy
    )
    return (
        sin_r * cos_p * cos_y - cos_r * sin_p * sin_y,
        cos_r * sin_p * cos_y + sin_r * cos_p * sin_y,
        cos_r * cos_p * sin_y - sin_r * sin_p * cos_y,
        cos_r * cos_p * cos_y + sin_r * sin_p * sin_y,
    )


def rpy_from_quaternion(q: Quaternion) -> Vector3:
    """Return roll, pitch and yaw (rad) of a unit quaternion; see `rpy_from_rows`."""
    return rpy_from_rows(rotation_rows(q))


def rpy_from_rows(rows: Sequence[Sequence[float]]) -> Vector3:
    """Return roll, pitch and yaw (rad) of a rotation matrix.

    Roll and yaw are within +-pi, the pitch within +-pi/2. Where the pitch is a right angle, roll
    and yaw turn about the same axis and only their sum or difference is determined; the yaw is
    computed from what the roll leaves, so that the three together give the rotation there too.
    """
    (_, b, c), (_, e, f), (g, h, i) = rows
    roll = math.atan2(h, i)
    sine, cosine = math.sin(roll), math.cos(roll)
    # Without the roll, the middle column is (-sin yaw, cos yaw, 0).
    yaw = math.atan2(c * sine - b * cosine, e * cosine - f * sine)
    return roll, math.atan2(-g, math.hypot(h, i)), yaw


def yaw_of(q: Quaternion) -> float:
    """Return the heading (rad) of the x axis that the unit quaternion `q` turns."""
    x, y, z, w = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def rotation_rows(q: Quaternion) -> Rows:
    """Return the rotation matrix of a unit quaternion."""
    x, y, z, w = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


def transform_by_rows(rows: Rows, v: Vector3) -> Vector3:
    """Return the vector `v` multiplied by a matrix from the left."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    x, y, z = v
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)
