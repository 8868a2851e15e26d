"""Dots of light that lasers make on what they meet."""

from __future__ import annotations

from typing import Any, List, Mapping, NamedTuple

import moderngl
import numpy as np

from ...optics.pinhole import PinholeCamera
from ..culling import spheres_in_view
from ..meshes.gpu_mesh import COARSE_PIXELS
from ..meshes.gpu_scene import GpuScene
from ..programs import column_major, depth_program
from .daylight import unit
from .lamps import LampRig
from .spots import spot

# Half the width of a dot (m), and in a picture at least (pixels): what is small and very bright
# shines over into the pixels around it.
_RADIUS, _LEAST_RADIUS = 0.004, 2.5

# Off the middle of a beam, on both sides, are the rays that tell how the surface lies (m).
_SPREAD = 0.001

# Slope of a surface, by the cosine of its tilt, from which on the rays have met several.
_STEEPEST = 6.0

# By what a dot lies nearer to the camera than its surface (m; per metre of distance), and by how
# much more, at least, where the surface is drawn coarsely.
_LIFT, _LIFT_BY_DISTANCE, _LIFT_COARSE = 0.0015, 0.001, 0.012


class _Dot(NamedTuple):
    """Middle in the world (m), two directions in the surface, and light; each of shape (3,)."""

    middle: np.ndarray
    across: np.ndarray
    along: np.ndarray
    light: np.ndarray


class LaserDots:
    """The dots of all lasers of a scene.

    Parameters
    ----------
    context
        To draw with. Nothing is made of it before a scene has lasers.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._depth: Any = None
        self._room = 0
        self._dots: List[_Dot] = []
        self._rig = LampRig((), (), 1.0)

    def load(self, rig: LampRig) -> None:
        """Take over the lasers of a scene."""
        self._dots = []
        self._rig = rig
        count = len(self._rig)
        if count <= self._room:
            return
        if not self._room:
            self._depth = depth_program(self._context)
        self._room = count
        # Each beam has four rays, which are the pixels of a view along it.
        self._side = (2 * count, 2)
        self._framebuffer = self._context.framebuffer(
            depth_attachment=self._context.depth_renderbuffer(self._side)
        )

    @property
    def levels(self) -> np.ndarray:
        """At which they burn, 0 to 1."""
        return self._rig.levels

    def set_levels(self, levels: Mapping[str, float]) -> None:
        """Dim them; see `LampRig.set_levels`."""
        self._rig.set_levels(levels)

    def place(self, frames_in_world: np.ndarray) -> None:
        """Move them to where their frames are."""
        self._rig.place(frames_in_world)

    def update(self, scene: GpuScene, model: np.ndarray, centers: np.ndarray) -> None:
        """Find what the beams meet.

        Parameters
        ----------
        scene
            What there is; beams go through what is transparent.
        model
            World from model of each drawable, shape (N, 4, 4).
        centers
            Of their bounding spheres in the world, shape (N, 3).
        """
        self._dots = []
        burning = np.flatnonzero(self._rig.levels > 1e-4)
        if not len(burning):
            return
        solid = np.flatnonzero(~scene.transparent)
        self._framebuffer.use()
        self._framebuffer.viewport = (0, 0, *self._side)
        self._framebuffer.clear(depth=1.0)
        for beam in burning.tolist():
            clip = self._clip_from_world(beam)
            seen = solid[spheres_in_view(clip, centers[solid], scene.radii[solid])]
            self._framebuffer.viewport = (2 * beam, 0, 2, 2)
            for number, matrix in zip(seen.tolist(), column_major(clip @ model[seen])):
                self._depth["clip_from_model"].write(matrix.tobytes())
                scene.drawables[number].mesh.array(self._depth).render()
        content = self._framebuffer.read(
            viewport=(0, 0, *self._side), components=1, attachment=-1, dtype="f4"
        )
        depths = np.frombuffer(content, dtype=np.float32).reshape(self._side[::-1])
        for beam in burning.tolist():
            rays = depths[:, 2 * beam : 2 * beam + 2].astype(np.float64)
            if rays.min() < 1.0:
                self._dots.append(self._dot(beam, rays))

    def _clip_from_world(self, beam: int) -> np.ndarray:
        """Project along a beam, in parallel; shape (4, 4)."""
        axes, reach = self._rig.axes[beam], self._rig.reaches[beam]
        scale = np.array([0.5 / _SPREAD, 0.5 / _SPREAD, 2.0 / reach])
        clip = np.eye(4)
        clip[:3, :3] = scale[:, None] * axes
        clip[:3, 3] = -scale * (axes @ self._rig.positions[beam]) - (0.0, 0.0, 1.0)
        return clip

    def _dot(self, beam: int, rays: np.ndarray) -> _Dot:
        """Lay a dot on what four rays have met, by their depths: 0 to 1, which is nothing."""
        right, down, forward = self._rig.axes[beam]
        lengths = self._rig.reaches[beam] * rays
        slopes = np.array([lengths[:, 1] - lengths[:, 0], lengths[1] - lengths[0]]).mean(axis=1)
        slopes /= 2.0 * _SPREAD
        length = float(lengths.mean())
        if rays.max() >= 1.0 or np.abs(slopes).max() > _STEEPEST:
            length, slopes = float(lengths.min()), np.zeros(2)
        across = unit(right + slopes[0] * forward)
        along = down + slopes[1] * forward
        along = unit(along - (along @ across) * across)
        light = self._rig.levels[beam] * self._rig.lights[beam]
        return _Dot(self._rig.positions[beam] + length * forward, across, along, light)

    def spots(
        self, camera: PinholeCamera, optical_in_world: np.ndarray, exposure: float, coarse: bool
    ) -> List[np.ndarray]:
        """Show the dots to a camera, as `Spots` draws them.

        Parameters
        ----------
        camera, optical_in_world, exposure, coarse
            As for `Renderer.render`.
        """
        forward, eye = optical_in_world[:3, 2], optical_in_world[:3, 3]
        shown = []
        for middle, across, along, light in self._dots:
            to_eye = eye - middle
            distance = float(np.linalg.norm(to_eye))
            ahead = -float(to_eye @ forward)
            if ahead <= 0.0:
                continue
            lift = _LIFT + _LIFT_BY_DISTANCE * distance
            if coarse:
                lift += max(_LIFT_COARSE, COARSE_PIXELS * distance / camera.focal_length)
            radius = max(_RADIUS, _LEAST_RADIUS * ahead / camera.focal_length)
            place = middle + to_eye * min(lift / distance, 0.5)
            shown.append(spot(place, radius * across, radius * along, exposure * light))
        return shown
