"""The scene's meshes and textures in the memory of whatever renders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Hashable, List, Optional, Sequence, Set, Tuple
from urllib.parse import quote

import moderngl
import numpy as np

from ....scene.addresses import PackagePath, resolve_address
from ....scene.content_store import ContentStore
from ....scene.meshes.mesh_files import MeshFileError, MeshPart, load_mesh, load_parts
from ....scene.meshes.meshes import Mesh
from ....scene.textures.picture_files import load_texture
from ....scene.textures.procedural import generate_texture, is_generated
from ....scene.visual_scene import WORLD, Visual, VisualScene, VisualShape
from ..programs import PICTURE_UNIT, LitProgram
from .batching import Batch, batches, bounding_radius, merge_visuals
from .gpu_mesh import BeltMesh, GpuMesh
from .renewed_cache import RenewedCache


@dataclass(frozen=True)
class Drawable:
    """What one call draws."""

    mesh: GpuMesh
    texture: Optional[moderngl.Texture]
    opacity: float

    @property
    def texture_kind(self) -> Tuple[bool, ...]:
        """What of its texture drivers compile a program anew for: sides that are powers of two."""
        sides = () if self.texture is None else self.texture.size
        return tuple(not side & (side - 1) for side in sides)

    def draw(self, program: LitProgram, detail: int = 0) -> None:
        """Draw it, or a coarser shape of it, where the program has been told that it is."""
        if self.texture is not None:
            self.texture.use(PICTURE_UNIT)
        if program.opaqueness != self.opacity:
            program.opaqueness = program.opacity.value = self.opacity
        self.mesh.array(program.program, detail).render()
        program.has_drawn = True


class GpuScene:
    """Everything to be drawn; meshes and textures outlive a change of the scene that needs them.

    Parameters
    ----------
    anisotropy
        Of the textures.
    shadow_detail
        What is smaller need not show in shadows (m).
    package_path
        Gives the directory of a ROS package.
    store
        Where content is kept from one start to the next.

    Attributes
    ----------
    drawables
        In no particular order; the arrays below have the same.
    frames
        Number of the frame that each is fixed to, shape (N,).
    centers, radii
        Bounding spheres in their frames (m), shapes (N, 3) and (N,).
    halves
        From these centres to the sides of boxes that they never leave, along the frames' axes (m),
        shape (N, 3).
    boxes
        Their frames from a cube of side 2 that is stretched around each, shape (N, 4, 4).
    casts_shadow, transparent, fixed, textured
        Shape (N,), bool; fixed is what belongs to the world itself and never moves.
    covered
        Whether each never moves and things can stand on it.
    """

    def __init__(
        self,
        context: moderngl.Context,
        anisotropy: float,
        shadow_detail: float,
        package_path: PackagePath,
        store: ContentStore,
    ) -> None:
        self._context = context
        self._store = store
        self._anisotropy = anisotropy
        self._shadow_detail = shadow_detail
        self._package_path = package_path
        self._files: RenewedCache[Mesh] = RenewedCache(lambda _: None)
        self._parts: RenewedCache[List[MeshPart]] = RenewedCache(lambda _: None)
        self._meshes: RenewedCache[GpuMesh] = RenewedCache(lambda mesh: mesh.release())
        self._textures: RenewedCache[moderngl.Texture] = RenewedCache(lambda item: item.release())
        self._frame_count = 0
        self._belts: List[Tuple[BeltMesh, int, int]] = []
        self._arrange([], [], 0)

    def load(self, scene: VisualScene) -> List[str]:
        """Put a scene in the place of the present one.

        Returns
        -------
        list of str
            What could not be loaded, and why. A visual without its mesh is left out, one without
            its texture keeps its colour; the rest of the scene is there.
        """
        caches: Sequence[RenewedCache] = (
            self._files,
            self._parts,
            self._meshes,
            self._textures,
        )
        for cache in caches:
            cache.begin()
        problems: Set[str] = set()
        visuals = [
            part
            for visual in scene.visuals
            if self._is_drawable(visual, problems)
            for part in self._with_materials(visual, problems)
        ]
        drawables: List[Drawable] = []
        groups = batches(
            visuals, lambda visual: bounding_radius(visual, lambda item: self._radius(item))
        )
        for batch in groups:
            texture = self._texture_or_none(batch, problems)
            drawables.append(Drawable(self._mesh(batch, problems), texture, batch.opacity))
        for cache in caches:
            cache.end()
        number = {name: index for index, name in enumerate(scene.frames)}
        self._belts = [
            (drawable.mesh, number[batch.frame], number[batch.drive])
            for drawable, batch in zip(drawables, groups)
            if isinstance(drawable.mesh, BeltMesh)
        ]
        self._arrange(
            [(drawable, batch) for drawable, batch in zip(drawables, groups)],
            [number[batch.frame] for batch in groups],
            len(scene.frames),
        )
        return sorted(problems)

    def model_matrices(self, frames_in_world: np.ndarray) -> np.ndarray:
        """World from the frame of each drawable, shape (N, 4, 4).

        Raises
        ------
        ValueError
            When the number of frames is not the scene's.
        """
        if len(frames_in_world) != self._frame_count:
            raise ValueError(
                f"poses of {len(frames_in_world)} frames for a scene of {self._frame_count}"
            )
        return frames_in_world[self.frames]

    def run_belts(self, frames_in_world: np.ndarray) -> None:
        """Move the belts to where the wheels that drive them have turned."""
        for mesh, frame, drive in self._belts:
            mesh.run(frames_in_world[frame], frames_in_world[drive])

    def _arrange(
        self, items: Sequence[Tuple[Drawable, Batch]], frames: Sequence[int], count: int
    ) -> None:
        self._frame_count = count
        self.drawables = tuple(drawable for drawable, _ in items)
        self.frames = np.array(frames, dtype=np.intp)
        self.centers = np.array([item.mesh.center for item in self.drawables]).reshape(-1, 3)
        self.radii = np.array([item.mesh.radius for item in self.drawables])
        meshes = [item.mesh for item in self.drawables]
        halves = np.array([mesh.half for mesh in meshes]).reshape(-1, 3)
        self.halves = halves + np.array([mesh.beyond for mesh in meshes])[:, None]
        self.boxes = np.tile(np.eye(4), (len(items), 1, 1))
        self.boxes[:, :3, 3] = self.centers
        self.boxes[:, range(3), range(3)] = halves
        self.casts_shadow = np.array([batch.casts_shadow for _, batch in items], dtype=bool)
        self.textured = np.array([item.texture is not None for item in self.drawables], dtype=bool)
        self.fixed = np.array([batch.frame == WORLD for _, batch in items], dtype=bool)
        self.covered = [batch.frame == WORLD and batch.carries for _, batch in items]
        self.transparent = np.array([batch.opacity < 1.0 for _, batch in items], dtype=bool)

    def _is_drawable(self, visual: Visual, problems: Set[str]) -> bool:
        if visual.color[3] == 0.0:
            return False
        if visual.shape is VisualShape.MESH:
            try:
                self._file(visual)
            except (OSError, ValueError) as error:
                problems.add(f"{visual.label} is left out: {error}")
                return False
        return True

    def _with_materials(self, visual: Visual, problems: Set[str]) -> List[Visual]:
        """Show each part of a mesh with materials of its own in its colour and texture."""
        if visual.shape is not VisualShape.MESH or not visual.mesh_materials:
            return [visual]
        try:
            parts = self._file_parts(visual)
        except MeshFileError as error:
            problems.add(f"{visual.label} has no materials of its own: {error}")
            return [replace(visual, mesh_materials=False)]
        shown = []
        for number, part in enumerate(parts):
            texture = visual.texture
            if part.texture is not None:
                texture = f"file://{quote(str(part.texture.resolve()))}"
            color = visual.color if part.color is None else part.color
            shown.append(replace(visual, part=number, color=color, texture=texture))
        return [part for part in shown if part.color[3] > 0.0]

    def _file_parts(self, visual: Visual) -> List[MeshPart]:
        path = self._path(visual)
        return self._parts.get((path, _last_change(path)), lambda: load_parts(path))

    def _file(self, visual: Visual) -> Mesh:
        if visual.part >= 0:
            return self._file_parts(visual)[visual.part].mesh
        path = self._path(visual)
        return self._files.get(
            (path, _last_change(path)), lambda: Mesh(*self._store.get(load_mesh, path))
        )

    def _path(self, visual: Visual) -> Path:
        return Path(resolve_address(visual.mesh, self._package_path))

    def _radius(self, visual: Visual) -> float:
        reach = np.abs(self._file(visual).positions).max(axis=0)
        return float(np.linalg.norm(reach * visual.size))

    def _mesh(self, batch: Batch, problems: Set[str]) -> GpuMesh:
        worn = batch.frame != WORLD
        files = tuple(
            _last_change(self._path(visual))
            for visual in batch.visuals
            if visual.shape is VisualShape.MESH
        )

        def upload() -> GpuMesh:
            files = [
                self._file(visual) if visual.shape is VisualShape.MESH else None
                for visual in batch.visuals
            ]
            vertices, triangles = self._store.get(merge_visuals, batch.content, files, worn)
            what = (self._context, vertices, triangles, self._shadow_detail, self._store)
            if batch.drive:
                try:
                    return BeltMesh(*what)
                except ValueError as error:
                    problems.add(f"{batch.visuals[0].label} does not run: {error}")
            return GpuMesh(*what)

        return self._meshes.get((batch.content, files, worn), upload)

    def _texture_or_none(self, batch: Batch, problems: Set[str]) -> Optional[moderngl.Texture]:
        if not batch.texture:
            return None
        try:
            return self._texture(batch.texture)
        except (OSError, ValueError) as error:
            for visual in batch.visuals:
                problems.add(f"{visual.label} has no texture: {error}")
            return None

    def _texture(self, address: str) -> moderngl.Texture:
        if is_generated(address):
            return self._textures.get(
                address,
                lambda: self._upload_texture(self._store.get(generate_texture, address)),
            )
        path = Path(resolve_address(address, self._package_path))
        key: Hashable = (path, _last_change(path))
        return self._textures.get(key, lambda: self._upload_texture(load_texture(path)))

    def _upload_texture(self, picture: np.ndarray) -> moderngl.Texture:
        height, width = picture.shape[:2]
        # OpenGL counts rows from below.
        rows = np.ascontiguousarray(picture[::-1])
        texture = self._context.texture((width, height), 3, rows.tobytes(), alignment=1)
        texture.build_mipmaps()
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        texture.anisotropy = self._anisotropy
        return texture


def _last_change(path: Path) -> int:
    """Tell versions of a file apart, so that one that was made anew is read anew."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        # The reader will say what is wrong.
        return 0
