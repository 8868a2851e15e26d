"""Round spots of light that are added to a finished picture."""

from __future__ import annotations

from typing import Any, Optional, Sequence

import moderngl
import numpy as np

from ..programs import column_major, spots_program

# A spot's vertices are two triangles of the square around it.
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])

_FLOATS, _FLOAT_BYTES = 8, 4


def spot(
    middle: np.ndarray, across: np.ndarray, along: np.ndarray, light: np.ndarray
) -> np.ndarray:
    """Make a spot, as `Spots` draws it.

    Parameters
    ----------
    middle
        In the world (m), shape (3,).
    across, along
        Radii in the world (m), shape (3,).
    light
        In the middle, with the exposure, shape (3,).
    """
    square = np.empty((len(_CORNERS), _FLOATS), dtype=np.float32)
    square[:, :3] = middle + _CORNERS @ [across, along]
    square[:, 3:5] = _CORNERS
    square[:, 5:] = light
    return square


class Spots:
    """Draws spots; what stands before them hides them.

    Parameters
    ----------
    context
        To draw with. Nothing is made of it before there are spots.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program: Any = None
        self._array: Any = None
        self._vertices: Optional[moderngl.Buffer] = None

    def draw(self, clip_from_world: np.ndarray, spots: Sequence[np.ndarray]) -> None:
        """Add spots to a picture, seen through a matrix of shape (4, 4)."""
        if not spots:
            return
        content = np.concatenate(spots).tobytes()
        if self._vertices is None or self._vertices.size < len(content):
            self._make(2 * len(content))
        assert self._vertices is not None
        context = self._context
        self._vertices.write(content)
        self._program["clip_from_world"].write(column_major(clip_from_world).tobytes())
        context.disable(moderngl.CULL_FACE)
        context.enable(moderngl.BLEND)
        context.blend_func = moderngl.ONE, moderngl.ONE
        self._array.render(vertices=len(spots) * len(_CORNERS))
        context.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        context.disable(moderngl.BLEND)
        context.enable(moderngl.CULL_FACE)

    def _make(self, size: int) -> None:
        """Make room for so many bytes of vertices."""
        if self._program is None:
            self._program = spots_program(self._context)
        if self._vertices is not None:
            self._array.release()
            self._vertices.release()
        self._vertices = self._context.buffer(reserve=size)
        content = [(self._vertices, "3f 2f 3f", "in_position", "in_place", "in_light")]
        self._array = self._context.vertex_array(self._program, content)
