"""Occlusion of the light from above (ambient occlusion).

Soft shadows at the foot of things tell where they stand. A map of heights, as seen from straight
above, is blurred: a point is in the shade as far as the blurred map is above it.
"""

from __future__ import annotations

from typing import Any, Optional

import cv2
import moderngl
import numpy as np

from ....scene.meshes.meshes import box_mesh
from ..culling import spheres_in_view
from ..meshes.gpu_scene import GpuScene
from ..programs import column_major
from ..shaders import FULL_COVER

# Half the side of the square around the focus that the map shows, and side of its pixels (m).
_RADIUS, _TEXEL = 4.0, 0.05

# Standard deviation of the blur (m): about as wide as such shadows are.
_BLUR = 0.15

# What is this far above the focus, as a ceiling is, hides nothing; nor does what is far below (m).
_HEADROOM, _DEPTH = 1.5, 4.0

# Pixels along the map's edge in which the shade fades.
_BORDER = 8

# What moves less leaves the map as it is (m).
_MOVED = 0.004

# The focus may wander so far before the map is drawn around its new place (m); until then, what
# stands fast stays drawn.
_WANDER = 0.4


class SkyCover:
    """A blurred map of heights around a point.

    Parameters
    ----------
    context, program
        To draw with; the program writes depth alone.
    """

    def __init__(self, context: moderngl.Context, program: moderngl.Program) -> None:
        self._context = context
        self._program = program
        self._clip_from_model: Any = program["clip_from_model"]
        cube = box_mesh((2.0, 2.0, 2.0))
        corners, triangles = (
            context.buffer(np.ascontiguousarray(part)) for part in (cube.positions, cube.triangles)
        )
        self._cube = context.vertex_array(program, [(corners, "3f", "in_position")], triangles)
        self._size = round(2.0 * _RADIUS / _TEXEL)
        side = (self._size, self._size)
        self._framebuffer = context.framebuffer(depth_attachment=context.depth_renderbuffer(side))
        self._heights = context.texture(side, 1, dtype="f4")
        self._heights.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._heights.repeat_x = self._heights.repeat_y = False
        edge = np.minimum(np.arange(self._size), np.arange(self._size)[::-1])
        inside = np.clip(np.minimum.outer(edge, edge) / _BORDER, 0.0, 1.0)
        self._sunk = ((1.0 - inside) * _DEPTH).astype(np.float32)
        self._corner: Optional[np.ndarray] = None
        self._fixed = np.zeros(side, dtype=np.float32)
        self._drawn_model = np.zeros((0, 4, 4))

    def invalidate(self) -> None:
        """Have the next update draw even if nothing has moved: the scene is another one."""
        self._corner = None

    def update(
        self, scene: GpuScene, model: np.ndarray, centers: np.ndarray, focus: np.ndarray
    ) -> None:
        """Draw the map, unless everything stands where it stood; parameters as for `ShadowMap`."""
        what = (scene, model, centers)
        moving = np.flatnonzero(~scene.transparent & ~scene.fixed)
        stands = self._corner is not None and np.abs(focus - self._corner).max() < _WANDER
        if not stands:
            # By whole pixels, so that soft edges do not crawl as the robot drives.
            self._corner = np.round(focus / _TEXEL) * _TEXEL
            fixed = np.flatnonzero(~scene.transparent & scene.fixed)
            self._fixed = self._heights_of(fixed, *what, coarse=False)
        elif (
            len(moving) == len(self._drawn_model)
            and np.abs(model[moving] - self._drawn_model).max(initial=0.0) < _MOVED
        ):
            return
        self._drawn_model = model[moving].copy()
        heights = np.maximum(self._fixed, self._heights_of(moving, *what, coarse=True))
        soft: np.ndarray = np.asarray(
            cv2.GaussianBlur(heights, (0, 0), _BLUR / _TEXEL, borderType=cv2.BORDER_REPLICATE)
        )
        covers = (soft - self._sunk) * np.float32(1.0 / FULL_COVER)
        self._heights.write(covers.astype(np.float32).tobytes())

    def _heights_of(
        self,
        numbers: np.ndarray,
        scene: GpuScene,
        model: np.ndarray,
        centers: np.ndarray,
        coarse: bool,
    ) -> np.ndarray:
        """Draw some of the drawables; returns how high they are (m), shape (size, size).

        Coarsely, each is the box around it in its own frame: of what is blurred nobody sees more.
        """
        assert self._corner is not None
        half, top = 0.5 * self._size * _TEXEL, self._corner[2] + _HEADROOM
        scale = np.array([1.0 / half, 1.0 / half, -2.0 / _DEPTH])
        clip = np.diag([*scale, 1.0])
        clip[:3, 3] = -scale * (*self._corner[:2], top - 0.5 * _DEPTH)
        seen = numbers[spheres_in_view(clip, centers[numbers], scene.radii[numbers])]
        self._framebuffer.use()
        self._framebuffer.clear(depth=1.0)
        # Whether a surface shows its back does not matter for its height.
        self._context.disable(moderngl.CULL_FACE)
        boxes = scene.boxes[seen] if coarse else np.eye(4)
        for number, matrix in zip(seen, column_major(clip @ model[seen] @ boxes)):
            self._clip_from_model.write(matrix.tobytes())
            mesh = scene.drawables[number].mesh
            (self._cube if coarse else mesh.outline(self._program)).render()
        self._context.enable(moderngl.CULL_FACE)
        depths = np.frombuffer(
            self._framebuffer.read(components=1, attachment=-1, dtype="f4"), dtype=np.float32
        ).reshape(self._size, self._size)
        return np.float32(top) - depths * np.float32(_DEPTH)

    def place(self) -> np.ndarray:
        """Offset along x and y, and scale, that lead from the world to the map; float32."""
        scale = 1.0 / (self._size * _TEXEL)
        middle = np.zeros(2) if self._corner is None else self._corner[:2]
        return np.array([*(0.5 - scale * middle), scale], dtype=np.float32)

    def use(self, unit: int) -> None:
        """Bind the map to a texture unit."""
        self._heights.use(unit)
