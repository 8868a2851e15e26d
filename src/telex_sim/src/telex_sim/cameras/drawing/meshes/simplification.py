"""Coarser meshes, for shadows and for small pictures."""

from __future__ import annotations

from typing import Tuple

import numpy as np

# Cells' borders avoid zero and round numbers, where rounding would part points in the same place.
_OFF_GRID = 0.3819

# Planes that are turned by less than about the root of this say nothing across them.
_FLAT = 0.02

# Parts of so many triangles (times metres of detail: the coarser, the fewer) are not simplified,
# unless they are no larger than so many cells.
_FEW, _DOT = 1.0, 4.0

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

    They meet where they leave the planes of their triangles least (P. Lindstrom, "Out-of-core
    simplification of large polygonal models", 2000): what is flat stays flat, and paint that lies
    on a plate stays before it.

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
    grid = np.floor(positions / detail + _OFF_GRID).astype(np.int32)
    simple = _simple(positions, triangles, detail)
    _, cell = _groups(np.column_stack([grid, np.where(simple, 1 + np.arange(len(simple)), 0)]))
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
    merged["position"] = _meeting_points(positions, triangles, cell, detail)[cell[first]]
    merged["uv"] = _means(vertices["uv"], cluster)
    means = _means(normals, cluster)
    sizes = np.linalg.norm(means, axis=1, keepdims=True)
    merged["normal"] = np.where(sizes > 1e-3, means / np.maximum(sizes, 1e-3), normals[first])
    return merged, kept.astype(np.int32)


def _meeting_points(
    positions: np.ndarray, triangles: np.ndarray, cell: np.ndarray, detail: float
) -> np.ndarray:
    """Point of each cell that is nearest to the planes of the triangles that reach into it.

    Directions in which these say nothing keep the mean of the cell's vertices; nothing comes to
    lie further from that than the edge of a cell, ``detail``.
    """
    means = _means(positions, cell)
    a, b, c = (positions[corner].astype(np.float64) for corner in triangles.T)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, 1e-12)[:, None]
    planes, pulls = np.zeros((len(means), 9)), np.zeros((len(means), 3))
    outer = (areas[:, None, None] * normals[:, :, None] * normals[:, None, :]).reshape(-1, 9)
    for corner in triangles.T:
        at = cell[corner]
        off = areas * np.einsum("ij,ij->i", normals, a - means[at])
        planes += _sums(outer, at, len(means))
        pulls += _sums(off[:, None] * normals, at, len(means))
    values, axes = np.linalg.eigh(planes.reshape(-1, 3, 3))
    along = np.einsum("nij,ni->nj", axes, pulls)
    told = values > _FLAT * np.maximum(values[:, -1:], 1e-12)
    along = np.where(told, along / np.where(told, values, 1.0), 0.0)
    moved = np.einsum("nij,nj->ni", axes, along)
    lengths = np.linalg.norm(moved, axis=1, keepdims=True)
    return means + moved * np.minimum(1.0, detail / np.maximum(lengths, 1e-12))


def _simple(positions: np.ndarray, triangles: np.ndarray, detail: float) -> np.ndarray:
    """Which vertices belong to a part of few triangles that is no mere dot, shape (V,), bool.

    To merge these would save little, and would press what is thin, such as paint or a plate, into
    what it lies on.
    """
    _, corner = _groups(positions)
    _, part = np.unique(
        _parts(corner[triangles], int(corner.max()) + 1)[corner], return_inverse=True
    )
    count = np.bincount(part[triangles[:, 0]], minlength=int(part.max()) + 1)
    order = np.argsort(part, kind="stable")
    begins = np.searchsorted(part[order], np.arange(len(count)))
    low, high = (reduce.reduceat(positions[order], begins) for reduce in (np.minimum, np.maximum))
    large = (high - low).max(axis=1) > _DOT * detail
    found: np.ndarray = ((count * detail <= _FEW) & large)[part]
    return found


def _parts(triangles: np.ndarray, count: int) -> np.ndarray:
    """Number of the connected part that each of so many vertices belongs to, shape (count,)."""
    part = np.arange(count)
    while True:
        before = part.copy()
        least = part[triangles].min(axis=1)
        for corner in triangles.T:
            np.minimum.at(part, corner, least)
        part = part[part]
        if np.array_equal(part, before):
            return part


def _groups(rows: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """First of the equal rows, shape (W,), and the group of each row, shape (V,)."""
    _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, group.reshape(-1)


def _means(vectors: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Mean of the vectors of each group."""
    return _sums(vectors, group, int(group.max()) + 1) / np.bincount(group)[:, None]


def _sums(vectors: np.ndarray, group: np.ndarray, count: int) -> np.ndarray:
    """Sum of the vectors of each of so many groups."""
    return np.stack([np.bincount(group, column, count) for column in vectors.T], axis=1)


def _distinct(triangles: np.ndarray) -> np.ndarray:
    """Triangles with three corners, each once."""
    a, b, c = triangles.T
    kept = triangles[(a != b) & (b != c) & (c != a)]
    # The same corner first, so that equal triangles are equal rows; the winding stays.
    turn = kept.argmin(axis=1)[:, None]
    return np.unique(np.take_along_axis(kept, (np.arange(3) + turn) % 3, axis=1), axis=0)
