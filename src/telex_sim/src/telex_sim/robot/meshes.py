"""The meshes and pictures of a robot, held to the limits that those of scenes have."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import Callable, Dict, Iterator

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import parse_urdf
from telex_control.urdf.model import Link, Mesh

from ..scene.assets import MOST_BYTES, MOST_TRIANGLES
from ..scene.meshes.mesh_files import MeshFileError, load_mesh

MOST_COLLISION_TRIANGLES = 60_000
"""Of all meshes that a robot collides by: the loop stands while PyBullet reads them."""


def _refuse(problem: str) -> None:
    raise ConfigError(problem)


def check_meshes(
    urdf: str, resolve: Callable[[str], str], mind: Callable[[str], None] = _refuse
) -> None:
    """Look at a robot's files.

    Parameters
    ----------
    resolve : callable
        Turns an address (``package://…``) into a path; raises a ValueError for one that is none.
    mind : callable, optional
        Told of what can be simulated all the same: files that are only seen are missing or too
        large, meshes to collide by are too fine. By default it is refused.

    Raises
    ------
    ConfigError
        A file to collide by is missing or too large or cannot be read; the message names link and
        file.
    """
    triangles: Dict[Path, int] = {}
    total = 0
    for name, link in parse_urdf(urdf).link_map.items():
        where = f"link '{name}'"
        for address in _seen(link):
            try:
                _check_size(where, address, resolve)
            except ConfigError as error:
                mind(str(error))
        for mesh in (each.geometry for each in link.collisions):
            if not isinstance(mesh, Mesh):
                continue
            path = _path(where, mesh.filename, resolve)
            if path not in triangles:
                _check_size(where, mesh.filename, resolve)
                triangles[path] = _triangles(where, path)
                if triangles[path] > MOST_TRIANGLES:
                    mind(
                        f"{where}: mesh {path}: it has {triangles[path]} triangles; at most "
                        f"{MOST_TRIANGLES} are possible"
                    )
            total += triangles[path]
    if total > MOST_COLLISION_TRIANGLES:
        mind(
            f"its meshes to collide by have {total} triangles in all; at most "
            f"{MOST_COLLISION_TRIANGLES} are possible in a robot, and their convex hulls would do"
        )


def _seen(link: Link) -> Iterator[str]:
    """Yield the addresses of a link's files that are only seen: its meshes, then its pictures."""
    for visual in link.visuals:
        if isinstance(visual.geometry, Mesh) and visual.geometry.filename:
            yield visual.geometry.filename
    for visual in link.visuals:
        material = visual.material
        if material is not None and material.texture is not None and material.texture.filename:
            yield material.texture.filename


def _path(where: str, address: str, resolve: Callable[[str], str]) -> Path:
    try:
        return Path(resolve(address))
    except ValueError as error:
        raise ConfigError(f"{where}: {error}") from error


def _check_size(where: str, address: str, resolve: Callable[[str], str]) -> None:
    path = _path(where, address, resolve)
    try:
        found = path.stat()
    except OSError as error:
        raise ConfigError(f"{where}: {path}: {error.strerror}") from error
    if not stat.S_ISREG(found.st_mode):
        raise ConfigError(f"{where}: {path}: it is no file")
    if found.st_size > MOST_BYTES:
        raise ConfigError(
            f"{where}: {path}: it has {found.st_size} bytes; at most {MOST_BYTES} are read"
        )


def _triangles(where: str, path: Path) -> int:
    try:
        return len(load_mesh(path).triangles)
    except MeshFileError as error:
        raise ConfigError(f"{where}: mesh {error}") from error
