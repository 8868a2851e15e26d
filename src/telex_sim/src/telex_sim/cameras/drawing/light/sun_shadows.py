"""The sun's shadow maps, drawn once for all cameras that look at the same poses.

There are two, side by side in one texture: a sharp one of what is near the robot, and a wide one of
its surroundings.
"""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Optional

import moderngl
import numpy as np

from ..culling import spheres_in_view
from ..meshes.gpu_scene import GpuScene
from ..stillness import STILL, is_still
from .daylight import SunView, sun_axes, sun_view

# Pixels.
_MARGIN = 1

# Slope factor and constant of OpenGL's polygon offset: against surfaces that shade themselves. That
# of the wide map makes up for the shaders' normal offset, which suits the sharp one.
_POLYGON_OFFSETS = ((1.5, 2.0), (4.0, 6.0))

# Half the side of the square around the focus that the sharp map shows (m): the robot fits in with
# its arm and most of its shadow.
_SHARP = 2.2

# The focus may wander so far before the wide map is drawn around its new place (m).
_WANDER = 1.0


class _Drawn(NamedTuple):
    """What a map shows at present: casters, their poses, and the point that it is drawn around."""

    casters: np.ndarray
    model: np.ndarray
    focus: np.ndarray

    def holds(
        self, casters: np.ndarray, model: np.ndarray, focus: np.ndarray, wander: float
    ) -> bool:
        """Whether these casters are in it, where they are now, and the focus is near enough."""
        place = np.searchsorted(self.casters, casters)
        if len(casters) and (
            place[-1] >= len(self.casters) or (self.casters[place] != casters).any()
        ):
            return False
        stands = is_still(model[casters], self.model[place])
        return stands and float(np.abs(focus - self.focus).max()) < wander


class ShadowMap:
    """Depths as the sun sees them.

    Parameters
    ----------
    context, program
        To draw with; the program writes depth alone.
    radius
        Half the side of the square around the focus in which shadows fall (m).
    size
        Pixels along each side of each map.
    """

    def __init__(
        self, context: moderngl.Context, program: moderngl.Program, radius: float, size: int
    ) -> None:
        self._context = context
        self._program = program
        self._clip_from_model: Any = program["clip_from_model"]
        self._radii = (min(_SHARP, radius), radius)
        self._to_sun = np.array([0.0, 0.0, 1.0])
        self._size = size
        self._depths = context.depth_texture((2 * size, size))
        self._depths.compare_func = "<="
        self._depths.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._depths.repeat_x = self._depths.repeat_y = False
        self._framebuffer = context.framebuffer(depth_attachment=self._depths)
        # Nothing is drawn in the outermost pixels, which stand for all that is beyond a map: lit.
        self._inner = size - 2 * _MARGIN
        self._drawn: List[Optional[_Drawn]] = [None, None]
        self._views: List[SunView] = [SunView(np.eye(4), 1.0), SunView(np.eye(4), 1.0)]

    @property
    def texel(self) -> float:
        """Side of the pixels of the sharp map in the world (m)."""
        return self._views[0].texel

    def invalidate(self, to_sun: object) -> None:
        """Have the next update draw even if nothing has moved: the scene is another one."""
        self._to_sun = np.asarray(to_sun, dtype=np.float64)
        self._drawn = [None, None]

    def update(
        self, scene: GpuScene, model: np.ndarray, centers: np.ndarray, focus: np.ndarray
    ) -> None:
        """Draw what casts shadows, unless it stands where it stood.

        Along the sun's rays, a thing and its shadow are in the same place: what the sharp map holds
        as a whole need not be in the wide one, which is therefore seldom drawn.

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
        sharp = self._drawn[0]
        if sharp is None or not sharp.holds(casters, model, focus, STILL):
            self._draw(0, scene, model, centers, casters, focus)
        axes = sun_axes(self._to_sun)[:2]
        beside = np.abs((centers[casters] - focus) @ axes.T).max(axis=1)
        # A few pixels of the sharp map's edge are not looked at.
        within = beside + scene.radii[casters] < 0.98 * self._radii[0]
        wide = self._drawn[1]
        if wide is None or not wide.holds(casters[~within], model, focus, _WANDER):
            # What stands fast is drawn in any case: when the focus wanders, it is needed.
            outside = casters[~within | scene.fixed[casters]]
            self._draw(1, scene, model, centers, outside, focus)
        self._context.polygon_offset = (0.0, 0.0)

    def _draw(
        self,
        number: int,
        scene: GpuScene,
        model: np.ndarray,
        centers: np.ndarray,
        casters: np.ndarray,
        focus: np.ndarray,
    ) -> None:
        self._drawn[number] = _Drawn(casters, model[casters].copy(), focus.copy())
        spheres = centers[casters], scene.radii[casters]
        view = sun_view(self._to_sun, self._radii[number], self._inner, focus, *spheres)
        self._views[number] = view
        clip = view.clip_from_world
        seen = casters[spheres_in_view(clip, *spheres)]
        left = number * self._size
        self._framebuffer.viewport = (left, 0, self._size, self._size)
        self._framebuffer.use()
        self._framebuffer.clear(depth=1.0, viewport=(left, 0, self._size, self._size))
        self._framebuffer.viewport = (left + _MARGIN, _MARGIN, self._inner, self._inner)
        self._context.polygon_offset = _POLYGON_OFFSETS[number]
        # OpenGL takes matrices column by column.
        matrices = (clip @ model[seen]).transpose(0, 2, 1).astype(np.float32)
        for drawable, matrix in zip(seen, matrices):
            self._clip_from_model.write(matrix.tobytes())
            scene.drawables[drawable].mesh.outline(self._program).render()

    def uniforms(self) -> Dict[str, np.ndarray]:
        """How the shaders find their way in the maps, by the names of their uniforms.

        Coordinates are those of the sharp map, 0 to 1 across it; ``wide_scale`` and ``wide_shift``
        lead from them to those of the wide one.
        """
        sharp, wide = (self._map_from_world(view) for view in self._views)
        # Both look along the same axes.
        scale = np.einsum("ij,ij->i", wide[:3, :3], sharp[:3, :3])
        scale /= np.square(sharp[:3, :3]).sum(axis=1)
        shift = wide[:3, 3] - scale * sharp[:3, 3]
        return {
            "map_from_world": np.ascontiguousarray(sharp.T, dtype=np.float32),
            "wide_scale": scale.astype(np.float32),
            "wide_shift": shift.astype(np.float32),
        }

    def _map_from_world(self, view: SunView) -> np.ndarray:
        """World to a map's coordinates and depth, each 0..1; shape (4, 4)."""
        halved = np.diag([0.5, 0.5, 0.5, 1.0])
        halved[:2] *= self._inner / self._size
        halved[:3, 3] = 0.5
        return halved @ view.clip_from_world

    def use(self, unit: int) -> None:
        """Bind the maps to a texture unit."""
        self._depths.use(unit)
