"""Belts that run: a mesh that moves along its own outline.

Seen along the wheels' axles (y of its frame), a belt is convex; its outline is the convex hull of
its vertices. Each vertex keeps its place beside the outline and is carried along it.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Optional, Tuple

import cv2
import numpy as np

# Longest edge, seen from the side: what is longer would cut the corners of the wheels (m).
_LONGEST_EDGE = 0.05

# Extent of a belt seen from the side (m); beyond, its mesh is most likely in another unit.
_SHORTEST, _LONGEST = 0.02, 10.0

# Vertices or triangles of a belt; more would take gigabytes, and long for each picture.
_MOST = 50_000

# Points of an outline.
_SAMPLES = 1024

# Of the outline, smoothed over so much to both sides, so that no cleat's tip is a corner (m).
_SMOOTHED = 0.012


class Outline(NamedTuple):
    """A closed curve in x and z, evenly sampled, in the direction of turning about +y.

    Attributes
    ----------
    points, tangents
        Shape (N, 2); tangents have length 1.
    length
        Of the whole curve (m).
    """

    points: np.ndarray
    tangents: np.ndarray
    length: float


class Carried(NamedTuple):
    """Vertices beside an outline.

    Attributes
    ----------
    sample
        Number of the outline's nearest point, shape (V,).
    offset
        From there, along the tangent and outwards (m), shape (V, 2).
    """

    sample: np.ndarray
    offset: np.ndarray


def belt_outline(positions: np.ndarray) -> Outline:
    """Find the outline of a belt's vertices, shape (V, 3) (m).

    Raises
    ------
    ValueError
        When they are no wider than a line.
    """
    flat = np.ascontiguousarray(positions[:, [0, 2]], dtype=np.float32)
    corners = cv2.convexHull(flat).reshape(-1, 2).astype(np.float64)
    following = np.roll(corners, -1, axis=0)
    area = 0.5 * float(np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]))
    if abs(area) < 1e-8:
        raise ValueError("a belt goes around wheels; this mesh is flat along y")
    # Turning about +y leads from z to x.
    if area > 0.0:
        corners = corners[::-1]
    points = _evenly(corners)
    spacing = np.linalg.norm(points[1] - points[0])
    reach = int(_SMOOTHED / spacing)
    for _ in range(2):
        points = np.mean([np.roll(points, k, axis=0) for k in range(-reach, reach + 1)], axis=0)
    points = _evenly(points)
    tangents = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    return Outline(points, tangents, float(steps.sum()))


def _evenly(corners: np.ndarray) -> np.ndarray:
    """Take points at equal distances on a closed polygon."""
    closed = np.vstack([corners, corners[:1]])
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    wanted = np.arange(_SAMPLES) * (passed[-1] / _SAMPLES)
    return np.stack([np.interp(wanted, passed, closed[:, axis]) for axis in range(2)], axis=1)


def carried(outline: Outline, positions: np.ndarray) -> Carried:
    """Find the places of vertices, shape (V, 3), beside an outline."""
    flat = positions[:, [0, 2]].astype(np.float64)
    squares = (
        np.square(flat).sum(axis=1)[:, None]
        - 2.0 * flat @ outline.points.T
        + np.square(outline.points).sum(axis=1)
    )
    sample = squares.argmin(axis=1)
    beside = flat - outline.points[sample]
    tangents = outline.tangents[sample]
    along = np.einsum("ij,ij->i", beside, tangents)
    return Carried(sample, np.stack([along, _outwards(beside, tangents)], axis=1))


class Riders:
    """Vertices that are carried along an outline.

    In the plane of x and z, points are complex numbers x + iz: to turn one is to multiply it.

    Parameters
    ----------
    positions, normals
        At rest, shape (V, 3); normals may be left out.
    """

    def __init__(
        self,
        outline: Outline,
        places: Carried,
        positions: np.ndarray,
        normals: Optional[np.ndarray] = None,
    ) -> None:
        points, tangents = _plane(outline.points), _plane(outline.tangents)
        self._points, self._tangents = _twice(points), _twice(tangents)
        self._length = outline.length
        self._sample = places.sample
        self._offset = _plane(places.offset).astype(np.complex64)
        self._positions = np.array(positions, dtype=np.float32)
        self._normals = None if normals is None else np.array(normals, dtype=np.float32)
        if normals is not None:
            # As they would be where the tangent is along x.
            self._upright = (_plane(normals[:, [0, 2]]) * tangents[places.sample].conj()).astype(
                np.complex64
            )

    def at(self, travel: float) -> Tuple[np.ndarray, Optional[np.ndarray]]:
        """Carry them so far (m) from their rest.

        Returns
        -------
        tuple of numpy.ndarray
            Positions and, if there are any, normals; shape (V, 3), float32. They hold until the
            next call.
        """
        shift = (travel / self._length) % 1.0 * _SAMPLES
        whole = int(shift)
        points, tangents = (
            _between(curve, whole, shift - whole) for curve in (self._points, self._tangents)
        )
        tangents /= np.abs(tangents)
        tangent, place = tangents[self._sample], points[self._sample]
        place += self._offset * tangent
        self._positions[:, 0], self._positions[:, 2] = place.real, place.imag
        if self._normals is not None:
            tangent *= self._upright
            self._normals[:, 0], self._normals[:, 2] = tangent.real, tangent.imag
        return self._positions, self._normals


def _plane(vectors: np.ndarray) -> np.ndarray:
    """Complex numbers of vectors (x, z), shape (N, 2)."""
    return vectors[:, 0] + 1j * vectors[:, 1]


def _twice(curve: np.ndarray) -> np.ndarray:
    """Go around a closed curve twice, so that each shift of it is a part."""
    return np.concatenate([curve, curve, curve[:1]]).astype(np.complex64)


def _between(twice: np.ndarray, whole: int, part: float) -> np.ndarray:
    """Shift a closed curve by whole samples and part of one."""
    here, following = (twice[first : first + _SAMPLES] for first in (whole, whole + 1))
    return here + np.float32(part) * (following - here)


def _outwards(beside: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    # Left of the tangent, as x and z lie in a side view, is outside.
    return tangents[:, 0] * beside[:, 1] - tangents[:, 1] * beside[:, 0]


def wheel_radius(outline: Outline, axle: np.ndarray) -> float:
    """Radius at which a wheel drives the belt: from its axle (x, z), shape (2,), to the outline."""
    beside = axle - outline.points
    return float(np.abs(_outwards(beside, outline.tangents)).min())


def belt_angle(belt_in_world: np.ndarray, wheel_in_world: np.ndarray) -> float:
    """Angle by which a wheel has turned about y in the belt's frame (rad); shapes (4, 4)."""
    wheel_in_belt = belt_in_world[:3, :3].T @ wheel_in_world[:3, :3]
    return math.atan2(wheel_in_belt[0, 2], wheel_in_belt[0, 0])


