"""A mesh in the memory of whatever renders."""

from __future__ import annotations

import math
from typing import Dict, Optional

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


DETAILS = (0.01, 0.03, 0.09)
"""What is smaller need not show in the first, second, ... coarser shape of a mesh (m)."""

COARSE_PIXELS = 1.5
"""What is smaller need not show in pictures with coarser shapes (pixels); nor what is smaller than
the first of `DETAILS`."""

# What has fewer triangles has no coarser shapes: they are not worth it.
_COARSE_FROM = 100

# What has fewer triangles throws its shadow as it is: to look a simpler shape up takes longer.
_SIMPLIFIED_FROM = 200


class _Shape:
    """A mesh in one detail: its buffers, and what draws it with each program."""

    def __init__(
        self, context: moderngl.Context, vertices: np.ndarray, triangles: np.ndarray
    ) -> None:
        self._context = context
        self.vertices = context.buffer(vertices.tobytes())
        self._triangles = context.buffer(np.ascontiguousarray(triangles).tobytes())
        self._arrays: Dict[moderngl.Program, moderngl.VertexArray] = {}

    def array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws it with a program."""
        if program not in self._arrays:
            self._arrays[program] = self._array(program)
        return self._arrays[program]

    def _array(self, program: moderngl.Program) -> moderngl.VertexArray:
        # A program takes the attributes that it knows of the vertex.
        layout, names = [], []
        for form, size, name in _ATTRIBUTES:
            if name in program:
                layout.append(form)
                names.append(name)
            else:
                layout.append(f"{size}x")
        content = [(self.vertices, " ".join(layout), *names)]
        return self._context.vertex_array(program, content, self._triangles)

    def forget(self, program: moderngl.Program) -> None:
        """Free what draws it with a program."""
        array = self._arrays.pop(program, None)
        if array is not None:
            array.release()

    def release(self) -> None:
        """Free the memory."""
        for array in self._arrays.values():
            array.release()
        self.vertices.release()
        self._triangles.release()


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
        # By their detail; what is not worth a coarser shape has the same one again.
        self._shapes: Dict[int, _Shape] = {0: _Shape(context, vertices, triangles)}
        positions = vertices["position"]
        outline = positions, triangles
        if len(triangles) >= _SIMPLIFIED_FROM:
            outline = store.get(simplified, positions, triangles, shadow_detail)
        self._outline = tuple(context.buffer(np.ascontiguousarray(part)) for part in outline)
        self._outlines: Dict[moderngl.Program, moderngl.VertexArray] = {}
        self.center = 0.5 * (positions.min(axis=0) + positions.max(axis=0)).astype(np.float64)
        self.half = 0.5 * np.ptp(positions, axis=0).astype(np.float64)
        self.radius = float(np.linalg.norm(positions - self.center, axis=1).max())

    def array(self, program: moderngl.Program, detail: int = 0) -> moderngl.VertexArray:
        """What draws it with a program.

        Parameters
        ----------
        detail
            0: as it is; else with fewer triangles, made when they are first asked for: nothing
            moves by more than a few times ``DETAILS[detail - 1]``.
        """
        return self._shape(detail).array(program)

    def _shape(self, detail: int) -> _Shape:
        if detail not in self._shapes:
            if len(self._fine[1]) < _COARSE_FROM:
                self._shapes[detail] = self._shapes[0]
            else:
                coarse = self._store.get(coarser, *self._fine, DETAILS[detail - 1])
                self._shapes[detail] = self._make_shape(detail, *coarse)
        return self._shapes[detail]

    def _make_shape(self, detail: int, vertices: np.ndarray, triangles: np.ndarray) -> _Shape:
        """Take over a coarser shape."""
        return _Shape(self._context, vertices, triangles)

    def outline(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws its shape alone, more coarsely, with a program that takes positions."""
        if program not in self._outlines:
            positions, triangles = self._outline
            content = [(positions, "3f", "in_position")]
            self._outlines[program] = self._context.vertex_array(program, content, triangles)
        return self._outlines[program]

    def forget(self, program: moderngl.Program) -> None:
        """Free what draws it with a program, which `array` was asked for."""
        for shape in self._shapes.values():
            shape.forget(program)

    def release(self) -> None:
        """Free the memory."""
        for shape in set(self._shapes.values()):
            shape.release()
        for outline in self._outlines.values():
            outline.release()
        for buffer in self._outline:
            buffer.release()


# Travel that nobody could see (m).
_STILL = 1e-4


class _Running:
    """The vertices of one shape of a belt; it is brought to where the belt is when it is drawn."""

    def __init__(self, vertices: np.ndarray, riders: Riders) -> None:
        self._vertices = vertices
        self._riders = riders
        self.shown = 0.0

    def at(self, travel: float) -> np.ndarray:
        """Return them after the belt has travelled so far (m)."""
        self.shown = travel
        self._vertices["position"], self._vertices["normal"] = self._riders.at(travel)
        return self._vertices


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
        self._path = belt_outline(rest["position"])
        self._running = {0: self._surface(rest)}
        silhouette = np.frombuffer(self._outline[0].read(), dtype=np.float32).reshape(-1, 3)
        self._silhouette = self._riders(silhouette)
        self._silhouette_shown = 0.0
        self._radius: Optional[float] = None
        self._angle = 0.0
        self._travel = 0.0

    def _riders(self, positions: np.ndarray, normals: Optional[np.ndarray] = None) -> Riders:
        places = Carried(*self._store.get(carried, self._path, positions))
        return Riders(self._path, places, positions, normals)

    def _surface(self, vertices: np.ndarray) -> _Running:
        return _Running(vertices.copy(), self._riders(vertices["position"], vertices["normal"]))

    def _make_shape(self, detail: int, vertices: np.ndarray, triangles: np.ndarray) -> _Shape:
        self._running[detail] = self._surface(vertices)
        return super()._make_shape(detail, vertices, triangles)

    def run(self, belt_in_world: np.ndarray, wheel_in_world: np.ndarray) -> None:
        """Move to where the wheel that drives it has turned; poses have the shape (4, 4)."""
        if self._radius is None:
            axle = belt_in_world[:3, :3].T @ (wheel_in_world[:3, 3] - belt_in_world[:3, 3])
            self._radius = wheel_radius(self._path, axle[[0, 2]])
        angle = belt_angle(belt_in_world, wheel_in_world)
        # A wheel need not have a whole number of cleats: its turns have to be counted.
        self._angle += math.remainder(angle - self._angle, 2.0 * math.pi)
        self._travel = self._radius * self._angle

    def array(self, program: moderngl.Program, detail: int = 0) -> moderngl.VertexArray:
        """What draws it where it has run to; as for `GpuMesh`."""
        shape = self._shape(detail)
        running = self._running.get(detail, self._running[0])
        if abs(self._travel - running.shown) >= _STILL:
            shape.vertices.write(running.at(self._travel))
        return shape.array(program)

    def outline(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws its shape alone, where it has run to."""
        if abs(self._travel - self._silhouette_shown) >= _STILL:
            self._silhouette_shown = self._travel
            silhouette, _ = self._silhouette.at(self._travel)
            self._outline[0].write(silhouette)
        return super().outline(program)
