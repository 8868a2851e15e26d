"""Draws the scene as a camera sees it."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import moderngl
import numpy as np

from telex_control.common.geometry.matrices import inverse

from ...scene.addresses import PackagePath
from ...scene.content_store import ContentStore
from ...scene.visual_scene import Daylight, VisualScene
from ..optics.pinhole import PinholeCamera
from .culling import boxes_in_view, spheres_in_view, spheres_in_world
from .frame_target import FrameTarget
from .kept_pictures import KeptPictures
from .light.daylight import Lighting, light_uniforms
from .light.glare import glare
from .light.lamp_shadows import LampShadows
from .light.lamps import NEAREST, LampRig
from .light.laser_dots import LaserDots
from .light.sky_cover import SkyCover
from .light.spots import Spots
from .light.sun_shadows import ShadowMap
from .meshes.gpu_mesh import COARSE_PIXELS, DETAILS
from .meshes.gpu_scene import Drawable, GpuScene
from .programs import (
    COVER_MAP_UNIT,
    LAMP_MAP_UNIT,
    SHADOW_MAP_UNIT,
    LitProgram,
    LitPrograms,
    SkyProgram,
    column_major,
    depth_program,
)
from .quality import TIERS, Quality
from .shaders import LitVariant
from .smoothing import smooth_edges

# Sizes of pictures whose memory is kept.
_MOST_TARGETS = 12


class Renderer:
    """Renders one scene for any number of cameras.

    All calls must come from the thread that made the context. For each set of pictures of the same
    poses: ``place``, then ``render`` for each camera. Shadows are cast by the first picture of a
    set, for all of it; nothing is drawn for poses that nobody looks at, nor anew where nothing has
    moved.

    Parameters
    ----------
    context
        OpenGL 3.3 or later; it is the renderer's alone.
    package_path
        Gives the directory of a ROS package, for package:// addresses.
    store
        Where content of scenes is kept; None: nowhere.

    Attributes
    ----------
    on_card : bool
        Whether pictures are made in the quality that graphics cards have time for.
    repeats : bool
        Whether the last picture was what the view before it had shown: nothing has moved.
    """

    def __init__(
        self,
        context: moderngl.Context,
        quality: Quality,
        lighting: Lighting,
        package_path: PackagePath,
        store: Optional[ContentStore] = None,
    ) -> None:
        self._context = context
        self._quality = quality
        self.on_card = quality is TIERS["gpu"]
        self._lighting = lighting
        lamp_lookups = quality.lamp_lookups if quality.lamp_shadows else 0
        self._programs = LitPrograms(context, quality.shadow_lookups, lamp_lookups)
        self._skies = {fog: SkyProgram(context, fog) for fog in (False, True)}
        depth = depth_program(context)
        self._scene = GpuScene(
            context,
            quality.anisotropy,
            quality.shadow_detail,
            package_path,
            store or ContentStore(),
        )
        radius = lighting.shadow_radius
        self._shadows = ShadowMap(context, depth, radius, quality.shadow_map_size)
        self._lamp_shadows = LampShadows(
            context,
            depth,
            max(quality.lamp_shadows, 1),
            quality.lamp_map_size,
            quality.shadow_softness,
        )
        self._cover = SkyCover(context, depth)
        self._dots = LaserDots(context)
        self._spots = Spots(context)
        self._targets: OrderedDict[Tuple[int, int], FrameTarget] = OrderedDict()
        # Of what surfaces there are something to draw with, by their kind.
        self._samples: Dict[int, Dict[Tuple[bool, ...], Drawable]] = {}
        # Variants of programs by the number of lamps that they have room for, then by kind.
        self._rooms: Dict[int, Tuple[LitVariant, ...]] = {}
        self._cold: List[Tuple[LitVariant, List[Drawable]]] = []
        self._shown = False
        self._model = np.zeros((0, 4, 4))
        self._centers = np.zeros((0, 3))
        self._focus = np.zeros(3)
        self._frames_in_world = np.zeros((0, 4, 4))
        self._moved = False
        self._cast = False
        self.repeats = False
        self._kept = KeptPictures()
        self._depth_source: Optional[FrameTarget] = None
        # Picture that was given again, as `_draw` takes it: its depths are those of another one.
        self._not_drawn: Optional[Tuple[PinholeCamera, np.ndarray, float, bool]] = None
        self._take_light(VisualScene(0, (), ()))

    def load_scene(self, scene: VisualScene) -> List[str]:
        """Take over a scene; ``place`` must follow before the next picture.

        Returns
        -------
        list of str
            What could not be loaded, and why; the rest is there.
        """
        self._take_light(scene)
        problems = self._scene.load(scene)
        self._samples = {}
        for drawable, covered in zip(self._scene.drawables, self._scene.covered):
            alike = self._samples.setdefault(_kind(drawable.texture is not None, covered), {})
            # Any surface does, but what its texture is like matters.
            alike[drawable.texture_kind] = drawable
        self._cold = [
            (variants[kind], list(alike.values()))
            for variants in self._rooms.values()
            for kind, alike in self._samples.items()
        ]
        self._shown = False
        return problems

    def _variants(self, room: int) -> Tuple[LitVariant, ...]:
        """Return the programs' variants with room for so many lamps, by `_kind`.

        Where the sun shines, only floors and the like show what covers them.
        """
        bare = replace(self._base, cover=self._base.cover and not self._base.sun, lamps=room)
        return tuple(
            replace(base, textured=textured)
            for base in (bare, replace(bare, cover=self._base.cover))
            for textured in (False, True)
        )

    def _room_for(self, lamps: int, most: int) -> int:
        """Choose a number of lamps that programs have room for.

        Parameters
        ----------
        lamps
            That light a surface.
        most
            That light any surface of the picture: while smaller programs are still to be compiled,
            one for so many draws all.
        """
        last = next(room for room in self._rooms if room >= most)
        return next(
            room
            for room, variants in self._rooms.items()
            if room == last
            or (
                lamps <= room
                and all(self._programs.has_drawn(variants[kind]) for kind in self._samples)
            )
        )

    def _warm_up(self) -> None:
        """Use the next program once that has not been used yet.

        Drivers compile a program when it first draws; many at once would interrupt the pictures.
        """
        while self._cold:
            variant, drawables = self._cold.pop(0)
            if self._programs.has_drawn(variant):
                continue
            self._begin_pass()
            self._target(1, 1).begin()
            self._use_maps()
            for drawable in drawables:
                drawable.draw(self._programs.get(variant))
            return

    def _take_light(self, scene: VisualScene) -> None:
        daylight: Daylight = scene.daylight
        sun = any(daylight.sun)
        # Lamps that can be switched are the robot's, and do not shine from above.
        light_above = daylight.ambient > 0.0 or not all(lamp.name for lamp in scene.lamps)
        if sun:
            self._shadows.invalidate(daylight.to_sun)
        self._cover.invalidate()
        self._lamp_shadows.invalidate()
        self._cast = False
        self._kept.forget()
        self._base = LitVariant(
            textured=False,
            sun=sun,
            cover=light_above,
            fog=daylight.visibility > 0.0,
            lamps=0,
        )
        self._sky = self._skies[self._base.fog]
        shining = [lamp for lamp in scene.lamps if not lamp.beam]
        self._lamps = LampRig(shining, scene.frames, self._lighting.sun)
        self._rooms = {
            room: self._variants(room) for room in _rooms(len(self._lamps), self._quality.lamps)
        }
        beams = [lamp for lamp in scene.lamps if lamp.beam]
        self._dots.load(LampRig(beams, scene.frames, self._lighting.sun))
        light = light_uniforms(self._lighting, daylight)
        self._sky.set(light)
        self._uniforms = {name: light.pop(name) for name in ("sky_ambient", "ground_ambient")}
        # Half the width of soft edges, as a share of the shadow map's side.
        softness = self._quality.shadow_softness / self._quality.shadow_map_size
        unused = self._programs.take_light(
            {
                **{name: tuple(np.atleast_1d(value).tolist()) for name, value in light.items()},
                "lamp_nearest2": (NEAREST**2,),
                "lamp_tile": self._lamp_shadows.tile(),
                "shadow_softness": (softness,),
            }
        )
        for program in unused:
            for drawable in self._scene.drawables:
                drawable.mesh.forget(program)
            program.release()

    def set_lamp_levels(self, levels: Mapping[str, float]) -> None:
        """Dim the lamps that have names: 0 is off, 1 full."""
        before, dots = self._lamps.levels, self._dots.levels
        self._lamps.set_levels(levels)
        self._dots.set_levels(levels)
        if not np.array_equal(before, self._lamps.levels):
            self._cast = False
            self._kept.forget()
        if not np.array_equal(dots, self._dots.levels):
            self._moved = True
            self._kept.forget()

    def place(self, frames_in_world: np.ndarray, focus: np.ndarray, recast: bool = True) -> None:
        """Move everything to where it is now.

        Parameters
        ----------
        frames_in_world
            Poses of the scene's frames, shape (frames, 4, 4).
        focus
            Point in the world around which shadows matter (m), shape (3,).
        recast
            Whether shadows move as well; those that the scene does not have yet come anyway.

        Raises
        ------
        ValueError
            When the number of frames is not the scene's.
        """
        self._model = self._scene.model_matrices(frames_in_world)
        self._centers = spheres_in_world(self._model, self._scene.centers)
        self._frames_in_world = frames_in_world
        self._moved = True
        self._lamps.place(frames_in_world)
        self._dots.place(frames_in_world)
        self._focus = np.asarray(focus, dtype=np.float64)
        self._cast = self._cast and not recast
        self._kept.place(frames_in_world, self._focus, recast)

    def _prepare(self) -> None:
        """Do what all pictures of these poses share: belts, the dots of lasers, and shadows."""
        if self._moved:
            self._moved = False
            self._scene.run_belts(self._frames_in_world)
            self._begin_pass()
            self._dots.update(self._scene, self._model, self._centers)
        if self._cast:
            return
        self._cast = True
        self._begin_pass()
        what = (self._scene, self._model, self._centers)
        if self._base.cover:
            self._cover.update(*what, self._focus)
            self._uniforms["cover_place"] = self._cover.place()
        if self._quality.lamp_shadows:
            self._lamp_shadows.choose(self._lamps, self._focus)
        if not self._base.sun:
            return
        self._shadows.update(*what, self._focus)
        # No look-up of the ring, nor the pixel that it falls into, may dip into the surface itself.
        offset = (1.0 + self._quality.shadow_softness) * self._shadows.texel
        self._uniforms["normal_offset"] = np.array(offset, dtype=np.float32)
        self._uniforms.update(self._shadows.uniforms())

    def render(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        exposure: float = 1.0,
        coarse: bool = False,
    ) -> np.ndarray:
        """Take a picture.

        Parameters
        ----------
        optical_in_world
            Pose of the optical frame, shape (4, 4).
        exposure
            Factor on all light; 1 suits a bright day.
        coarse
            Whether shapes are coarser, which takes less time.

        Returns
        -------
        numpy.ndarray
            RGBA, shape (height, width, 4), uint8, rows from above. The memory is the renderer's:
            the next picture of that size overwrites it.
        """
        if self._shown:  # the first picture of a scene is not to wait for programs of others
            self._warm_up()
        self._shown = True
        self._prepare()
        kept = self._kept.find(camera, optical_in_world, exposure, coarse)
        self.repeats = kept is not None
        if kept is not None:
            self._not_drawn = (camera, optical_in_world, exposure, coarse)
            return self._target(camera.width, camera.height).lend(kept)
        picture = self._draw(camera, optical_in_world, exposure, coarse)
        self._kept.keep(camera, optical_in_world, exposure, picture, coarse)
        return picture

    def _draw(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        exposure: float,
        coarse: bool = False,
    ) -> np.ndarray:
        """Draw what `render` returns."""
        self._not_drawn = None
        clip_from_optical = camera.clip_from_optical()
        clip_from_world = clip_from_optical @ inverse(optical_in_world)
        eye = optical_in_world[:3, 3]
        solid, transparent = self._visible(clip_from_world, eye)
        uniforms = {
            "clip_from_world": column_major(clip_from_world),
            "eye": eye.astype(np.float32),
            "exposure": np.array(exposure, dtype=np.float32),
        }
        drawing = self._drawing(
            clip_from_world, eye, uniforms, np.concatenate([solid, transparent])
        )
        target = self._target(camera.width, camera.height)
        self._begin_pass()
        framebuffer = target.begin()
        self._use_maps()
        details = self._details(camera, eye, coarse)
        drawing.draw(solid, details)
        self._sky.draw(clip_from_optical, optical_in_world, exposure)
        framebuffer.depth_mask = False
        spots = self._dots.spots(camera, optical_in_world, exposure, coarse)
        spots += glare(self._lamps, clip_from_world, optical_in_world, exposure)
        self._spots.draw(clip_from_world, spots)
        framebuffer.depth_mask = True
        if transparent.size:
            self._context.enable(moderngl.BLEND)
            framebuffer.depth_mask = False
            drawing.draw(transparent, details)
            framebuffer.depth_mask = True
        self._depth_source = target
        picture = target.read()
        return smooth_edges(picture) if self._quality.edge_smoothing else picture

    def depth(self, camera: PinholeCamera) -> np.ndarray:
        """Measure how far what the last picture shows is; to be called directly after `render`.

        Returns
        -------
        numpy.ndarray
            Distances along the optical axis (m), shape (height, width), float32; infinite where
            nothing is nearer than the camera's ``far`` (REP 118). What is transparent is seen
            through.

        Raises
        ------
        ValueError
            When the last picture was of another size, or there is none.
        """
        if self._not_drawn is not None:
            self._draw(*self._not_drawn)
        size = (camera.width, camera.height)
        if self._depth_source is None or self._depth_source is not self._targets.get(size):
            raise ValueError(f"the last picture was not of {camera.width}x{camera.height} pixels")
        return self._depth_source.read_depth(camera.near, camera.far)

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

    def _use_maps(self) -> None:
        self._shadows.use(SHADOW_MAP_UNIT)
        self._lamp_shadows.use(LAMP_MAP_UNIT)
        self._cover.use(COVER_MAP_UNIT)

    def _target(self, width: int, height: int) -> FrameTarget:
        size = (width, height)
        if size not in self._targets:
            if len(self._targets) >= _MOST_TARGETS:
                _, oldest = self._targets.popitem(last=False)
                oldest.release()
            samples = min(self._quality.samples, self._context.max_samples)
            self._targets[size] = FrameTarget(self._context, width, height, samples)
        self._targets.move_to_end(size)
        return self._targets[size]

    def _visible(
        self, clip_from_world: np.ndarray, eye: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray]:
        """Numbers of the drawables in view: the solid from near to far, the transparent from far.

        What is behind something solid then costs little.
        """
        scene = self._scene
        seen = np.flatnonzero(spheres_in_view(clip_from_world, self._centers, scene.radii))
        # A camera is within the sphere of what it is fixed to, and sees nothing of most of it.
        axes, halves = self._model[seen, :3, :3], scene.halves[seen]
        seen = seen[boxes_in_view(clip_from_world, self._centers[seen], axes, halves)]
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

    def _details(self, camera: PinholeCamera, eye: np.ndarray, coarse: bool) -> np.ndarray:
        """Choose how coarse the shape of each drawable may be, shape (N,); see `GpuMesh.array`."""
        scene = self._scene
        if not coarse:
            return np.zeros(len(scene.drawables), dtype=np.intp)
        nearest = np.linalg.norm(self._centers - eye, axis=1) - scene.radii
        details = np.searchsorted(DETAILS, COARSE_PIXELS / camera.focal_length * nearest)
        # A texture that is pulled about is seen from near.
        return np.maximum(details, np.where(scene.textured, 0, 1))

    def _drawing(
        self,
        clip_from_world: np.ndarray,
        eye: np.ndarray,
        view: Mapping[str, np.ndarray],
        numbers: np.ndarray,
    ) -> _Drawing:
        """Prepare to draw some of the drawables as a camera sees them, by uniforms of its view."""
        chosen = self._lamps.choose(clip_from_world, eye, self._quality.lamps)
        if self._quality.lamp_shadows:
            self._begin_pass()
            self._lamp_shadows.update(
                self._scene, self._model, self._centers, self._lamps, chosen.numbers
            )
        uniforms = {**self._uniforms, **view}
        for name in ("sky_ambient", "ground_ambient"):
            uniforms[name] = uniforms[name] + chosen.rest.astype(np.float32)
        # Each surface is drawn with the lamps that reach it alone: every one takes time.
        if len(chosen.numbers):
            radii = self._scene.radii[numbers]
            reached = self._lamps.reach(chosen.numbers, self._centers[numbers], radii)
            masks, mask_of = np.unique(reached, axis=0, return_inverse=True)
        else:
            masks, mask_of = np.zeros((1, 0), dtype=bool), np.zeros(len(numbers), dtype=np.intp)
        groups = []
        counts = masks.sum(axis=1)
        most = int(counts.max(initial=0))
        for mask, count in zip(masks, counts.tolist()):
            room = self._room_for(count, most)
            lamps = chosen.numbers[mask]
            values: Dict[str, np.ndarray] = {}
            if room:
                values.update(self._lamps.uniforms(lamps, chosen.levels[mask], room))
                values.update(self._lamp_shadows.uniforms(self._lamps, lamps, room))
            groups.append(_LampGroup(self._rooms[room], values))
        group_of = dict(zip(numbers.tolist(), mask_of.reshape(-1).tolist()))
        return _Drawing(self._scene, self._model, self._programs, uniforms, groups, group_of)


class _LampGroup(NamedTuple):
    """What surfaces are drawn with that the same lamps light.

    Attributes
    ----------
    variants
        Of the program, by `_kind`.
    uniforms
        That describe the lamps.
    """

    variants: Tuple[LitVariant, ...]
    uniforms: Mapping[str, np.ndarray]


class _Drawing:
    """Draws surfaces for one picture; programs learn of the picture when they are first used."""

    def __init__(
        self,
        scene: GpuScene,
        model: np.ndarray,
        programs: LitPrograms,
        uniforms: Mapping[str, np.ndarray],
        groups: Sequence[_LampGroup],
        group_of: Mapping[int, int],
    ) -> None:
        self._scene = scene
        self._model = model
        self._programs = programs
        self._uniforms = uniforms
        self._groups = groups
        self._group_of = group_of
        # The group whose lamps each program has at present.
        self._current: Dict[LitVariant, int] = {}
        # What was drawn last: group, kind, and its program.
        self._last: Optional[Tuple[int, int, LitProgram]] = None

    def draw(self, numbers: np.ndarray, details: np.ndarray) -> None:
        """Draw surfaces in the given order, each in its detail of all, shape (N,)."""
        matrices = column_major(self._model[numbers])
        frames, chosen = self._scene.frames[numbers].tolist(), details[numbers].tolist()
        for number, frame, matrix, detail in zip(numbers.tolist(), frames, matrices, chosen):
            drawable = self._scene.drawables[number]
            kind = _kind(drawable.texture is not None, self._scene.covered[number])
            program = self._program(self._group_of[number], kind)
            # Most stand fast, in the same frame.
            if program.frame != frame:
                program.frame = frame
                program.world_from_model.write(matrix.tobytes())
            drawable.draw(program, detail)

    def _program(self, number: int, kind: int) -> LitProgram:
        if self._last is not None and self._last[:2] == (number, kind):
            return self._last[2]
        group = self._groups[number]
        variant = group.variants[kind]
        program = self._programs.get(variant)
        if variant not in self._current:
            program.set(self._uniforms)
            program.frame = None
        if self._current.get(variant) != number:
            program.set(group.uniforms)
            self._current[variant] = number
        self._last = number, kind, program
        return program


def _kind(textured: bool, covered: bool) -> int:
    """Number kinds of surfaces that are drawn by different programs."""
    return 2 * covered + textured


def _rooms(lamps: int, most: int) -> List[int]:
    """Numbers of lamps that there are programs for: only a few, because each has to be compiled."""
    rooms = sorted({room for room in (0, 1, 2, 3, 4, 6, 8) if room < most} | {most})
    enough = next((room for room in rooms if room >= lamps), most)
    return [room for room in rooms if room <= enough]
