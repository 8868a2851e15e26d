"""Rigid transforms as numpy arrays, many at a time."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

import numpy as np

Quaternion = Tuple[float, float, float, float]

STILL = 1e-4
"""Motion that changes neither a shadow nor a picture that anybody could see (m, or rad at 1 m)."""


def pose_matrices(poses: np.ndarray) -> np.ndarray:
    """Homogeneous matrices of poses.

    Parameters
    ----------
    poses
        Shape (N, 7): x y z (m), quaternion x y z w of any length but zero.

    Returns
    -------
    numpy.ndarray
        Shape (N, 4, 4).

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


def is_still(now: np.ndarray, before: np.ndarray) -> bool:
    """Whether poses or points, of any shape, are so near to others that nobody could see it."""
    return now.shape == before.shape and float(np.abs(now - before).max(initial=0.0)) < STILL


def rigid_inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of one rigid transform, shape (4, 4)."""
    inverse = np.eye(4)
    inverse[:3, :3] = matrix[:3, :3].T
    inverse[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return inverse


def quaternion_from_rpy(rpy: Sequence[float]) -> Quaternion:
    """Quaternion x y z w of URDF's fixed-axis roll, pitch and yaw (rad)."""
    (sin_r, cos_r), (sin_p, cos_p), (sin_y, cos_y) = (
        (math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in rpy
    )
    return (
        sin_r * cos_p * cos_y - cos_r * sin_p * sin_y,
        cos_r * sin_p * cos_y + sin_r * cos_p * sin_y,
        cos_r * cos_p * sin_y - sin_r * sin_p * cos_y,
        cos_r * cos_p * cos_y + sin_r * sin_p * sin_y,
    )
