"""The compiled shaders, with their uniforms at hand."""

from __future__ import annotations

from typing import Any, Tuple

import moderngl
import numpy as np

from .lighting import Lighting, Rgb, unit
from .shaders import ShaderSource, depth_source, lit_source, sky_source

PICTURE_UNIT, SHADOW_MAP_UNIT = 0, 1


class LitProgram:
    """Draws surfaces in daylight; one variant with textures, one without.

    The uniforms that change with every surface are attributes, because looking them up by name
    would take longer than writing them.
    """

    def __init__(self, context: moderngl.Context, textured: bool, shadow_lookups: int) -> None:
        self.program: Any = _compile(context, lit_source(textured, shadow_lookups))
        self.world_from_model: Any = self.program["world_from_model"]
        self.color: Any = self.program["color"]
        self.uv_scale: Any = self.program["uv_scale"] if textured else None
        self.program["shadow_map"] = SHADOW_MAP_UNIT
        if textured:
            self.program["picture"] = PICTURE_UNIT

    def set_lighting(self, lighting: Lighting, shadow_softness: float) -> None:
        """Write what stays the same from picture to picture.

        ``shadow_softness`` is half the width of soft edges, as a share of the shadow map's side.
        """
        program = self.program
        program["to_sun"] = tuple(unit(lighting.to_sun))
        program["to_fill"] = tuple(unit(lighting.to_fill))
        for name in ("sun", "fill", "sky_ambient", "ground_ambient"):
            program[name] = getattr(lighting, name)
        program["horizon"] = light_of_display(lighting.horizon)
        program["specular"] = lighting.specular
        program["haze"] = lighting.haze_distance**-2
        program["shadow_softness"] = shadow_softness

    def set_view(self, clip_from_world: np.ndarray, eye: np.ndarray) -> None:
        """Write the camera's projection, shape (4, 4), and position, shape (3,)."""
        self.program["clip_from_world"].write(column_major(clip_from_world))
        self.program["eye"] = tuple(eye)

    def set_shadow(self, map_from_world: np.ndarray, normal_offset: float) -> None:
        """Write the shadow map's projection, and how far above a surface to look it up (m)."""
        self.program["map_from_world"].write(column_major(map_from_world))
        self.program["normal_offset"] = normal_offset


class SkyProgram:
    """Fills what nothing else covers."""

    def __init__(self, context: moderngl.Context, lighting: Lighting) -> None:
        program: Any = _compile(context, sky_source())
        program["horizon"] = light_of_display(lighting.horizon)
        program["zenith"] = light_of_display(lighting.zenith)
        # One triangle that reaches beyond the picture on all sides, clockwise as all is seen.
        corners = np.array([(-1.0, -1.0), (-1.0, 3.0), (3.0, -1.0)], dtype=np.float32)
        buffer = context.buffer(corners.tobytes())
        self._program = program
        self._triangle = context.vertex_array(program, [(buffer, "2f", "in_corner")])

    def draw(self, clip_from_optical: np.ndarray, optical_in_world: np.ndarray) -> None:
        """Draw behind everything; the camera's matrices have the shape (4, 4)."""
        (scale_x, _, shift_x), (_, scale_y, shift_y) = clip_from_optical[:2, :3]
        optical_from_corner = np.array(
            [
                [1.0 / scale_x, 0.0, -shift_x / scale_x],
                [0.0, 1.0 / scale_y, -shift_y / scale_y],
                [0.0, 0.0, 1.0],
            ]
        )
        ray_from_corner = optical_in_world[:3, :3] @ optical_from_corner
        self._program["ray_from_corner"].write(column_major(ray_from_corner))
        self._triangle.render()


def depth_program(context: moderngl.Context) -> moderngl.Program:
    """Make the program that writes depth alone."""
    return _compile(context, depth_source())


def column_major(matrices: np.ndarray) -> bytes:
    """One or more matrices as OpenGL takes them."""
    return np.swapaxes(matrices, -1, -2).astype(np.float32).tobytes()


def light_of_display(color: Rgb) -> Tuple[float, ...]:
    """Find the light that ``to_display`` in the shaders turns into this colour."""
    squares = np.square(color)
    return tuple(squares / (1.25 - 0.25 * squares))


def _compile(context: moderngl.Context, source: ShaderSource) -> moderngl.Program:
    return context.program(vertex_shader=source.vertex, fragment_shader=source.fragment)
