"""The compiled shaders, with their uniforms at hand."""

from __future__ import annotations

import math
from typing import Any, Dict, List, Mapping, Optional, Tuple

import moderngl
import numpy as np

from .shaders import (
    Constants,
    LitVariant,
    ShaderSource,
    depth_source,
    lit_source,
    sky_source,
    spots_source,
)

PICTURE_UNIT, SHADOW_MAP_UNIT, COVER_MAP_UNIT, LAMP_MAP_UNIT = range(4)

# Lights whose programs are kept, the last ones.
_MOST_LIGHTS = 8

Uniforms = Mapping[str, np.ndarray]
"""Values by name, float32; matrices as OpenGL takes them (`column_major`)."""


class LitProgram:
    """Draws lit surfaces, in one of the variants.

    The uniforms that change with every surface are attributes, because looking them up by name
    would take longer than writing them.

    Attributes
    ----------
    has_drawn
        Whether it has drawn anything; drivers compile it when it first does.
    frame
        Number of the frame whose pose it has as ``world_from_model``; None: of no known one.
    opaqueness
        Its ``opacity``; NaN: not known.
    """

    def __init__(
        self,
        context: moderngl.Context,
        variant: LitVariant,
        shadow_lookups: int,
        lamp_lookups: int,
        constants: Constants,
    ) -> None:
        source = lit_source(variant, shadow_lookups, lamp_lookups, constants)
        self.program: Any = _compile(context, source)
        self.world_from_model: Any = self.program["world_from_model"]
        self.opacity: Any = self.program["opacity"]
        self.opaqueness = math.nan
        self.has_drawn = False
        self.frame: Optional[int] = None
        if variant.textured:
            self.program["picture"] = PICTURE_UNIT
        if variant.cover:
            self.program["cover_map"] = COVER_MAP_UNIT
        if variant.sun:
            self.program["shadow_map"] = SHADOW_MAP_UNIT
        if variant.lamps and lamp_lookups:
            self.program["lamp_map"] = LAMP_MAP_UNIT

    def set(self, uniforms: Uniforms) -> None:
        """Write those of the uniforms that this variant has."""
        _write(self.program, uniforms)


class LitPrograms:
    """All variants in the last lights, each compiled when it is first needed."""

    def __init__(self, context: moderngl.Context, shadow_lookups: int, lamp_lookups: int) -> None:
        self._context = context
        self._lookups = (shadow_lookups, lamp_lookups)
        self._lights: Dict[Tuple, Dict[LitVariant, LitProgram]] = {}
        self.take_light({})

    def take_light(self, constants: Constants) -> List[moderngl.Program]:
        """Have the programs show things in another light from now on.

        Returns
        -------
        list of moderngl.Program
            Those of a light that are kept no longer, to be released.
        """
        self._constants = constants
        light = tuple(sorted(constants.items()))
        self._programs = self._lights.pop(light, {})
        self._lights[light] = self._programs  # the last one comes last
        if len(self._lights) <= _MOST_LIGHTS:
            return []
        oldest = self._lights.pop(next(iter(self._lights)))
        return [each.program for each in oldest.values()]

    def get(self, variant: LitVariant) -> LitProgram:
        """Return the program of a variant."""
        if variant not in self._programs:
            self._programs[variant] = LitProgram(
                self._context, variant, *self._lookups, self._constants
            )
        return self._programs[variant]

    def has_drawn(self, variant: LitVariant) -> bool:
        """Whether the program of a variant is there, and has drawn before."""
        return variant in self._programs and self._programs[variant].has_drawn


class SkyProgram:
    """Fills what nothing else covers."""

    def __init__(self, context: moderngl.Context, fog: bool) -> None:
        self._program: Any = _compile(context, sky_source(fog))
        # One triangle that reaches beyond the picture on all sides, clockwise as all is seen.
        corners = np.array([(-1.0, -1.0), (-1.0, 3.0), (3.0, -1.0)], dtype=np.float32)
        buffer = context.buffer(corners.tobytes())
        self._triangle = context.vertex_array(self._program, [(buffer, "2f", "in_corner")])

    def set(self, uniforms: Uniforms) -> None:
        """Write those of the uniforms that it has."""
        _write(self._program, uniforms)

    def draw(
        self, clip_from_optical: np.ndarray, optical_in_world: np.ndarray, exposure: float
    ) -> None:
        """Draw behind everything; the camera's matrices have the shape (4, 4)."""
        self._program["exposure"].value = exposure
        (scale_x, _, shift_x), (_, scale_y, shift_y) = clip_from_optical[:2, :3]
        optical_from_corner = np.array(
            [
                [1.0 / scale_x, 0.0, -shift_x / scale_x],
                [0.0, 1.0 / scale_y, -shift_y / scale_y],
                [0.0, 0.0, 1.0],
            ]
        )
        ray_from_corner = optical_in_world[:3, :3] @ optical_from_corner
        self._program["ray_from_corner"].write(column_major(ray_from_corner).tobytes())
        self._triangle.render()


def depth_program(context: moderngl.Context) -> moderngl.Program:
    """Make the program that writes depth alone."""
    return _compile(context, depth_source())


def spots_program(context: moderngl.Context) -> moderngl.Program:
    """Make the program that adds spots of light."""
    return _compile(context, spots_source())


def column_major(matrices: np.ndarray) -> np.ndarray:
    """One or more matrices as OpenGL takes them, float32."""
    return np.ascontiguousarray(np.swapaxes(matrices, -1, -2), dtype=np.float32)


def _write(program: Any, uniforms: Uniforms) -> None:
    for name, value in uniforms.items():
        uniform = program.get(name, None)
        if uniform is not None:
            uniform.write(value.tobytes())


def _compile(context: moderngl.Context, source: ShaderSource) -> moderngl.Program:
    return context.program(vertex_shader=source.vertex, fragment_shader=source.fragment)
