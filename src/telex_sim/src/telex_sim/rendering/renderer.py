"""Draws the scene as a camera sees it."""

from __future__ import annotations

from typing import Dict, List, Tuple

import moderngl
import numpy as np

from .addresses import PackagePath
from .camera import PinholeCamera
from .culling import spheres_in_view, spheres_in_world
from .frame_target import FrameTarget
from .gpu_scene import GpuScene
from .lighting import Lighting
from .programs import (
    PICTURE_UNIT,
    SHADOW_MAP_UNIT,
    LitProgram,
    SkyProgram,
    depth_program,
)
from .quality import Quality
from .scene import Scene
from .shadow_map import ShadowMap
from .smoothing import smooth_edges
from .transforms import rigid_inverse


class Renderer:
    """Renders one scene for any number of cameras.

    All calls must come from the thread that made the context. For each set of pictures of the same
    poses: ``place``, then ``render`` for each camera.

    Parameters
    ----------
    context
        OpenGL 3.3 or later; it is the renderer's alone.
    quality, lighting
        What to draw with.
    package_path
        Gives the directory of a ROS package, for package:// addresses.
    """

    def __init__(
        self,
        context: moderngl.Context,
        quality: Quality,
        lighting: Lighting,
        package_path: PackagePath,
    ) -> None:
        self._context = context
        self._quality = quality
        self._plain = LitProgram(context, False, quality.shadow_lookups)
        self._textured = LitProgram(context, True, quality.shadow_lookups)
        self._sky = SkyProgram(context, lighting)
        depth = depth_program(context)
        self._scene = GpuScene(
            context,
            (self._plain.program, self._textured.program, depth),
            quality.anisotropy,
            package_path,
        )
        self._shadows = ShadowMap(context, depth, lighting, quality.shadow_map_size)
        self._targets: Dict[Tuple[int, int], FrameTarget] = {}
        self._model = np.zeros((0, 4, 4))
        self._centers = np.zeros((0, 3))
        for program in (self._plain, self._textured):
            program.set_lighting(lighting, quality.shadow_softness / quality.shadow_map_size)

    def load_scene(self, scene: Scene) -> List[str]:
        """Take over a scene; ``place`` must follow before the next picture.

        Returns
        -------
        list of str
            What could not be loaded, and why; the rest is there.
        """
        self._shadows.invalidate()
        return self._scene.load(scene)

    def place(self, frames_in_world: np.ndarray, focus: np.ndarray) -> None:
        """Move everything to where it is now and cast the shadows.

        Parameters
        ----------
        frames_in_world
            Poses of the scene's frames, shape (frames, 4, 4).
        focus
            Point in the world around which shadows matter (m), shape (3,).

        Raises
        ------
        ValueError
            When the number of frames is not the scene's.
        """
        self._model = self._scene.placement.model_matrices(frames_in_world)
        self._centers = spheres_in_world(self._model, self._scene.centers)
        self._begin_pass()
        self._shadows.update(self._scene, self._model, self._centers, focus)
        view = self._shadows.view
        # No look-up of the ring, nor the pixel that it falls into, may dip into the surface itself.
        normal_offset = (1.0 + self._quality.shadow_softness) * view.texel
        for program in (self._plain, self._textured):
            program.set_shadow(self._shadows.map_from_world(), normal_offset)

    def render(self, camera: PinholeCamera, optical_in_world: np.ndarray) -> np.ndarray:
        """Take a picture.

        Parameters
        ----------
        camera
            Optics and size.
        optical_in_world
            Pose of the optical frame, shape (4, 4).

        Returns
        -------
        numpy.ndarray
            RGBA, shape (height, width, 4), uint8, rows from above. The memory is the renderer's:
            the next picture of that size overwrites it.
        """
        clip_from_optical = camera.clip_from_optical()
        clip_from_world = clip_from_optical @ rigid_inverse(optical_in_world)
        eye = optical_in_world[:3, 3]
        for program in (self._plain, self._textured):
            program.set_view(clip_from_world, eye)
        solid, transparent = self._visible(clip_from_world, eye)
        target = self._target(camera.width, camera.height)
        self._begin_pass()
        framebuffer = target.begin()
        self._shadows.use(SHADOW_MAP_UNIT)
        self._draw(solid)
        self._sky.draw(clip_from_optical, optical_in_world)
        if transparent.size:
            self._context.enable(moderngl.BLEND)
            framebuffer.depth_mask = False
            self._draw(transparent)
            framebuffer.depth_mask = True
        picture = target.read()
        return smooth_edges(picture) if self._quality.edge_smoothing else picture

    def release(self) -> None:
        """Free everything, the context included."""
        self._context.release()

    def _begin_pass(self) -> None:
        context = self._context
        context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        # Cameras and sun look along +z with y down, which turns the triangles' winding round.
        context.front_face = "cw"
        # The sky lies at the greatest depth, where the depth buffer begins.
        context.depth_func = "<="

    def _target(self, width: int, height: int) -> FrameTarget:
        size = (width, height)
        if size not in self._targets:
            samples = min(self._quality.samples, self._context.max_samples)
            self._targets[size] = FrameTarget(self._context, width, height, samples)
        return self._targets[size]

    def _visible(
        self, clip_from_world: np.ndarray, eye: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray]:
        """Numbers of the drawables in view: the solid from near to far, the transparent from far.

        What is behind something solid then costs little.
        """
        scene = self._scene
        seen = np.flatnonzero(spheres_in_view(clip_from_world, self._centers, scene.radii))
        distances = np.linalg.norm(self._centers[seen] - eye, axis=1)
        radii = scene.radii[seen]
        # A sphere around the eye says nothing of where its surface is, only that what is as large
        # as a floor is probably behind everything.
        nearest = np.where(distances > radii, distances - radii, radii)
        solid = ~scene.transparent[seen]
        return (
            seen[solid][np.argsort(nearest[solid])],
            seen[~solid][np.argsort(-distances[~solid])],
        )

    def _draw(self, numbers: np.ndarray) -> None:
        matrices = self._model[numbers].transpose(0, 2, 1).astype(np.float32)
        for number, matrix in zip(numbers, matrices):
            drawable = self._scene.drawables[number]
            program = self._plain
            if drawable.texture is not None:
                program = self._textured
                program.uv_scale.value = drawable.uv_scale
                drawable.texture.use(PICTURE_UNIT)
            program.world_from_model.write(matrix.tobytes())
            program.color.write(drawable.color)
            drawable.surface.render()
