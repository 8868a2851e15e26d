"""Coarser meshes, for shadows and for small pictures."""

from __future__ import annotations

from typing import Tuple

import numpy as np

# Cells' borders avoid zero and round numbers, where rounding would part points in the same place.
_OFF_GRID = 0.3819

# Into so many parts along each side a texture is cut, whose vertices are not merged.
_PARTS = 16.0


def simplified(
    positions: np.ndarray, triangles: np.ndarray, detail: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Merge what lies in the same cell of a grid.

    This is vertex clustering (J. Rossignac, P. Borrel, "Multi-resolution 3D approximations for
    rendering complex scenes", 1993).

    Parameters
    ----------
    positions
        Shape (V, 3) (m).
    triangles
        Shape (T, 3).
    detail
        Edge of the cells (m): nothing moves further than its diagonal. 0 merges only what is in
        the same place.

    Returns
    -------
    tuple of two numpy.ndarray
        Positions, shape (W, 3), float32, and triangles, shape (U, 3), int32; those that have
        collapsed or come twice are gone. What would vanish altogether stays as it is.
    """
    # Without a grid, the bits of the numbers tell points apart.
    cells = np.floor(positions / detail).astype(np.int32) if detail else positions
    first, cluster = _groups(cells)
    merged = _means(positions, cluster) if detail else positions[first]
    kept = _distinct(cluster[triangles])
    if not len(kept):
        # All of it is smaller than a cell.
        return positions.astype(np.float32), triangles.astype(np.int32)
    return merged.astype(np.float32), kept.astype(np.int32)


def coarser(
    vertices: np.ndarray, triangles: np.ndarray, detail: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Merge vertices in the same cell of a grid that face about the same way in the same colour.

    Parameters
    ----------
    vertices
        Shape (V,), of `batching.VERTEX`. A texture moves with them.
    triangles, detail
        As for `simplified`; above 0.

    Returns
    -------
    tuple of two numpy.ndarray
        Vertices and triangles, shapes (W,) and (U, 3), as they came. No gaps open: all vertices of
        a cell are in the same place. What would vanish altogether stays as it is.
    """
    positions, normals = vertices["position"], vertices["normal"]
    _, cell = _groups(np.floor(positions / detail + _OFF_GRID).astype(np.int32))
    sides = np.round(normals).astype(np.int32)
    # Where a texture begins anew, neighbours lie far apart in it.
    places = np.round(_PARTS * vertices["uv"]).astype(np.int32)
    alike = np.column_stack([cell, sides, vertices["color"].astype(np.int32), places])
    first, cluster = _groups(alike)
    corners = cell[triangles]
    a, b, c = corners.T
    kept = _distinct(cluster[triangles[(a != b) & (b != c) & (c != a)]])
    if not len(kept):
        return vertices, triangles
    merged = vertices[first].copy()
    merged["position"] = _means(positions, cell)[cell[first]]
    merged["uv"] = _means(vertices["uv"], cluster)
    means = _means(normals, cluster)
    sizes = np.linalg.norm(means, axis=1, keepdims=True)
    merged["normal"] = np.where(sizes > 1e-3, means / np.maximum(sizes, 1e-3), normals[first])
    return merged, kept.astype(np.int32)


def _groups(rows: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """First of the equal rows, shape (W,), and the group of each row, shape (V,)."""
    _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, group.reshape(-1)


def _means(vectors: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Mean of the vectors of each group."""
    count = np.bincount(group)
    return np.stack([np.bincount(group, column) / count for column in vectors.T], axis=1)


def _distinct(triangles: np.ndarray) -> np.ndarray:
    """Triangles with three corners, each once."""
    a, b, c = triangles.T
    kept = triangles[(a != b) & (b != c) & (c != a)]
    # The same corner first, so that equal triangles are equal rows; the winding stays.
    turn = kept.argmin(axis=1)[:, None]
    return np.unique(np.take_along_axis(kept, (np.arange(3) + turn) % 3, axis=1), axis=0)
