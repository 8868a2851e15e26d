"""Triangle meshes, and those of the primitive shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

import numpy as np

from ..visual_scene import Vector3, Visual, VisualShape

# How far a facet may lie from the true surface of a round primitive (m).
_FACET_ERROR = 0.0005

# How much of a box's edges use takes away (m), and at most of its shortest side.
_ROUNDING, _MOST_ROUNDING = 0.003, 0.06


@dataclass(frozen=True)
class Mesh:
    """Triangles with a normal at every vertex; counter-clockwise seen from outside.

    Attributes
    ----------
    positions, normals
        Shape (V, 3), float32; normals have length 1.
    uvs
        Texture coordinates, shape (V, 2), float32; None where `texture_mapping` has to lay a
        texture on.
    triangles
        Shape (T, 3), int32.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: Optional[np.ndarray]
    triangles: np.ndarray

    def scaled(self, scale: Vector3) -> Mesh:
        """Stretch the mesh along its axes; a mirrored one keeps its outside."""
        factors = np.array(scale, dtype=np.float32)
        normals = self.normals / factors
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        mirrored = np.prod(factors) < 0.0
        triangles = self.triangles[:, ::-1] if mirrored else self.triangles
        return Mesh(self.positions * factors, normals.astype(np.float32), self.uvs, triangles)


def primitive_mesh(visual: Visual, worn: bool = False) -> Mesh:
    """Mesh of a box, sphere, cylinder or plane, of the visual's size (m).

    Round ones have texture coordinates, for the visual's texture_scale; flat ones have none.
    Boxes that are ``worn`` have rounded edges.
    """
    if visual.shape is VisualShape.BOX:
        return rounded_box_mesh(visual.size) if worn else box_mesh(visual.size)
    if visual.shape is VisualShape.SPHERE:
        return sphere_mesh(visual.size[0], visual.texture_scale)
    if visual.shape is VisualShape.CYLINDER:
        return cylinder_mesh(visual.size[0], visual.size[2], visual.texture_scale)
    if visual.shape is VisualShape.PLANE:
        return plane_mesh(visual.size[0], visual.size[1])
    raise ValueError(f"{visual.label} is no primitive")


def plane_mesh(length_x: float, length_y: float) -> Mesh:
    """Make a rectangle in the plane z = 0 around the origin, seen from above (m)."""
    corners = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])
    return _mesh(
        corners * (length_x, length_y, 0.0),
        np.tile((0.0, 0.0, 1.0), (4, 1)),
        None,
        np.array([(0, 1, 2), (0, 2, 3)]),
    )


def box_mesh(size: Vector3) -> Mesh:
    """Make a box around the origin with the full extents ``size`` (m)."""
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    positions = np.zeros((6, 4, 3))
    normals = np.zeros((6, 4, 3))
    for face, (axis, side) in enumerate((axis, side) for axis in range(3) for side in (-1, 1)):
        normal = side * np.eye(3)[axis]
        up = np.eye(3)[2 if axis < 2 else 1]
        # Sideways, up and the normal are right-handed.
        along = np.stack([np.cross(up, normal), up])
        positions[face] = (corners @ along + 0.5 * normal) * size
        normals[face] = normal
    triangles = 4 * np.arange(6)[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])
    return _mesh(positions.reshape(-1, 3), normals.reshape(-1, 3), None, triangles.reshape(-1, 3))


def rounded_box_mesh(size: Vector3) -> Mesh:
    """Make a box as `box_mesh` does, its edges broken.

    Narrow strips join the faces, at whose corners the normals stay the faces': they look round.
    """
    rounding = min(_ROUNDING, _MOST_ROUNDING * min(size))
    positions, normals = np.zeros((6, 4, 3)), np.zeros((6, 4, 3))
    number: Dict[Tuple[int, Tuple[int, ...]], int] = {}
    for face, (axis, side) in enumerate((axis, side) for axis in range(3) for side in (-1, 1)):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for corner, (a, b) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
            way = [0, 0, 0]
            way[axis], way[first], way[second] = side, a, b
            inset = np.full(3, rounding)
            inset[axis] = 0.0
            positions[face, corner] = np.array(way) * (0.5 * np.array(size) - inset)
            normals[face, corner, axis] = side
            number[axis, tuple(way)] = 4 * face + corner
    places = positions.reshape(-1, 3)
    triangles = []
    signs_of = sorted({signs for _, signs in number})
    for signs in signs_of:
        triangles.append([number[axis, signs] for axis in range(3)])
        for axis in range(3):
            # The edges along each axis, and the face across it, from one of their ends.
            if signs[axis] > 0:
                continue
            end = tuple(1 if place == axis else sign for place, sign in enumerate(signs))
            b, c = (axis + 1) % 3, (axis + 2) % 3
            quad = [number[b, signs], number[b, end], number[c, end], number[c, signs]]
            triangles += [quad[:3], [quad[0], quad[2], quad[3]]]
    triangles += [
        [4 * face + corner for corner in corners]
        for face in range(6)
        for corners in ((0, 1, 2), (0, 2, 3))
    ]
    corners = places[triangles]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside_out = np.einsum("ij,ij->i", outwards, corners.mean(axis=1)) < 0.0
    wound = np.array(triangles)
    wound[inside_out] = wound[inside_out][:, ::-1]
    return _mesh(places, normals.reshape(-1, 3), None, wound)


