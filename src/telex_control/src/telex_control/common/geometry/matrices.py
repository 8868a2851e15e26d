"""Rotations and rigid poses as numpy arrays.

A pose is a homogeneous transform of shape (4, 4), its position in metres. Nothing is checked here
but by `pose_matrices`, which reads what comes from outside; `telex_control.kinematics.make_pose`
refuses what is no pose.
"""

from __future__ import annotations

import math
from typing import Sequence, Union

import numpy as np

from .quaternions import Quaternion, quaternion_from_rpy, rotation_rows

Floats = Union[Sequence[float], np.ndarray]


def homogeneous(
    rotation: Union[Sequence[Sequence[float]], np.ndarray], position: Floats
) -> np.ndarray:
    """Return the pose, shape (4, 4), of a 3x3 rotation and a position (m)."""
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = position
    return pose


def pose_matrix(position: Floats, q: Quaternion) -> np.ndarray:
    """Return the pose, shape (4, 4), of a position (m) and a unit quaternion."""
    return homogeneous(rotation_rows(q), position)


def pose_matrices(poses: np.ndarray) -> np.ndarray:
    """Return the homogeneous matrices of many poses.

    Parameters
    ----------
    poses : ndarray, shape (n, 7)
        x y z (m), quaternion x y z w of any length but zero.

    Returns
    -------
    ndarray, shape (n, 4, 4)

    Raises
    ------
    ValueError
        When the shape is wrong, a value is not finite, or a quaternion is zero.
    """
    poses = np.asarray(poses, dtype=np.float64)
    if poses.ndim != 2 or poses.shape[1] != 7:
        raise ValueError(f"poses must have the shape (N, 7), got {poses.shape}")
    if not np.isfinite(poses).all():
        raise ValueError(f"pose {int(np.argmin(np.isfinite(poses).all(axis=1)))} is not finite")
    squares = np.einsum("ij,ij->i", poses[:, 3:], poses[:, 3:])
    if (squares < 1e-12).any():
        raise ValueError(f"pose {int(np.argmin(squares))} has a zero quaternion")
    # A factor of 2/|q|^2 in the usual formula spares the normalisation.
    x, y, z, w = (poses[:, 3:] * np.sqrt(2.0 / squares)[:, None]).T
    matrices = np.zeros((len(poses), 4, 4))
    matrices[:, 0, 0] = 1.0 - y * y - z * z
    matrices[:, 0, 1] = x * y - z * w
    matrices[:, 0, 2] = x * z + y * w
    matrices[:, 1, 0] = x * y + z * w
    matrices[:, 1, 1] = 1.0 - x * x - z * z
    matrices[:, 1, 2] = y * z - x * w
    matrices[:, 2, 0] = x * z - y * w
    matrices[:, 2, 1] = y * z + x * w
    matrices[:, 2, 2] = 1.0 - x * x - y * y
    matrices[:, :3, 3] = poses[:, :3]
    matrices[:, 3, 3] = 1.0
    return matrices


def inverse(pose: np.ndarray) -> np.ndarray:
    """Return the inverse of a pose, shape (4, 4)."""
    made = np.eye(4)
    made[:3, :3] = pose[:3, :3].T
    made[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return made


def rotation_matrix(q: Quaternion) -> np.ndarray:
    """Return the rotation matrix, shape (3, 3), of a unit quaternion."""
    return np.array(rotation_rows(q))


def rotation_from_rpy(rpy: Sequence[float]) -> np.ndarray:
    """Return the rotation matrix, shape (3, 3), of URDF's roll, pitch and yaw (rad)."""
    return rotation_matrix(quaternion_from_rpy(rpy))


def quaternion_of(pose: np.ndarray) -> np.ndarray:
    """Return the unit quaternion x, y, z, w (w >= 0) of a pose, or of a 3x3 rotation.

    By S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978): divided
    by the largest of the four, which is 1/2 at least.
    """
    m = np.asarray(pose)
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    sizes = (m[0, 0], m[1, 1], m[2, 2], trace)
    largest = int(np.argmax(sizes))
    found = np.empty(4)
    if largest == 3:
        found[:] = (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + trace)
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        found[i] = 1.0 + 2.0 * m[i, i] - trace
        found[j] = m[j, i] + m[i, j]
        found[k] = m[k, i] + m[i, k]
        found[3] = m[k, j] - m[j, k]
    found /= np.linalg.norm(found)
    return -found if found[3] < 0.0 else found


def quaternion_tuple(pose: np.ndarray) -> Quaternion:
    """Return what `quaternion_of` does, as plain floats."""
    x, y, z, w = quaternion_of(pose).tolist()
    return x, y, z, w


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Return axis times angle (rad, 0 to pi), shape (3,), of a 3x3 rotation or of a pose's."""
    x, y, z, w = quaternion_of(rotation)
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return np.array([scale * x, scale * y, scale * z])


def rotation_about(turn: Floats) -> np.ndarray:
    """Return the rotation matrix, shape (3, 3), of a rotation vector (rad).

    The formula of Rodrigues: R = 1 + sin(a)/a [v] + (1 - cos(a))/a^2 [v]^2.
    """
    x, y, z = turn
    angle = math.sqrt(x * x + y * y + z * z)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-8:
        return np.eye(3) + skew
    half = math.sin(0.5 * angle) / angle
    return np.eye(3) + (math.sin(angle) / angle) * skew + (2.0 * half * half) * (skew @ skew)
