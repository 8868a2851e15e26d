"""The scene's meshes and textures in the memory of whatever renders."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Hashable, List, Optional, Tuple, TypeVar

import moderngl
import numpy as np

from .addresses import AddressError, PackagePath, resolve_address
from .mesh_files import MeshFileError, load_mesh
from .meshes import Mesh, primitive_mesh
from .scene import CHECKER, Placement, Scene, Shape, Visual
from .textures import TextureFileError, checker_texture, load_texture

Resource = TypeVar("Resource", "GpuMesh", moderngl.Texture)


@dataclass(frozen=True)
class GpuMesh:
    """A mesh, ready to be drawn by each of the programs.

    Attributes
    ----------
    plain, textured, depth
        Vertex arrays; ``textured`` is None for a mesh without texture coordinates.
    center, radius
        Bounding sphere in the mesh's own coordinates (m).
    """

    plain: moderngl.VertexArray
    textured: Optional[moderngl.VertexArray]
    depth: moderngl.VertexArray
    buffers: Tuple[moderngl.Buffer, ...]
    center: np.ndarray
    radius: float

    def release(self) -> None:
        """Free the memory."""
        for array in (self.plain, self.textured, self.depth):
            if array is not None:
                array.release()
        for buffer in self.buffers:
            buffer.release()


@dataclass(frozen=True)
class Drawable:
    """A visual with its mesh and texture.

    Attributes
    ----------
    color
        Linear red, green, blue, and alpha: four float32, as uniforms are written.
    """

    visual: Visual
    mesh: GpuMesh
    texture: Optional[moderngl.Texture]
    color: bytes

    @property
    def surface(self) -> moderngl.VertexArray:
        """What draws it in the light."""
        return self.mesh.textured if self.texture and self.mesh.textured else self.mesh.plain

    @property
    def uv_scale(self) -> float:
        """Repetitions of the texture per unit of the mesh's texture coordinates."""
        # Those of a file are laid out for its texture already.
        return 1.0 if self.visual.shape is Shape.MESH else 1.0 / self.visual.texture_scale

    @property
    def transparent(self) -> bool:
        """Whether what is behind shines through."""
        return self.visual.color[3] < 1.0


