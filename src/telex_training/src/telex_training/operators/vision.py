"""Measurements in pictures: things of a colour, lines of sight, the pose of a cube."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

import cv2
import numpy as np

_MARGIN = 30  # pixels
_ROUNDS = 3
"""Of a fit whose parts depend on one another."""


@dataclass(frozen=True)
class VividColor:
    """A vivid colour, by which a thing is told from all around it.

    Attributes
    ----------
    name : str
        For messages.
    hue : float
        Degrees, 0 to 360: 0 red, 120 green, 240 blue.
    tolerance : float
        Of the hue (degrees).
    saturation : float
        At least, 0 to 1.
    value : float
        At least, 0 to 1: what is darker has no colour that could be trusted.
    """

    name: str
    hue: float
    tolerance: float = 18.0
    saturation: float = 0.45
    value: float = 0.12


@dataclass(frozen=True)
class SeenPicture:
    """A picture, and where it was taken from.

    Attributes
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    matrix : ndarray, shape (3, 3)
        K of the camera's CameraInfo.
    distortion : ndarray, shape (5,)
        D of it.
    pose : ndarray, shape (4, 4)
        Of the optical frame (z ahead, x right, y down) in base_link.
    """

    image: np.ndarray
    matrix: np.ndarray
    distortion: np.ndarray
    pose: np.ndarray


@dataclass(frozen=True)
class Blob:
    """A thing of a colour in a picture.

    Attributes
    ----------
    hull : ndarray, shape (n, 2)
        Convex hull of its largest part (pixels).
    area : float
        Of the hull (pixels).
    center : tuple of 2 floats
        Centroid of the hull (pixels).
    whole : bool
        It does not reach the picture's border.
    """

    hull: np.ndarray
    area: float
    center: Tuple[float, float]
    whole: bool


@dataclass(frozen=True)
class Ray:
    """A line of sight in base_link.

    Attributes
    ----------
    origin : ndarray, shape (3,)
        m.
    direction : ndarray, shape (3,)
        Unit vector.
    """

    origin: np.ndarray
    direction: np.ndarray

    def at_height(self, z: float) -> np.ndarray:
        """Where it meets a level plane (m); ValueError when it does not go there."""
        steps = (z - self.origin[2]) / self.direction[2] if self.direction[2] else -1.0
        if steps <= 0.0:
            raise ValueError(f"the line of sight does not meet the plane at {z:g} m")
        return self.origin + steps * self.direction


def find(image: np.ndarray, color: VividColor, least: float = 40.0) -> Optional[Blob]:
    """Find the largest thing of a colour.

    Parameters
    ----------
    image : ndarray, shape (height, width, 3), uint8
        Blue, green, red.
    least : float
        Area (pixels) of what counts.
    """
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    hue = 2.0 * hsv[..., 0].astype(np.float32)  # OpenCV's is half of the degrees
    off = np.abs((hue - color.hue + 180.0) % 360.0 - 180.0)
    mask = (
        (off <= color.tolerance)
        & np.greater_equal(hsv[..., 1], 255.0 * color.saturation)
        & np.greater_equal(hsv[..., 2], 255.0 * color.value)
    ).astype(np.uint8)
    # Single pixels are the sensor's noise.
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    hull = cv2.convexHull(max(contours, key=cv2.contourArea)).reshape(-1, 2)
    area = cv2.contourArea(hull)
    if area < least:
        return None
    height, width = image.shape[:2]
    left, top, wide, tall = cv2.boundingRect(hull)
    return Blob(
        hull,
        area,
        _centroid(hull),
        left > 0 and top > 0 and left + wide < width and top + tall < height,
    )


def ray(view: SeenPicture, pixel: Sequence[float]) -> Ray:
    """Return the line of sight of a pixel."""
    points = np.array([[pixel]], dtype=np.float64)
    x, y = cv2.undistortPoints(points, view.matrix, view.distortion).ravel()
    direction = view.pose[:3, :3] @ np.array([x, y, 1.0])
    return Ray(view.pose[:3, 3].copy(), direction / np.linalg.norm(direction))


def project(view: SeenPicture, points: np.ndarray) -> np.ndarray:
    """Return where points of base_link, shape (n, 3), lie in a picture, shape (n, 2)."""
    rotation = view.pose[:3, :3].T
    turn, _ = cv2.Rodrigues(rotation)
    pixels, _ = cv2.projectPoints(
        np.asarray(points, dtype=np.float64),
        turn,
        -rotation @ view.pose[:3, 3],
        view.matrix,
        view.distortion,
    )
    return pixels.reshape(-1, 2)


def cube_place(
    view: SeenPicture, blob: Blob, height: float, edge: float
) -> Tuple[np.ndarray, float, float]:
    """Tell where a cube is that lies flat at a known height, and how it is turned.

    Its outline is compared with those that such a cube would have. From above the camera sees
    little but the top: the middle of the outline is not the picture of the cube's middle.

    Parameters
    ----------
    blob : Blob
        The cube in it, all of it.
    height : float
        Of the cube's middle, in base_link (m).
    edge : float
        m.

    Returns
    -------
    center : ndarray, shape (3,)
        In base_link (m).
    yaw : float
        Of one of its edges (rad), from -pi/4 to pi/4.
    overlap : float
        Of the two outlines: intersection over union, 0 to 1.
    """
    # What lies further out than this overlaps with neither outline.
    low = blob.hull.min(axis=0) - _MARGIN
    width, depth = (blob.hull.max(axis=0) + _MARGIN - low).tolist()
    shape = (int(depth), int(width))
    seen = _filled(shape, blob.hull - low)
    corners = 0.5 * edge * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    yaws = np.radians(np.arange(-45.0, 45.0, 1.5))
    target = ray(view, blob.center).at_height(height)
    center, yaw, overlap = target, 0.0, 0.0

    def outline(angle: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        turned = corners @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        hull = cv2.convexHull(project(view, center + turned).astype(np.float32))
        return np.asarray(hull.reshape(-1, 2))

    for _ in range(_ROUNDS):
        scores = []
        for angle in yaws:
            drawn = _filled(shape, outline(angle) - low)
            scores.append(float((seen & drawn).sum() / max(1, (seen | drawn).sum())))
        best = int(np.argmax(scores))
        yaw, overlap = float(yaws[best]), scores[best]
        for _ in range(_ROUNDS):
            center = center + target - ray(view, _centroid(outline(yaw))).at_height(height)
    return center, yaw, overlap


def _centroid(hull: np.ndarray) -> Tuple[float, float]:
    moments = cv2.moments(hull)
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]


def _filled(shape: Tuple[int, ...], hull: np.ndarray) -> np.ndarray:
    mask = np.zeros(shape, dtype=np.uint8)
    cv2.fillConvexPoly(mask, np.round(hull).astype(np.int32).reshape(-1, 1, 2), (1,))
    return mask.astype(bool)
