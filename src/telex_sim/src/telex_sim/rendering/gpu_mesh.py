"""A mesh in the memory of whatever renders."""

from __future__ import annotations

from typing import Dict

import moderngl
import numpy as np

from .simplification import simplified

# The fields of `batching.VERTEX` as OpenGL takes them: form, bytes, name.
_ATTRIBUTES = (
    ("3f", 12, "in_position"),
    ("3f", 12, "in_normal"),
    ("4f1", 4, "in_color"),
    ("2f", 8, "in_uv"),
)


class GpuMesh:
    """A mesh, ready to be drawn by any of the programs.

    Parameters
    ----------
    context
        To draw with.
    vertices, triangles
        As `batching.merge` returns them.
    shadow_detail
        What is smaller need not show in shadows (m).

    Attributes
    ----------
    center, radius
        Bounding sphere in the frame that it is fixed to (m).
    """

    def __init__(
        self,
        context: moderngl.Context,
        vertices: np.ndarray,
        triangles: np.ndarray,
        shadow_detail: float,
    ) -> None:
        self._context = context
        self._vertices = context.buffer(vertices.tobytes())
        self._triangles = context.buffer(np.ascontiguousarray(triangles).tobytes())
        positions = vertices["position"]
        outline = simplified(positions, triangles, shadow_detail)
        self._outline = tuple(context.buffer(np.ascontiguousarray(part)) for part in outline)
        self._arrays: Dict[moderngl.Program, moderngl.VertexArray] = {}
        self.center = 0.5 * (positions.min(axis=0) + positions.max(axis=0)).astype(np.float64)
        self.radius = float(np.linalg.norm(positions - self.center, axis=1).max())

    def array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws it with a program."""
        if program not in self._arrays:
            # A program takes the attributes that it knows of the vertex.
            layout, names = [], []
            for form, size, name in _ATTRIBUTES:
                if name in program:
                    layout.append(form)
                    names.append(name)
                else:
                    layout.append(f"{size}x")
            content = [(self._vertices, " ".join(layout), *names)]
            self._arrays[program] = self._context.vertex_array(program, content, self._triangles)
        return self._arrays[program]

    def outline(self, program: moderngl.Program) -> moderngl.VertexArray:
        """What draws its shape alone, more coarsely, with a program that takes positions."""
        if program not in self._arrays:
            positions, triangles = self._outline
            content = [(positions, "3f", "in_position")]
            self._arrays[program] = self._context.vertex_array(program, content, triangles)
        return self._arrays[program]

    def release(self) -> None:
        """Free the memory."""
        for array in self._arrays.values():
            array.release()
        for buffer in (self._vertices, self._triangles, *self._outline):
            buffer.release()
