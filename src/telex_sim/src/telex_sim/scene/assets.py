"""Meshes and textures that scenes name: found, checked, and made fit for physics."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Callable, Optional, Tuple

import numpy as np

from telex_control.common.file_catalog import package_path as path_of_package
from telex_control.common.params import ConfigError

from .addresses import AddressError, PackagePath, resolve_address
from .meshes.convex_hull import FlatError, convex_hull
from .meshes.mesh_files import MeshFileError, load_mesh
from .model import Vector3
from .textures.picture_files import TextureFileError, load_texture
from .textures.procedural import TextureNameError, check_texture, is_generated

MOST_BYTES = 64 * 1024 * 1024
"""A larger file of a mesh or a texture is refused unread."""
MOST_TRIANGLES = 100_000
"""PyBullet takes no mesh with many more."""
_REMEMBERED = 256


class Assets:
    """The files of scenes. Safe to use from several threads; what was read once is remembered.

    Parameters
    ----------
    package_path : callable, optional
        Gives the folder of a ROS package; by default as rospack finds it.
    """

    def __init__(self, package_path: Optional[PackagePath] = None) -> None:
        self._package_path = package_path or path_of_package
        self._meshes: Callable = lru_cache(maxsize=_REMEMBERED)(_read_mesh)
        self._hulls: Callable = lru_cache(maxsize=_REMEMBERED)(self._make_hull)
        self._textures: Callable = lru_cache(maxsize=_REMEMBERED)(_read_texture)

    def surface(self, address: str, scale: Vector3) -> Tuple[np.ndarray, np.ndarray]:
        """A mesh as it stands in its file.

        Parameters
        ----------
        address : str
            ``package://`` or ``file://``.
        scale : tuple of 3 floats

        Returns
        -------
        vertices : numpy.ndarray
            Shape (V, 3) (m).
        triangles : numpy.ndarray
            Shape (T, 3), counter-clockwise seen from outside.

        Raises
        ------
        ConfigError
            The file is missing, too large, no mesh, or holds numbers that are none.
        """
        vertices, triangles = self._meshes(*self._file(address))
        if np.prod(scale) < 0.0:
            triangles = triangles[:, ::-1]
        return vertices * np.array(scale), triangles

    def hull(self, address: str, scale: Vector3) -> np.ndarray:
        """Triangles of a mesh's convex hull, shape (M, 3, 3) (m), outside as in `surface`.

        Raises
        ------
        ConfigError
            As for `surface`, or the mesh encloses no volume.
        """
        return self._hulls(*self._file(address), scale)

    def _make_hull(self, path: Path, changed: int, size: int, scale: Vector3) -> np.ndarray:
        vertices, _ = self._meshes(path, changed, size)
        try:
            return convex_hull(vertices * np.array(scale))
        except FlatError as error:
            raise ConfigError(f"mesh {path}: {error}; it cannot be a body that moves") from error

    def check_texture(self, address: str) -> None:
        """Raise a `ConfigError` unless the texture can be drawn."""
        if not address:
            return
        if is_generated(address):
            try:
                check_texture(address)
            except TextureNameError as error:
                raise ConfigError(f"texture {error}") from error
            return
        self._textures(*self._file(address))

    def _file(self, address: str) -> Tuple[Path, int, int]:
        """Path of a file, and what tells whether it has changed."""
        try:
            path = Path(resolve_address(address, self._package_path))
        except AddressError as error:
            # Those who look packages up use several lines.
            raise ConfigError(" ".join(str(error).split())) from error
        try:
            status = path.stat()
        except (OSError, ValueError) as error:
            raise ConfigError(f"{path}: there is no such file") from error
        if not path.is_file():
            raise ConfigError(f"{path}: it is no file")
        if status.st_size > MOST_BYTES:
            raise ConfigError(
                f"{path}: it has {status.st_size} bytes; at most {MOST_BYTES} are read"
            )
        return path, status.st_mtime_ns, status.st_size


def _read_mesh(path: Path, changed: int, size: int) -> Tuple[np.ndarray, np.ndarray]:
    try:
        mesh = load_mesh(path)
    except MeshFileError as error:
        raise ConfigError(f"mesh {error}") from error
    if len(mesh.triangles) > MOST_TRIANGLES:
        raise ConfigError(
            f"mesh {path}: it has {len(mesh.triangles)} triangles; "
            f"at most {MOST_TRIANGLES} are possible"
        )
    if not np.isfinite(mesh.positions).all():
        raise ConfigError(f"mesh {path}: a coordinate is not finite")
    return _merged(mesh.positions.astype(np.float64), mesh.triangles)


def _read_texture(path: Path, changed: int, size: int) -> None:
    """Read all of a picture as the renderer will: its first bytes do not tell whether it is cut."""
    try:
        load_texture(path)
    except TextureFileError as error:
        raise ConfigError(f"texture {error}") from error


def _merged(positions: np.ndarray, triangles: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Make one vertex of those in the same place.

    Unlike `numpy.unique` by rows, this keeps no other thread waiting while it sorts.
    """
    order = np.lexsort(positions.T)
    ordered = positions[order]
    is_new = np.ones(len(ordered), dtype=bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    numbers = np.empty(len(ordered), dtype=np.intp)
    numbers[order] = np.cumsum(is_new) - 1
    return ordered[is_new], numbers[triangles]
