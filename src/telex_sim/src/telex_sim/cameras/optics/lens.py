"""Lens distortion, as sensor_msgs/CameraInfo's "plumb_bob" describes it."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Tuple

import cv2
import numpy as np

from .pinhole import PinholeCamera

Distortion = Tuple[float, float, float, float, float]
"""k1, k2, p1, p2, k3 of Brown's model, in OpenCV's order."""

NO_DISTORTION: Distortion = (0.0, 0.0, 0.0, 0.0, 0.0)

# Distance between the pixels whose rays are computed; straight lines lead from one to the next, at
# most hundredths of a pixel beside the truth.
_GRID = 8

# Of finding the ray of a pixel: most iterations, and when to stop (of the focal length).
_SOLVED = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-10)

# What a pixel's ray may miss it by when projected (pixels).
_RESIDUAL = 1e-3

# Pixels that the wider picture has beyond the last one that the lens shows, for interpolation.
_MARGIN = 2


# Most threads that bend one picture; with more, most of the time goes with waiting for each other.
_MOST_THREADS = 4


class DistortionError(ValueError):
    """A lens shows two directions in one place, or none; the message says where that begins."""


@dataclass(frozen=True)
class LensCamera:
    """A camera with a lens. Without distortion it is a pinhole camera.

    The frames and pixels are `PinholeCamera`'s.

    Attributes
    ----------
    width, height
        Size of the picture (pixels).
    focal_length
        In the middle of the picture (pixels).
    distortion
        D of sensor_msgs/CameraInfo.
    near, far
        Distances along z between which things are drawn (m).
    """

    width: int
    height: int
    focal_length: float
    distortion: Distortion
    near: float
    far: float

    @classmethod
    def of_field(
        cls,
        width: int,
        height: int,
        horizontal_fov: float,
        distortion: Distortion,
        near: float,
        far: float,
    ) -> LensCamera:
        """Make the camera that sees a given angle between the outer edges of its picture.

        Parameters
        ----------
        width, height, near, far
            As the attributes.
        horizontal_fov
            Full angle across the middle row (rad); what p1 and p2 add to it is left out.
        distortion
            As the attribute.

        Raises
        ------
        DistortionError
            The field is wider than what the distortion can map.
        """
        k1, k2, _, _, k3 = distortion
        edge = math.tan(0.5 * horizontal_fov)
        squares = np.linspace(0.0, edge, 65) ** 2
        slopes = 1.0 + squares * (3.0 * k1 + squares * (5.0 * k2 + squares * 7.0 * k3))
        if slopes.min() <= 0.0:
            angle = math.atan(math.sqrt(float(squares[np.argmax(slopes <= 0.0)])))
            raise DistortionError(
                f"distortion {list(distortion)} folds the picture {angle:.3g} rad off its middle;"
                f" half the field of view is {0.5 * horizontal_fov:.3g} rad"
            )
        square = edge * edge
        shown = edge * (1.0 + square * (k1 + square * (k2 + square * k3)))
        camera = cls(width, height, 0.5 * width / shown, distortion, near, far)
        camera.field()
        return camera

    def intrinsic_matrix(self) -> np.ndarray:
        """K of sensor_msgs/CameraInfo, shape (3, 3)."""
        return np.array(
            [
                [self.focal_length, 0.0, 0.5 * (self.width - 1)],
                [0.0, self.focal_length, 0.5 * (self.height - 1)],
                [0.0, 0.0, 1.0],
            ]
        )

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels (u, v) of points in the optical frame with z > 0; shapes (N, 3) and (N, 2)."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 1, 3)
        zero = np.zeros(3)
        pixels, _ = cv2.projectPoints(
            points, zero, zero, self.intrinsic_matrix(), np.array(self.distortion, dtype=np.float64)
        )
        return pixels.reshape(-1, 2)

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Where the rays of pixels meet the plane z = 1; shapes (N, 2) and (N, 2).

        Raises
        ------
        DistortionError
            A pixel has no ray.
        """
        pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        rays = cv2.undistortPointsIter(
            pixels.reshape(-1, 1, 2),
            self.intrinsic_matrix(),
            np.array(self.distortion, dtype=np.float64),
            np.eye(3),
            np.eye(3),
            _SOLVED,
        ).reshape(-1, 2)
        solved = np.isfinite(rays).all(axis=1)
        back = self.project(np.column_stack([np.where(solved[:, None], rays, 0.0), solved * 1.0]))
        missed = ~(solved & (np.abs(back - pixels).max(axis=1) < _RESIDUAL))
        if missed.any():
            u, v = pixels[int(np.argmax(missed))]
            raise DistortionError(
                f"distortion {list(self.distortion)} shows nothing at pixel ({u:g}, {v:g}) of"
                f" {self.width}x{self.height}; smaller coefficients are needed"
            )
        return rays

    def field(self) -> Tuple[float, float]:
        """How far the picture reaches in the plane z = 1, to either side and up or down.

        Raises
        ------
        DistortionError
            A pixel of the border has no ray.
        """
        columns = np.linspace(-0.5, self.width - 0.5, 33)
        rows = np.linspace(-0.5, self.height - 0.5, 33)
        border = [(u, v) for u in columns for v in (rows[0], rows[-1])]
        border += [(u, v) for u in (columns[0], columns[-1]) for v in rows]
        reach = np.abs(self.rays(np.array(border))).max(axis=0)
        return float(reach[0]), float(reach[1])


