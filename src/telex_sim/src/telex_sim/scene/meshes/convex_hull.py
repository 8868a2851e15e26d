"""Convex hulls of point clouds, small enough for collision detection.

The hull grows point by point (the incremental algorithm; de Berg et al., Computational Geometry,
chapter 11), taking the point that lies farthest outside each time, as Quickhull does.
"""

from __future__ import annotations

from typing import Tuple

import numpy as np

MOST_VERTICES = 200
"""Of a hull; one with more is left at those that lie farthest out."""
_FLAT = 1e-6
"""Thickness of a body, as a share of its size, below which it counts as flat."""
_OUTSIDE = 1e-6
"""What lies no farther outside than this share of the size counts as inside."""
_JOGGLE = 1e-7
"""Points are moved by up to this share of the size, so that no four of them lie in one plane.

Where they do, rounding decides which faces a new point sees, and the hull can fold over itself.
Far above the rounding of a double, far below what counts.
"""


class FlatError(ValueError):
    """The points enclose no volume."""


def convex_hull(points: np.ndarray) -> np.ndarray:
    """Triangles of the convex hull.

    Parameters
    ----------
    points : numpy.ndarray
        Shape (N, 3).

    Returns
    -------
    numpy.ndarray
        Corners of the triangles, shape (M, 3, 3), counter-clockwise seen from outside.

    Raises
    ------
    FlatError
    """
    points = np.asarray(points, dtype=np.float64)
    return points[_triangles(points)]


def _triangles(points: np.ndarray) -> np.ndarray:
    """Corner indices of the hull's triangles, shape (M, 3)."""
    first = _first_tetrahedron(points)
    size = float(np.ptp(points, axis=0).max())
    joggle = np.random.default_rng(0).uniform(-_JOGGLE, _JOGGLE, points.shape)
    points = points - points[first[0]] + size * joggle
    inside = points[list(first)].mean(axis=0)
    a, b, c, d = first
    faces = _outward(points, np.array([[a, b, c], [a, b, d], [a, c, d], [b, c, d]]), inside)
    normals, offsets = _planes(points, faces)
    farthest, heights = _farthest(points, normals, offsets)
    for _ in range(MOST_VERTICES - len(first)):
        face = int(np.argmax(heights))
        if heights[face] <= _OUTSIDE * size:
            break
        new = farthest[face]
        hidden = normals @ points[new] - offsets <= 0.0
        cone = _cone(faces[~hidden], new)
        planes = _planes(points, cone)
        faces = np.concatenate([faces[hidden], cone])
        normals = np.concatenate([normals[hidden], planes[0]])
        offsets = np.concatenate([offsets[hidden], planes[1]])
        # What lies beyond the other faces is known already.
        outside = _farthest(points, *planes)
        farthest = np.concatenate([farthest[hidden], outside[0]])
        heights = np.concatenate([heights[hidden], outside[1]])
    return faces


def _farthest(
    points: np.ndarray, normals: np.ndarray, offsets: np.ndarray
) -> Tuple[np.ndarray, np.ndarray]:
    """The point farthest outside each plane, and how far it lies outside."""
    rows = np.arange(len(normals))
    heights = normals @ points.T
    farthest = heights.argmax(axis=1)
    return farthest, heights[rows, farthest] - offsets


def _cone(visible: np.ndarray, apex: int) -> np.ndarray:
    """Triangles from the rim of the visible faces to the new point."""
    edges = np.concatenate([visible[:, [0, 1]], visible[:, [1, 2]], visible[:, [2, 0]]])
    known = {(int(a), int(b)) for a, b in edges}
    rim = [(int(a), int(b)) for a, b in edges if (int(b), int(a)) not in known]
    return np.array([(a, b, apex) for a, b in rim], dtype=np.intp)


def _first_tetrahedron(points: np.ndarray) -> tuple:
    """Four points that span a volume."""
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if len(points) < 4 or size <= 0.0:
        raise FlatError("its points enclose no volume")
    a = int(np.argmin(points[:, np.argmax(np.ptp(points, axis=0))]))
    offsets = points - points[a]
    b = int(np.argmax(np.einsum("ij,ij->i", offsets, offsets)))
    line = offsets[b] / np.linalg.norm(offsets[b])
    away = offsets - np.outer(offsets @ line, line)
    c = int(np.argmax(np.einsum("ij,ij->i", away, away)))
    normal = np.cross(line, away[c])
    length = float(np.linalg.norm(normal))
    if length < _FLAT * size:
        raise FlatError("its points lie on a line and enclose no volume")
    heights = offsets @ (normal / length)
    d = int(np.argmax(np.abs(heights)))
    if abs(heights[d]) < _FLAT * size:
        raise FlatError("it is flat and encloses no volume")
    return a, b, c, d


def _outward(points: np.ndarray, faces: np.ndarray, inside: np.ndarray) -> np.ndarray:
    normals, offsets = _planes(points, faces)
    wrong = normals @ inside > offsets
    faces[wrong] = faces[wrong][:, ::-1]
    return faces


def _planes(points: np.ndarray, faces: np.ndarray) -> tuple:
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(lengths, 1e-300)[:, None]
    return normals, np.einsum("ij,ij->i", normals, corners[:, 0])
