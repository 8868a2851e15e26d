"""Convex hulls of point clouds, small enough for collision detection.

The hull grows point by point (the incremental algorithm; de Berg et al., Computational Geometry,
chapter 11), taking the point that lies farthest outside each time, as Quickhull does.
"""

from __future__ import annotations

import math

import numpy as np

MOST_VERTICES = 200
"""Of a hull; one with more is replaced by its extreme points in evenly spread directions."""
_FLAT = 1e-6
"""Thickness of a body, as a share of its size, below which it counts as flat."""


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
    points = _extreme(points, _directions(2048))
    if len(points) > MOST_VERTICES:
        points = _extreme(points, _directions(MOST_VERTICES))
    return points[_triangles(points)]


def _directions(count: int) -> np.ndarray:
    """Unit vectors spread evenly (a Fibonacci lattice), and the six along the axes."""
    index = np.arange(count - 6) + 0.5
    z = 1.0 - 2.0 * index / (count - 6)
    angle = index * math.pi * (3.0 - math.sqrt(5.0))
    radius = np.sqrt(1.0 - z * z)
    spread = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    return np.concatenate([np.eye(3), -np.eye(3), spread])


def _extreme(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The points that lie farthest in one of the directions."""
    if len(points) <= len(directions):
        return points
    best = np.empty(len(directions), dtype=np.intp)
    for begin in range(0, len(directions), 64):  # bounds the memory of the product
        part = slice(begin, begin + 64)
        best[part] = np.argmax(directions[part] @ points.T, axis=1)
    return points[np.unique(best)]


def _triangles(points: np.ndarray) -> np.ndarray:
    """Corner indices of the hull's triangles, shape (M, 3)."""
    first = _first_tetrahedron(points)
    tolerance = _FLAT * 1e-3 * float(np.ptp(points, axis=0).max())
    inside = points[list(first)].mean(axis=0)
    a, b, c, d = first
    faces = _outward(points, np.array([[a, b, c], [a, b, d], [a, c, d], [b, c, d]]), inside)
    while True:
        normals, offsets = _planes(points, faces)
        heights = points @ normals.T - offsets
        farthest = heights.max(axis=1)
        new = int(np.argmax(farthest))
        if farthest[new] <= tolerance:
            return faces
        visible = heights[new] > tolerance * 0.5
        faces = np.concatenate([faces[~visible], _cone(faces[visible], new)])


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
