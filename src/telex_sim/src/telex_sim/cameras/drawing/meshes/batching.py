"""Groups of visuals that are drawn together, and their common mesh.

A draw call costs as much as some hundred triangles. What is fixed to the same frame and has the
same texture needs only one; colours stand at the vertices.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.matrices import pose_matrices

from ....scene.meshes.meshes import Mesh, primitive_mesh
from ....scene.meshes.texture_mapping import box_mapped
from ....scene.visual_scene import WORLD, Visual, VisualShape

# What is fixed to one frame is drawn in pieces of about this size (m): what a view cannot see of a
# hall is then left out, and the near hides the far.
CHUNK_SIZE = 4.0

# Shorter side of what things stand on (m).
_LEAST_GROUND = 0.2

VERTEX = np.dtype([("position", "f4", 3), ("normal", "f4", 3), ("color", "u1", 4), ("uv", "f4", 2)])
"""A vertex: position and normal in the frame, sRGB with glow in place of alpha, and texture."""


class BatchPart(NamedTuple):
    """A visual with its mesh; the mesh is in the visual's own coordinates, scale included."""

    visual: Visual
    mesh: Mesh


@dataclass(frozen=True)
class Batch:
    """Visuals that are drawn together.

    Attributes
    ----------
    visuals
        All of one frame, with the same texture.
    """

    visuals: Tuple[Visual, ...]

    @property
    def frame(self) -> str:
        """Name of the frame that they are fixed to."""
        return self.visuals[0].frame

    @property
    def texture(self) -> str:
        """Address of their texture, or empty."""
        return self.visuals[0].texture

    @property
    def opacity(self) -> float:
        """Alpha of their colour; below 1 there is one visual only."""
        return self.visuals[0].color[3]

    @property
    def drive(self) -> str:
        """Frame of the wheel that drives them as a belt; there is one visual only. Or empty."""
        return self.visuals[0].drive

    @property
    def carries(self) -> bool:
        """Whether things can stand on one of them: on floors, tables, steps, not on walls.

        What stands fast and carries has a texture, but for the plainest of floors.
        """
        return any(
            visual.shape is VisualShape.PLANE
            or (
                bool(visual.texture)
                and visual.shape is VisualShape.BOX
                and min(visual.size[:2]) > _LEAST_GROUND
            )
            for visual in self.visuals
        )

    @property
    def casts_shadow(self) -> bool:
        """Whether they belong in the shadow map."""
        return self.visuals[0].casts_shadow

    @cached_property
    def content(self) -> Tuple[Visual, ...]:
        """What tells its mesh from others: the same for frames that move with the same visuals.

        Belts run each on its own.
        """
        if self.drive or self.frame == WORLD:
            return self.visuals
        return tuple(replace(visual, frame="") for visual in self.visuals)


def batches(visuals: Iterable[Visual], radius_of: Callable[[Visual], float]) -> List[Batch]:
    """Group visuals.

    Parameters
    ----------
    visuals
        Those of a scene, in any order.
    radius_of
        Of a sphere around a visual's origin that holds it (m).
    """
    groups: Dict[Tuple, List[Visual]] = defaultdict(list)
    singles: List[Batch] = []
    for visual in visuals:
        if visual.color[3] < 1.0 or visual.drive:
            # The transparent have to be drawn in the order of distance.
            singles.append(Batch((visual,)))
        else:
            groups[visual.frame, visual.texture, visual.casts_shadow].append(visual)
    found: List[Batch] = []
    for group in groups.values():
        found += [Batch(tuple(chunk)) for chunk in _chunks(group, radius_of)]
    return found + singles


def _chunks(
    visuals: Sequence[Visual], radius_of: Callable[[Visual], float]
) -> Iterable[Sequence[Visual]]:
    """Cut what is spread widely into cells; what is itself larger than a cell stands alone."""
    positions = np.array([visual.position for visual in visuals])
    radii = np.array([radius_of(visual) for visual in visuals])
    low, high = (positions - radii[:, None]).min(axis=0), (positions + radii[:, None]).max(axis=0)
    if (high - low).max() <= 1.5 * CHUNK_SIZE:
        return [visuals]
    cells: Dict[Tuple[int, ...], List[Visual]] = defaultdict(list)
    alone: List[Sequence[Visual]] = []
    for visual, position, radius in zip(visuals, positions, radii):
        if radius > 0.5 * CHUNK_SIZE:
            alone.append([visual])
        else:
            cells[tuple(np.floor(position / CHUNK_SIZE).astype(int))].append(visual)
    return [*cells.values(), *alone]


def merge_visuals(
    visuals: Sequence[Visual], files: Sequence[Optional[Mesh]], worn: bool = False
) -> Tuple[np.ndarray, np.ndarray]:
    """Make one mesh of visuals, as `merge` does.

    Parameters
    ----------
    visuals
        Of one frame.
    files
        For each of them what its file contains, or None for a primitive.
    worn
        Whether boxes have rounded edges: what is handled has; of what stands about, nobody sees
        it, and there is much more of it.
    """
    return merge(
        [
            BatchPart(
                visual, primitive_mesh(visual, worn) if file is None else file.scaled(visual.size)
            )
            for visual, file in zip(visuals, files)
        ]
    )


def merge(parts: Sequence[BatchPart]) -> Tuple[np.ndarray, np.ndarray]:
    """Make one mesh of several.

    Returns
    -------
    tuple of two numpy.ndarray
        Vertices, shape (V,) of `VERTEX`, and triangles, shape (T, 3), int32.
    """
    vertices: List[np.ndarray] = []
    triangles: List[np.ndarray] = []
    first = 0
    for visual, plain in parts:
        frame_from_visual = pose_matrices(np.array([(*visual.position, *visual.orientation)]))[0]
        rotation, offset = frame_from_visual[:3, :3], frame_from_visual[:3, 3]
        mesh = _mapped(plain, visual, rotation.T @ offset) if visual.texture else plain
        part = np.zeros(len(mesh.positions), dtype=VERTEX)
        part["position"] = mesh.positions @ rotation.T + offset
        part["normal"] = mesh.normals @ rotation.T
        part["color"] = np.round(255.0 * np.array([*visual.color[:3], visual.glow]))
        if mesh.uvs is not None:
            part["uv"] = mesh.uvs
        vertices.append(part)
        triangles.append(mesh.triangles + np.int32(first))
        first += len(part)
    return np.concatenate(vertices), np.concatenate(triangles)


def _mapped(mesh: Mesh, visual: Visual, anchor: np.ndarray) -> Mesh:
    """Lay the texture on a mesh that brings no coordinates."""
    if mesh.uvs is not None:
        return mesh
    return box_mapped(mesh, anchor, visual.texture_scale)


def bounding_radius(visual: Visual, mesh_radius: Callable[[Visual], float]) -> float:
    """Radius of a sphere around the visual's origin that holds it (m)."""
    x, y, z = visual.size
    if visual.shape is VisualShape.MESH:
        return mesh_radius(visual)
    if visual.shape is VisualShape.SPHERE:
        return x
    if visual.shape is VisualShape.CYLINDER:
        return float(np.hypot(x, 0.5 * z))
    return 0.5 * float(np.linalg.norm((x, y, z if visual.shape is VisualShape.BOX else 0.0)))