def sphere_mesh(radius: float, texture_scale: float = 1.0) -> Mesh:
    """Make a sphere around the origin (m); a texture goes round it from +x over +y."""
    around = _segments(radius)
    upwards = max(around // 2, 6)
    turn, height = np.meshgrid(
        np.linspace(0.0, 1.0, around + 1), np.linspace(0.0, 1.0, upwards + 1)
    )
    azimuth, polar = 2.0 * math.pi * turn, math.pi * (1.0 - height)
    normals = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    extents = (2.0 * math.pi * radius, math.pi * radius)
    uvs = np.stack([turn, height], axis=-1).reshape(-1, 2) * _repeats(extents, texture_scale)
    triangles = _grid_triangles(around + 1, upwards + 1)
    # The rows at the poles have triangles of no area.
    return _mesh(radius * normals, normals, uvs, _without_degenerate(radius * normals, triangles))


def cylinder_mesh(radius: float, length: float, texture_scale: float = 1.0) -> Mesh:
    """Make a cylinder around the origin, its axis along z (m).

    A texture goes round its side from +x over +y, and lies on its ends as seen from outside, its
    top towards +y.
    """
    around = _segments(radius)
    turn = np.linspace(0.0, 1.0, around + 1)
    azimuth = 2.0 * math.pi * turn
    circle = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    side_normals = np.hstack([circle, np.zeros((around + 1, 1))])
    rim = radius * circle
    positions, normals, uvs = [], [], []
    side_repeats = _repeats((2.0 * math.pi * radius, length), texture_scale)
    for height in (0.0, 1.0):
        at = np.full(around + 1, (height - 0.5) * length)
        positions.append(np.column_stack([rim, at]))
        normals.append(side_normals)
        uvs.append(np.column_stack([turn, np.full(around + 1, height)]) * side_repeats)
    triangles = [_grid_triangles(around + 1, 2)]
    disc = np.vstack([np.zeros((1, 2)), rim])
    for side in (-1.0, 1.0):
        first = sum(len(part) for part in positions)
        positions.append(np.column_stack([disc, np.full(len(disc), side * 0.5 * length)]))
        normals.append(np.tile((0.0, 0.0, side), (len(disc), 1)))
        seen = disc * (side, 1.0)
        uvs.append(seen / texture_scale if texture_scale else seen / (2.0 * radius) + 0.5)
        ring = np.arange(1, around + 1)
        fan = np.column_stack([np.zeros(around, dtype=int), ring, ring + 1])
        triangles.append(first + (fan if side > 0.0 else fan[:, ::-1]))
    return _mesh(
        np.concatenate(positions),
        np.concatenate(normals),
        np.concatenate(uvs),
        np.concatenate(triangles),
    )


def _repeats(extents: Tuple[float, float], texture_scale: float) -> Tuple[float, float]:
    """How often a texture fits round a surface and upwards.

    Round it, it fits a whole number of times, so that there is no seam where it closes.
    """
    if not texture_scale:
        return 1.0, 1.0
    return max(1.0, float(round(extents[0] / texture_scale))), extents[1] / texture_scale


def _segments(radius: float) -> int:
    """Choose into how many flat pieces a circle falls, for the facet error."""
    half_angle = math.acos(max(1.0 - _FACET_ERROR / radius, 0.0))
    return int(np.clip(math.ceil(math.pi / half_angle), 12, 48))


def _grid_triangles(columns: int, rows: int) -> np.ndarray:
    """Triangles of a grid of vertices; columns run anticlockwise around z, rows upwards."""
    column, row = np.meshgrid(np.arange(columns - 1), np.arange(rows - 1))
    first = (row * columns + column).reshape(-1)
    lower = np.column_stack([first, first + 1, first + columns + 1])
    upper = np.column_stack([first, first + columns + 1, first + columns])
    return np.concatenate([lower, upper])


def _without_degenerate(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return triangles[areas > 1e-9 * areas.max()]


def _mesh(
    positions: np.ndarray, normals: np.ndarray, uvs: Optional[np.ndarray], triangles: np.ndarray
) -> Mesh:
    return Mesh(
        positions.astype(np.float32),
        normals.astype(np.float32),
        None if uvs is None else uvs.astype(np.float32),
        np.ascontiguousarray(triangles, dtype=np.int32),
    )
