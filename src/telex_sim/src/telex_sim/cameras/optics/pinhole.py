"""The pinhole camera: intrinsics, and the projection matrix that agrees with them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PinholeCamera:
    """A camera without distortion.

    The optical frame is ROS's: x right, y down, z forward. Pixel (0, 0) has its *centre* at
    u = v = 0, as in sensor_msgs/CameraInfo and OpenCV, so the principal point of a camera that
    looks through the middle of its picture is ((width - 1)/2, (height - 1)/2).

    Attributes
    ----------
    width, height
        Size of the picture (pixels).
    horizontal_fov
        Angle between the outer edges of the outermost columns (rad).
    near, far
        Distances along z between which things are drawn (m).
    """

    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float

    @property
    def focal_length(self) -> float:
        """Focal length (pixels), the same along both axes: pixels are square."""
        return 0.5 * self.width / math.tan(0.5 * self.horizontal_fov)

    def intrinsic_matrix(self) -> np.ndarray:
        """K of sensor_msgs/CameraInfo, shape (3, 3)."""
        focal = self.focal_length
        return np.array(
            [
                [focal, 0.0, 0.5 * (self.width - 1)],
                [0.0, focal, 0.5 * (self.height - 1)],
                [0.0, 0.0, 1.0],
            ]
        )

    def clip_from_optical(self) -> np.ndarray:
        """OpenGL's projection matrix for points in the optical frame, shape (4, 4).

        OpenGL numbers rows from below, pictures from above: y is deliberately not turned, so the
        buffer that is read back begins with the top row. That mirrors the winding of triangles:
        front faces are clockwise.
        """
        k = self.intrinsic_matrix()
        depth = self.far - self.near
        return np.array(
            [
                # The half pixel leads from pixel centres to OpenGL's pixel edges.
                [2.0 * k[0, 0] / self.width, 0.0, (2.0 * k[0, 2] + 1.0) / self.width - 1.0, 0.0],
                [0.0, 2.0 * k[1, 1] / self.height, (2.0 * k[1, 2] + 1.0) / self.height - 1.0, 0.0],
                [0.0, 0.0, (self.far + self.near) / depth, -2.0 * self.far * self.near / depth],
                [0.0, 0.0, 1.0, 0.0],
            ]
        )

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels (u, v) of points in the optical frame with z > 0; shapes (N, 3) and (N, 2)."""
        homogeneous = np.asarray(points, dtype=np.float64) @ self.intrinsic_matrix().T
        return homogeneous[:, :2] / homogeneous[:, 2:]