def bending_threads(on_card: bool) -> int:
    """Choose how many threads OpenCV may bend pictures with.

    Where a graphics card draws, bending takes longest, and half of the processors may help. Without
    one, the others are needed by the physics.
    """
    return min(max(1, len(os.sched_getaffinity(0)) // 2), _MOST_THREADS) if on_card else 1


def drawn_size(camera: LensCamera, detail: float) -> Tuple[int, int]:
    """Width and height of the pictures that `LensMap` needs for a camera (pixels).

    Raises
    ------
    DistortionError
    """
    if not any(camera.distortion):
        # The focal length is that of the width; no row may lie beyond the height.
        width = round(camera.width * detail)
        return width, math.ceil(camera.height * width / camera.width)
    across, along = camera.field()
    focal = camera.focal_length * detail
    return 2 * math.ceil(across * focal + _MARGIN), 2 * math.ceil(along * focal + _MARGIN)


class LensMap:
    """Turns pictures of a pinhole camera into what a camera with a lens shows.

    Parameters
    ----------
    camera
        With the lens.
    detail
        Pixels of the pinhole camera for one of the picture, in its middle. Below 1 the picture is
        softer and takes less work.

    Attributes
    ----------
    pinhole : PinholeCamera
        That the pictures must come from; its field is as wide as the lens needs, so that every
        pixel has something to show.

    Raises
    ------
    DistortionError
    """

    def __init__(self, camera: LensCamera, detail: float) -> None:
        plain = not any(camera.distortion)
        width, height = drawn_size(camera, detail)
        focal = camera.focal_length * detail
        if plain:
            focal = camera.focal_length * width / camera.width
        self.pinhole = PinholeCamera(
            width, height, 2.0 * math.atan(0.5 * width / focal), camera.near, camera.far
        )
        self._identical = plain and detail == 1.0
        if not self._identical:
            sources = self._sources(camera, focal)
            self._maps = cv2.convertMaps(*sources, cv2.CV_16SC2)
            nearest, _ = cv2.convertMaps(*sources, cv2.CV_16SC2, nninterpolation=True)
            # An empty second map: the first says all.
            self._nearest = nearest, np.zeros((0, 0), dtype=np.uint16)

    def _sources(self, camera: LensCamera, focal: float) -> Tuple[np.ndarray, np.ndarray]:
        """Column and row of the pinhole's picture for each pixel, shape (height, width) each."""
        columns, across = _between(camera.width)
        rows, along = _between(camera.height)
        grid = np.stack(np.meshgrid(columns, rows), axis=-1)
        rays = camera.rays(grid.reshape(-1, 2)).reshape(grid.shape)
        middle = 0.5 * (self.pinhole.width - 1), 0.5 * (self.pinhole.height - 1)
        u, v = (
            (along @ (rays[..., axis] * focal + middle[axis]) @ across.T).astype(np.float32)
            for axis in (0, 1)
        )
        return u, v

    def bend(self, picture: np.ndarray) -> np.ndarray:
        """Show a picture of the pinhole camera as the lens does; may return it itself.

        Parameters
        ----------
        picture
            Shape (pinhole.height, pinhole.width, channels), uint8.

        Returns
        -------
        numpy.ndarray
            Shape (height, width, channels), uint8.
        """
        if self._identical:
            return picture
        return cv2.remap(picture, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    def bend_depth(self, depth: np.ndarray) -> np.ndarray:
        """Do the same with depths along z, shape (height, width), float32.

        They are not mixed: between a thing and what is behind it, there is nothing.
        """
        if self._identical:
            return depth
        return cv2.remap(depth, *self._nearest, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def _between(count: int) -> Tuple[np.ndarray, np.ndarray]:
    """Some of ``count`` pixels, and the weights that give all of them, shape (count, some)."""
    some = max(2, math.ceil(count / _GRID) + 1)
    nodes = np.linspace(0.0, count - 1.0, some)
    places = np.arange(count) / (count - 1.0) * (some - 1.0)
    left = np.minimum(places.astype(int), some - 2)
    weights = np.zeros((count, some))
    every = np.arange(count)
    weights[every, left + 1] = places - left
    weights[every, left] = 1.0 - (places - left)
    return nodes, weights
