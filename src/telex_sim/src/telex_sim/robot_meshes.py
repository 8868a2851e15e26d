"""The meshes and pictures of a robot, held to the limits that those of scenes have."""

from __future__ import annotations

from pathlib import Path
from typing import Callable

from telex_control.params import ConfigError
from telex_control.urdf_joints import parse_urdf

from .rendering.mesh_files import MeshFileError, load_mesh
from .scene.assets import MOST_BYTES, MOST_TRIANGLES

MOST_COLLISION_TRIANGLES = 60_000
"""Of all meshes that a robot collides by: the loop stands while PyBullet reads them."""


def check_meshes(urdf: str, resolve: Callable[[str], str]) -> None:
    """Refuse a robot with files that are too large.

    Parameters
    ----------
    urdf : str
    resolve : callable
        Turns an address (``package://…``) into a path; raises a ValueError for one that is none.

    Raises
    ------
    ConfigError
        A file is missing or too large, or a mesh to collide by cannot be read or is too fine; the
        message names link and file.
    """
    root = parse_urdf(urdf)
    total = 0
    for link in root.iter("link"):
        where = f"link '{link.get('name', '')}'"
        for element in (*link.iter("mesh"), *link.iter("texture")):
            if element.get("filename"):
                _check_size(where, element.get("filename", ""), resolve)
        for mesh in link.findall("collision/geometry/mesh"):
            total += _triangles(where, _path(where, mesh.get("filename", ""), resolve))
            if total > MOST_COLLISION_TRIANGLES:
                raise ConfigError(
                    f"{where}: with it, the meshes to collide by have {total} triangles; at most "
                    f"{MOST_COLLISION_TRIANGLES} are possible in a robot, and their convex hulls "
                    "would do"
                )


def _path(where: str, address: str, resolve: Callable[[str], str]) -> Path:
    try:
        return Path(resolve(address))
    except ValueError as error:
        raise ConfigError(f"{where}: {error}") from error


def _check_size(where: str, address: str, resolve: Callable[[str], str]) -> None:
    path = _path(where, address, resolve)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise ConfigError(f"{where}: {path}: {error.strerror}") from error
    if size > MOST_BYTES:
        raise ConfigError(f"{where}: {path}: it has {size} bytes; at most {MOST_BYTES} are read")


def _triangles(where: str, path: Path) -> int:
    try:
        count = len(load_mesh(path).triangles)
    except MeshFileError as error:
        raise ConfigError(f"{where}: mesh {error}") from error
    if count > MOST_TRIANGLES:
        raise ConfigError(
            f"{where}: mesh {path}: it has {count} triangles; at most {MOST_TRIANGLES} are possible"
        )
    return count
