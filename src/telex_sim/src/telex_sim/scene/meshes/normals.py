"""Meshes from loose triangles: normals smoothed by angle, equal vertices merged."""

from __future__ import annotations

import math
from typing import Optional, Tuple

import numpy as np

from .meshes import Mesh

# Facets that meet at less than this look round, at more they keep their edge (rad).
CREASE_ANGLE = math.radians(40.0)


def mesh_from_corners(
    corners: np.ndarray, normals: Optional[np.ndarray], uvs: Optional[np.ndarray]
) -> Mesh:
    """Make a mesh with shared vertices from triangles that share none.

    Parameters
    ----------
    corners
        Shape (T, 3, 3): three points per triangle. Triangles without area are dropped.
    normals
        Shape (T, 3, 3), or None to compute them by angle.
    uvs
        Shape (T, 3, 2), or None.

    Raises
    ------
    ValueError
        When a point is not finite, or no triangle has an area.
    """
    if not np.isfinite(corners).all():
        raise ValueError("a vertex is not finite")
    face_normals, keep = _face_normals(corners)
    if not keep.any():
        raise ValueError("there is no triangle with an area")
    corners, face_normals = corners[keep], face_normals[keep]
    if normals is None:
        normals = _smoothed(corners, face_normals)
    else:
        normals = _unit_or(normals[keep], face_normals)
    positions, normals = corners.reshape(-1, 3), normals.reshape(-1, 3)
    keys = [_rounded(positions), np.round(normals * 1e4)]
    if uvs is not None:
        keys.append(np.round(uvs[keep].reshape(-1, 2) * 1e5))
    first, vertex = _merge_rows(np.hstack(keys).astype(np.int64))
    return Mesh(
        positions[first].astype(np.float32),
        normals[first].astype(np.float32),
        None if uvs is None else uvs[keep].reshape(-1, 2)[first].astype(np.float32),
        vertex.reshape(-1, 3).astype(np.int32),
    )


def _face_normals(corners: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Return the triangles' unit normals, shape (T, 3), and which of them have an area."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(cross, axis=1)
    longest = np.max(np.abs(np.diff(corners[:, [0, 1, 2, 0]], axis=1)), axis=(1, 2), initial=0.0)
    keep = doubled > 1e-7 * longest * longest
    with np.errstate(divide="ignore", invalid="ignore"):
        return cross / doubled[:, None], keep


def _unit_or(normals: np.ndarray, face_normals: np.ndarray) -> np.ndarray:
    """Scale normals to length 1, and take the face's own where a file gives none of use."""
    lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    usable = np.isfinite(lengths) & (lengths > 1e-6)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(usable, normals / lengths, face_normals[:, None, :])


def _smoothed(corners: np.ndarray, face_normals: np.ndarray) -> np.ndarray:
    """Compute the normal at each corner, shape (T, 3, 3).

    It is the mean over the facets at the same point that turn from the corner's own by less than
    the crease angle, weighted by their angle at the point, so that the way in which a surface is
    cut into triangles does not show.
    """
    _, vertex = _merge_rows(_rounded(corners.reshape(-1, 3)))
    own = np.repeat(face_normals, 3, axis=0)
    weighted = own * _corner_angles(corners).reshape(-1, 1)
    # Corners at the same point stand together; each is compared with the one `step` places
    # further round its group, which needs no list of all pairs.
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    place = np.empty(len(vertex), dtype=np.intp)
    place[order] = np.arange(len(vertex)) - np.repeat(starts, counts)
    limit = math.cos(CREASE_ANGLE)
    total = weighted.copy()
    active = np.arange(len(vertex))
    for step in range(1, int(counts.max())):
        active = active[counts[vertex[active]] > step]
        group = vertex[active]
        other = order[starts[group] + (place[active] + step) % counts[group]]
        near = np.einsum("ij,ij->i", own[active], own[other]) > limit
        total[active[near]] += weighted[other[near]]
    return (total / np.linalg.norm(total, axis=1, keepdims=True)).reshape(-1, 3, 3)


def _corner_angles(corners: np.ndarray) -> np.ndarray:
    """Angle of each triangle at each of its corners (rad), shape (T, 3)."""
    to_next = np.roll(corners, -1, axis=1) - corners
    to_next /= np.linalg.norm(to_next, axis=2, keepdims=True)
    to_previous = -np.roll(to_next, 1, axis=1)
    cosines = np.einsum("tci,tci->tc", to_next, to_previous)
    return np.arccos(np.clip(cosines, -1.0, 1.0))


def _rounded(points: np.ndarray) -> np.ndarray:
    """Points on a grid so fine that only what was meant to be one point falls together."""
    extent = float(np.max(points.max(axis=0) - points.min(axis=0)))
    return np.round(points / (1e-6 * extent))


def _merge_rows(rows: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Where each distinct row comes first, and for each row the number of its like."""
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, inverse.reshape(-1)
