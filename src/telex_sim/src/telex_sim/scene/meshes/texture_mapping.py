"""Lays textures on meshes that have no texture coordinates of their own."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from .meshes import Mesh

# For the faces that look along x, y and z: which way the texture's right and top point for the side
# that looks along the axis. Seen from outside, pictures stand upright on the four sides.
_RIGHT = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
_TOP = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])


def box_mapped(mesh: Mesh, anchor: np.ndarray, texture_scale: float) -> Mesh:
    """Project a texture along the axis that each triangle faces most.

    Parameters
    ----------
    mesh
        Its own coordinates are replaced.
    anchor
        Where the mesh's origin lies in the frame that it is fixed to, along the mesh's axes (m),
        shape (3,): what lies side by side in one frame continues the same texture.
    texture_scale
        Length that one repetition covers (m); 0: the whole picture on each side of the mesh.

    Returns
    -------
    Mesh
        With texture coordinates; vertices on the edge between two sides are doubled.
    """
    mesh, axis, side = _split_by_side(mesh)
    right = _RIGHT[axis] * side[:, None]
    # The underside is seen with the same edge on top as the upper one.
    top = _TOP[axis]
    positions = mesh.positions.astype(np.float64)
    if texture_scale:
        placed = positions + anchor
        uvs = np.column_stack([_along(placed, right), _along(placed, top)]) / texture_scale
    else:
        low, high = positions.min(axis=0), positions.max(axis=0)
        share = (positions - 0.5 * (low + high)) / np.maximum(high - low, 1e-12)
        uvs = 0.5 + np.column_stack([_along(share, right), _along(share, top)])
    return Mesh(mesh.positions, mesh.normals, uvs.astype(np.float32), mesh.triangles)


def _split_by_side(mesh: Mesh) -> Tuple[Mesh, np.ndarray, np.ndarray]:
    """Give each vertex to triangles of one side alone; also the side's axis and sign."""
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(faces).argmax(axis=1)
    sign = faces[np.arange(len(faces)), axis] > 0.0
    key = mesh.triangles.astype(np.int64) * 6 + (2 * axis + sign)[:, None]
    kept, triangles = np.unique(key, return_inverse=True)
    vertex, side = np.divmod(kept, 6)
    split = Mesh(
        mesh.positions[vertex],
        mesh.normals[vertex],
        None,
        triangles.reshape(-1, 3).astype(np.int32),
    )
    return split, side // 2, np.where(side % 2, 1.0, -1.0)


def _along(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", points, directions)