class GpuScene:
    """Everything to be drawn; meshes and textures outlive a change of the scene that needs them.

    Parameters
    ----------
    context
        To draw with.
    programs
        That draw surfaces without texture, with texture, and depth alone.
    anisotropy
        Of the textures.
    package_path
        Gives the directory of a ROS package.
    """

    def __init__(
        self,
        context: moderngl.Context,
        programs: Tuple[moderngl.Program, moderngl.Program, moderngl.Program],
        anisotropy: float,
        package_path: PackagePath,
    ) -> None:
        self._context = context
        self._plain, self._textured, self._depth = programs
        self._anisotropy = anisotropy
        self._package_path = package_path
        self._meshes: Dict[Hashable, GpuMesh] = {}
        self._textures: Dict[Hashable, moderngl.Texture] = {}
        self.drawables: Tuple[Drawable, ...] = ()
        self.placement = Placement((), ())
        self.centers = np.zeros((0, 3))
        self.radii = np.zeros(0)
        self.casts_shadow = np.zeros(0, dtype=bool)
        self.transparent = np.zeros(0, dtype=bool)

    def load(self, scene: Scene) -> List[str]:
        """Put a scene in the place of the present one.

        Returns
        -------
        list of str
            What could not be loaded, and why. A visual without its mesh is left out, one without
            its texture keeps its colour; the rest of the scene is there.
        """
        old_meshes, self._meshes = self._meshes, {}
        old_textures, self._textures = self._textures, {}
        drawables: List[Drawable] = []
        problems: List[str] = []
        for visual in scene.visuals:
            if visual.color[3] == 0.0:
                continue
            try:
                mesh = self._mesh(visual, old_meshes)
            except (AddressError, MeshFileError) as error:
                problems.append(f"{visual.label} is left out: {error}")
                continue
            texture, problem = self._texture_or_problem(visual, mesh, old_textures)
            if problem:
                problems.append(f"{visual.label} has no texture: {problem}")
            drawables.append(Drawable(visual, mesh, texture, _linear_color(visual)))
        _release_unused(old_meshes, self._meshes)
        _release_unused(old_textures, self._textures)
        self._arrange(scene, drawables)
        return problems

    def _arrange(self, scene: Scene, drawables: List[Drawable]) -> None:
        self.drawables = tuple(drawables)
        visuals = [drawable.visual for drawable in drawables]
        self.placement = Placement(scene.frames, visuals)
        self.centers = np.array([item.mesh.center for item in drawables]).reshape(-1, 3)
        self.radii = np.array([item.mesh.radius for item in drawables])
        self.casts_shadow = np.array([visual.casts_shadow for visual in visuals], dtype=bool)
        self.transparent = np.array([item.transparent for item in drawables], dtype=bool)

    def _mesh(self, visual: Visual, old: Dict[Hashable, GpuMesh]) -> GpuMesh:
        if visual.shape is not Shape.MESH:
            key: Hashable = (visual.shape, visual.size)
            return _cached(key, old, self._meshes, lambda: self._upload(primitive_mesh(visual)))
        path = Path(resolve_address(visual.mesh, self._package_path))
        return _cached(
            (path, _last_change(path), visual.size),
            old,
            self._meshes,
            lambda: self._upload(load_mesh(path).scaled(visual.size)),
        )

    def _upload(self, mesh: Mesh) -> GpuMesh:
        context = self._context
        triangles = context.buffer(np.ascontiguousarray(mesh.triangles, dtype=np.int32).tobytes())
        positions = context.buffer(np.ascontiguousarray(mesh.positions).tobytes())
        normals = context.buffer(np.ascontiguousarray(mesh.normals).tobytes())
        buffers = [triangles, positions, normals]
        lit = [(positions, "3f", "in_position"), (normals, "3f", "in_normal")]
        textured = None
        if mesh.uvs is not None:
            uvs = context.buffer(np.ascontiguousarray(mesh.uvs).tobytes())
            buffers.append(uvs)
            textured = context.vertex_array(self._textured, [*lit, (uvs, "2f", "in_uv")], triangles)
        center, radius = mesh.bounding_sphere()
        return GpuMesh(
            plain=context.vertex_array(self._plain, lit, triangles),
            textured=textured,
            depth=context.vertex_array(self._depth, lit[:1], triangles),
            buffers=tuple(buffers),
            center=center,
            radius=radius,
        )

    def _texture_or_problem(
        self, visual: Visual, mesh: GpuMesh, old: Dict[Hashable, moderngl.Texture]
    ) -> Tuple[Optional[moderngl.Texture], str]:
        if not visual.texture:
            return None, ""
        if mesh.textured is None:
            return None, "its mesh has no texture coordinates"
        try:
            return self._texture(visual.texture, old), ""
        except (AddressError, TextureFileError) as error:
            return None, str(error)

    def _texture(self, address: str, old: Dict[Hashable, moderngl.Texture]) -> moderngl.Texture:
        if address == CHECKER:
            return _cached(
                CHECKER, old, self._textures, lambda: self._upload_texture(checker_texture())
            )
        path = Path(resolve_address(address, self._package_path))
        return _cached(
            (path, _last_change(path)),
            old,
            self._textures,
            lambda: self._upload_texture(load_texture(path)),
        )

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


def _cached(
    key: Hashable,
    old: Dict[Hashable, Resource],
    new: Dict[Hashable, Resource],
    make: Callable[[], Resource],
) -> Resource:
    """Find the resource of this key in this scene or in the one before, or make it."""
    if key not in new:
        new[key] = old[key] if key in old else make()
    return new[key]


def _release_unused(old: Dict[Hashable, Resource], new: Dict[Hashable, Resource]) -> None:
    for key, resource in old.items():
        if key not in new:
            resource.release()


def _linear_color(visual: Visual) -> bytes:
    """Convert the colour to the shaders' linear terms (a gamma of 2)."""
    red, green, blue, alpha = visual.color
    return np.array([red**2, green**2, blue**2, alpha], dtype=np.float32).tobytes()
