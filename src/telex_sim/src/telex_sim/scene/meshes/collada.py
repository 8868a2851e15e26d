"""Reads COLLADA files (.dae) with pycollada."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List, Optional
from urllib.parse import unquote

import numpy as np

from .appearance import Corners, FilePart, Look


def read_collada(path: Path) -> List[FilePart]:
    """Read the triangles of a file's scene, in metres, with their materials.

    The axes are the file's, whatever it says is up: rviz and Gazebo do not heed that, and robots
    are made to be right there.

    Raises
    ------
    ValueError
        When the file cannot be read, has no triangles, or pycollada is not installed.
    """
    try:
        from collada import Collada
        from collada.common import DaeUnsupportedError
    except ImportError as error:
        raise ValueError("COLLADA needs the Python package pycollada (requirements.txt)") from error
    try:
        document = Collada(str(path), ignore=[DaeUnsupportedError])
        bound = list(document.scene.objects("geometry")) if document.scene else []
        metres = float(document.assetInfo.unitmeter or 1.0)
        parts = [
            part
            for geometry in bound
            for primitive in geometry.primitives()
            for part in _parts(primitive, metres, path.parent, _is_mirrored(geometry))
        ]
    except OSError:
        raise
    except Exception as error:  # the parser raises whatever fails first
        raise ValueError(f"no COLLADA that can be read: {error!r}") from error
    if not parts:
        raise ValueError("its scene has no triangle")
    return parts


def _is_mirrored(geometry: Any) -> bool:
    """Whether an instance's place turns its triangles' outside inwards."""
    return bool(np.linalg.det(np.asarray(geometry.matrix)[:3, :3]) < 0.0)


def _parts(primitive: Any, metres: float, folder: Path, mirrored: bool) -> List[FilePart]:
    if hasattr(primitive, "triangleset"):
        primitive = primitive.triangleset()
    index = getattr(primitive, "vertex_index", None)
    if index is None or not len(index) or np.shape(index)[1:] != (3,):
        # Lines and points have no surface.
        return []
    positions = np.asarray(primitive.vertex, dtype=np.float64)[index] * metres
    normals = None
    if primitive.normal is not None and primitive.normal_index is not None:
        normals = np.asarray(primitive.normal, dtype=np.float64)[primitive.normal_index]
    uvs = None
    if primitive.texcoordset:
        chosen = np.asarray(primitive.texcoordset[0], dtype=np.float64)
        uvs = chosen[primitive.texcoord_indexset[0]][..., :2]
    corners = Corners(positions, normals, uvs)
    if mirrored:
        corners = Corners(
            positions[:, ::-1],
            None if normals is None else normals[:, ::-1],
            None if uvs is None else uvs[:, ::-1],
        )
    return [FilePart(corners, _look(primitive.material, folder))]


def _look(material: Optional[Any], folder: Path) -> Look:
    effect = getattr(material, "effect", None)
    diffuse = getattr(effect, "diffuse", None)
    if diffuse is None:
        return Look()
    sampler = getattr(diffuse, "sampler", None)
    if sampler is not None:
        image = unquote(sampler.surface.image.path)
        image = image[len("file://") :] if image.startswith("file://") else image
        return Look((1.0, 1.0, 1.0, 1.0), folder / image)
    red, green, blue = (min(max(float(share), 0.0), 1.0) for share in diffuse[:3])
    return Look((red, green, blue, 1.0))
