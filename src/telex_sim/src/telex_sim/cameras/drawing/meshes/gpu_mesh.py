"""A mesh in the memory of whatever renders."""

from __future__ import annotations

import math
from typing import Dict, Optional, Tuple

import moderngl
import numpy as np

from ....scene.content_store import ContentStore
from .belts import Carried, Riders, belt_angle, belt_outline, carried, subdivided, wheel_radius
from .simplification import coarser, simplified

# The fields of `batching.VERTEX` as OpenGL takes them: form, bytes, name.
_ATTRIBUTES = (
    ("3f", 12, "in_position"),
    ("3f", 12, "in_normal"),
    ("4f1", 4, "in_color"),
    ("2f", 8, "in_uv"),
)


# What is smaller need not show in small pictures while there is too little time (m), and what has
# fewer triangles is not worth it.
_COARSE_DETAIL, _COARSE_FROM = 0.01, 100

# What has fewer triangles throws its shadow as it is: to look a simpler shape up takes longer.
_SIMPLIFIED_FROM = 200


class GpuMesh:
    """A mesh, ready to be drawn by any of the programs.

    Parameters
    ----------
    vertices, triangles
        As `batching.merge` returns them.
    shadow_detail
        What is smaller need not show in shadows (m).

    Attributes
    ----------
    center, radius
        Bounding sphere in the frame that it is fixed to (m).
    half
        From its centre to the sides of the box around it, along the frame's axes (m).
    beyond
        How far it may come to reach beyond this box (m).
    """

    beyond = 0.0

    def __init__(
        self,
        context: moderngl.Context,
        vertices: np.ndarray,
        triangles: np.ndarray,
        shadow_detail: float,
        store: ContentStore,
    ) -> None:
        self._context = context
        self._store = store
        self._fine = vertices, triangles
        self._coarse: Optional[Tuple[moderngl.Buffer, moderngl.Buffer]] = None
        self._coarse_arrays: Dict[moderngl.Program, moderngl.VertexArray] = {}
        self._vertices = context.buffer(vertices.tobytes())
        self._triangles = context.buffer(np.ascontiguousarray(triangles).tobytes())
        positions = vertices["position"]
        outline = positions, triangles
        if len(triangles) >= _SIMPLIFIED_FROM:
            outline = store.get(simplified, positions, triangles, shadow_detail)
        self._outline = tuple(context.buffer(np.ascontiguousarray(part)) for part in outline)
        self._arrays: Dict[moderngl.Program, moderngl.VertexArray] = {}
        self.center = 0.5 * (positions.min(axis=0) + positions.max(axis=0)).astype(np.float64)
        self.half = 0.5 * np.ptp(positions, axis=0).astype(np.float64)
        self.radius = float(np.linalg.norm(positions - self.center, axis=1).max())

    def array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws it with a program."""
        if program not in self._arrays:
            self._arrays[program] = self._array(program, self._vertices, self._triangles)
        return self._arrays[program]

    def coarse_array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws it with fewer triangles; made when it is first asked for.

        What has a texture stays as it is: merged, its vertices would pull the texture about.
        """
        vertices, triangles = self._fine
        if len(triangles) < _COARSE_FROM or vertices["uv"].any():
            return self.array(program)
        if self._coarse is None:
            self._coarse = self._upload(*self._store.get(coarser, *self._fine, _COARSE_DETAIL))
        if program not in self._coarse_arrays:
            self._coarse_arrays[program] = self._array(program, *self._coarse)
        return self._coarse_arrays[program]

    def _upload(
        self, vertices: np.ndarray, triangles: np.ndarray
    ) -> Tuple[moderngl.Buffer, moderngl.Buffer]:
        """Take over the coarser mesh."""
        return (
            self._context.buffer(vertices.tobytes()),
            self._context.buffer(np.ascontiguousarray(triangles).tobytes()),
        )

    def _array(
        self, program: moderngl.Program, vertices: moderngl.Buffer, triangles: moderngl.Buffer
    ) -> moderngl.VertexArray:
        # A program takes the attributes that it knows of the vertex.
        layout, names = [], []
        for form, size, name in _ATTRIBUTES:
            if name in program:
                layout.append(form)
                names.append(name)
            else:
                layout.append(f"{size}x")
        content = [(vertices, " ".join(layout), *names)]
        return self._context.vertex_array(program, content, triangles)

    def outline(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws its shape alone, more coarsely, with a program that takes positions."""
        if program not in self._arrays:
            positions, triangles = self._outline
            content = [(positions, "3f", "in_position")]
            self._arrays[program] = self._context.vertex_array(program, content, triangles)
        return self._arrays[program]

    def release(self) -> None:
        """Free the memory."""
        for array in (*self._arrays.values(), *self._coarse_arrays.values()):
            array.release()
        for buffer in (self._vertices, self._triangles, *self._outline, *(self._coarse or ())):
            buffer.release()


# Travel that nobody could see (m).
_STILL = 1e-4


class BeltMesh(GpuMesh):
    """A mesh that runs as a belt; it belongs to one belt alone.

    Parameters
    ----------
    context, vertices, triangles, shadow_detail, store
        As for `GpuMesh`.

    Raises
    ------
    ValueError
        When the mesh cannot be a belt.
    """

    # Its cleats come to stand where none stands at rest.
    beyond = 0.01

    def __init__(
        self,
        context: moderngl.Context,
        vertices: np.ndarray,
        triangles: np.ndarray,
        shadow_detail: float,
        store: ContentStore,
    ) -> None:
        rest, triangles = store.get(subdivided, vertices, triangles)
        super().__init__(context, rest, triangles, shadow_detail, store)
        self._running = rest.copy()
        self._path = belt_outline(rest["position"])
        self._surface = self._riders(store, rest["position"], rest["normal"])
        silhouette = np.frombuffer(self._outline[0].read(), dtype=np.float32).reshape(-1, 3)
        self._silhouette = self._riders(store, silhouette)
        self._coarse_running = rest
        self._coarse_surface: Optional[Riders] = None
        self._radius: Optional[float] = None
        self._angle = 0.0
        self._shown = 0.0

    def _riders(
        self, store: ContentStore, positions: np.ndarray, normals: Optional[np.ndarray] = None
    ) -> Riders:
        places = Carried(*store.get(carried, self._path, positions))
        return Riders(self._path, places, positions, normals)

    def _upload(
        self, vertices: np.ndarray, triangles: np.ndarray
    ) -> Tuple[moderngl.Buffer, moderngl.Buffer]:
        self._coarse_running = vertices.copy()
        self._coarse_surface = self._riders(self._store, vertices["position"], vertices["normal"])
        self._carry(self._coarse_surface, self._coarse_running)
        return super()._upload(self._coarse_running, triangles)

    def _carry(self, riders: Riders, vertices: np.ndarray) -> None:
        """Move vertices to where the belt is shown."""
        vertices["position"], vertices["normal"] = riders.at(self._shown)

    def run(self, belt_in_world: np.ndarray, wheel_in_world: np.ndarray) -> None:
        """Move to where the wheel that drives it has turned; poses have the shape (4, 4)."""
        if self._radius is None:
            axle = belt_in_world[:3, :3].T @ (wheel_in_world[:3, 3] - belt_in_world[:3, 3])
            self._radius = wheel_radius(self._path, axle[[0, 2]])
        angle = belt_angle(belt_in_world, wheel_in_world)
        # A wheel need not have a whole number of cleats: its turns have to be counted.
        self._angle += math.remainder(angle - self._angle, 2.0 * math.pi)
        travel = self._radius * self._angle
        if abs(travel - self._shown) < _STILL:
            return
        self._shown = travel
        self._carry(self._surface, self._running)
        self._vertices.write(self._running)
        if self._coarse is not None and self._coarse_surface is not None:
            self._carry(self._coarse_surface, self._coarse_running)
            self._coarse[0].write(self._coarse_running)
        silhouette, _ = self._silhouette.at(travel)
        self._outline[0].write(silhouette)
