"""The sun's shadow map, drawn once for all cameras that look at the same poses."""

from __future__ import annotations

from typing import Any, Optional

import moderngl
import numpy as np

from .culling import spheres_in_view
from .gpu_scene import GpuScene
from .lighting import SunView, sun_view

# What moves less than this does not change a shadow that anybody could see (m, or rad at 1 m).
_STILL = 1e-4

# Pixels.
_MARGIN = 1

# Slope factor and constant of OpenGL's polygon offset: against surfaces that shade themselves.
_POLYGON_OFFSET = (1.5, 2.0)


class ShadowMap:
    """Depths as the sun sees them.

    Parameters
    ----------
    context, program
        To draw with; the program writes depth alone.
    radius
        Half the side of the square around the focus in which shadows fall (m).
    size
        Pixels along each side.
    """

    def __init__(
        self, context: moderngl.Context, program: moderngl.Program, radius: float, size: int
    ) -> None:
        self._context = context
        self._program = program
        self._clip_from_model: Any = program["clip_from_model"]
        self._radius = radius
        self._to_sun = np.array([0.0, 0.0, 1.0])
        self._size = size
        self._depths = context.depth_texture((size, size))
        self._depths.compare_func = "<="
        self._depths.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._depths.repeat_x = self._depths.repeat_y = False
        self._framebuffer = context.framebuffer(depth_attachment=self._depths)
        # Nothing is drawn in the outermost pixels, which stand for all that is beyond the map: lit.
        self._inner = size - 2 * _MARGIN
        self._framebuffer.viewport = (_MARGIN, _MARGIN, self._inner, self._inner)
        self._drawn_model: Optional[np.ndarray] = None
        self._drawn_focus = np.zeros(3)
        self.view = SunView(np.eye(4), 1.0)

    def invalidate(self, to_sun: object) -> None:
        """Have the next update draw even if nothing has moved: the scene is another one."""
        self._to_sun = np.asarray(to_sun, dtype=np.float64)
        self._drawn_model = None

    def update(
        self, scene: GpuScene, model: np.ndarray, centers: np.ndarray, focus: np.ndarray
    ) -> None:
        """Draw what casts shadows, unless it stands where it stood.

        Parameters
        ----------
        scene
            What there is.
        model
            World from model of each drawable, shape (N, 4, 4).
        centers
            Of their bounding spheres in the world, shape (N, 3).
        focus
            Point around which shadows matter (m), shape (3,).
        """
        casters = np.flatnonzero(scene.casts_shadow)
        if self._is_still(model[casters], focus):
            return
        self._drawn_model, self._drawn_focus = model[casters].copy(), focus.copy()
        radii = scene.radii[casters]
        self.view = sun_view(
            self._to_sun, self._radius, self._inner, focus, centers[casters], radii
        )
        clip = self.view.clip_from_world
        seen = casters[spheres_in_view(clip, centers[casters], radii)]
        # OpenGL takes matrices column by column.
        matrices = (clip @ model[seen]).transpose(0, 2, 1).astype(np.float32)
        self._framebuffer.use()
        self._framebuffer.clear(depth=1.0)
        self._context.polygon_offset = _POLYGON_OFFSET
        for number, matrix in zip(seen, matrices):
            self._clip_from_model.write(matrix.tobytes())
            scene.drawables[number].mesh.outline(self._program).render()
        self._context.polygon_offset = (0.0, 0.0)

    def map_from_world(self) -> np.ndarray:
        """World to the map's texture coordinates and depth, each 0..1; shape (4, 4)."""
        halved = np.diag([0.5, 0.5, 0.5, 1.0])
        halved[:2] *= self._inner / self._size
        halved[:3, 3] = 0.5
        return halved @ self.view.clip_from_world

    def use(self, unit: int) -> None:
        """Bind the map to a texture unit."""
        self._depths.use(unit)

    def _is_still(self, model: np.ndarray, focus: np.ndarray) -> bool:
        return (
            self._drawn_model is not None
            and float(np.abs(focus - self._drawn_focus).max()) < _STILL
            and float(np.abs(model - self._drawn_model).max(initial=0.0)) < _STILL
        )