def subdivided(vertices: np.ndarray, triangles: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Halve edges that are too long to run around a wheel.

    Parameters
    ----------
    vertices
        Shape (V,), of `batching.VERTEX`.
    triangles
        Shape (T, 3).

    Returns
    -------
    tuple of two numpy.ndarray
        More vertices and triangles. Both sides of an edge halve it at the same point, so that no
        gaps open.

    Raises
    ------
    ValueError
        When a belt cannot have this extent, or not so many vertices or triangles.
    """
    extent = float(np.ptp(vertices["position"][:, [0, 2]], axis=0).max())
    if not _SHORTEST <= extent <= _LONGEST:
        raise ValueError(
            f"its mesh extends over {extent:.3g} m; {_SHORTEST:g} to {_LONGEST:g} m is possible"
        )
    while True:
        if max(len(vertices), len(triangles)) > _MOST:
            raise ValueError(
                f"with no edge above {_LONGEST_EDGE:g} m, its mesh has {len(triangles)} triangles"
                f" and {len(vertices)} vertices or more; {_MOST} of each are possible"
            )
        flat = vertices["position"][triangles][:, :, [0, 2]]
        lengths = np.linalg.norm(np.roll(flat, -1, axis=1) - flat, axis=2)
        longest = lengths.argmax(axis=1)
        long = np.flatnonzero(lengths.max(axis=1) > _LONGEST_EDGE)
        if not len(long):
            return vertices, triangles
        # The longest edge first: from a to b, c opposite.
        corner = longest[long][:, None]
        a, b, c = np.take_along_axis(triangles[long], (np.arange(3) + corner) % 3, axis=1).T
        ends = np.unique(np.sort(np.stack([a, b], axis=1), axis=1), axis=0, return_inverse=True)
        first, second = ends[0].T
        middle = vertices[first].copy()
        for name in ("position", "normal", "uv"):
            middle[name] = 0.5 * (vertices[name][first] + vertices[name][second])
        size = np.linalg.norm(middle["normal"], axis=1, keepdims=True)
        middle["normal"] = np.where(size > 1e-3, middle["normal"] / np.maximum(size, 1e-3), 0.0)
        new = len(vertices) + ends[1].reshape(-1)
        halves = [np.stack([a, new, c], axis=1), np.stack([new, b, c], axis=1)]
        kept = np.delete(triangles, long, axis=0)
        vertices = np.concatenate([vertices, middle])
        triangles = np.concatenate([kept, *halves]).astype(np.int32)
