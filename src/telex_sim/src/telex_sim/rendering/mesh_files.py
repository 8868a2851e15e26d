"""Readers for the mesh files that URDF visuals name: OBJ and STL."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .mesh_normals import mesh_from_corners
from .meshes import Mesh

MOST_TRIANGLES = 500_000
"""A file with more is refused: pictures would take longer than anybody waits."""

# A coordinate beyond this is a mistake, and too coarse in single precision (in the file's unit).
_LARGEST = 1.0e6

_STL_HEADER = 84
_STL_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

# Position, texture coordinate and normal of a face's corner, counted from 0; -1 when absent.
_Corner = Tuple[int, int, int]


class MeshFileError(ValueError):
    """A mesh file is missing or cannot be used; the message names the file."""


def load_mesh(path: Path) -> Mesh:
    """Read an OBJ or STL file.

    Normals come from an OBJ file where it has them for every corner, and are computed otherwise.
    Colours and materials are not read: in this project a visual has one colour.

    Raises
    ------
    MeshFileError
        When the file is missing, of another kind, broken or too large; or when it has a
        coordinate that is not finite, or no triangle with an area.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshFileError(f"{path}: unknown kind of mesh, expected {' or '.join(_READERS)}")
    try:
        mesh = reader(path.read_bytes())
        if np.abs(mesh.positions).max() > _LARGEST:
            raise ValueError(f"a coordinate is beyond {_LARGEST:g}")
        return mesh
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise MeshFileError(f"{path}: {reason}") from error


def _read_obj(content: bytes) -> Mesh:
    positions: List[Sequence[float]] = []
    uvs: List[Sequence[float]] = []
    normals: List[Sequence[float]] = []
    triangles: List[_Corner] = []
    lines = content.decode("utf-8", errors="replace").replace("\\\n", " ").splitlines()
    for number, line in enumerate(lines, start=1):
        keyword, *words = line.split() or [""]
        try:
            if keyword == "v":
                positions.append(_floats(words, 3))
            elif keyword == "vt":
                uvs.append(_floats(words, 2))
            elif keyword == "vn":
                normals.append(_floats(words, 3))
            elif keyword == "f":
                counts = (len(positions), len(uvs), len(normals))
                triangles += _fan([_obj_corner(word, counts) for word in words])
                _check_count(len(triangles) // 3)
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from error
    if not triangles:
        raise ValueError("there is no face")
    corners = np.array(triangles, dtype=np.intp).reshape(-1, 3, 3)
    return mesh_from_corners(
        np.array(positions)[corners[..., 0]],
        _looked_up(normals, corners[..., 2]),
        _looked_up(uvs, corners[..., 1]),
    )


def _floats(words: Sequence[str], count: int) -> Sequence[float]:
    if len(words) < count:
        raise ValueError(f"expected {count} numbers, got {len(words)}")
    return [float(word) for word in words[:count]]


def _obj_corner(word: str, counts: Tuple[int, int, int]) -> _Corner:
    """Read a face's corner: v, v/vt, v//vn or v/vt/vn, counted from 1, or < 0 from the end."""
    fields = word.split("/")
    if len(fields) > 3:
        raise ValueError(f"'{word}' is no corner of a face")
    indices = [-1, -1, -1]
    for place, field in enumerate(fields):
        if not field:
            continue
        index = int(field)
        index = index - 1 if index > 0 else counts[place] + index
        if index < 0 or index >= counts[place] or field == "0":
            raise ValueError(f"'{word}' refers to {field}, of {counts[place]} given so far")
        indices[place] = index
    if indices[0] < 0:
        raise ValueError(f"'{word}' names no vertex")
    return indices[0], indices[1], indices[2]


def _fan(corners: Sequence[_Corner]) -> List[_Corner]:
    """Corners of the triangles that a convex polygon falls into."""
    if len(corners) < 3:
        raise ValueError(f"a face needs 3 corners, got {len(corners)}")
    return [
        corner
        for second, third in zip(corners[1:], corners[2:])
        for corner in (corners[0], second, third)
    ]


def _looked_up(values: Sequence[Sequence[float]], indices: np.ndarray) -> Optional[np.ndarray]:
    """Values at the indices, or None unless every corner has one."""
    return np.array(values)[indices] if values and (indices >= 0).all() else None


def _read_stl(content: bytes) -> Mesh:
    # Binary files may begin with the text files' keyword, so the size decides.
    if len(content) >= _STL_HEADER:
        count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
        expected = _STL_HEADER + count * _STL_FACET.itemsize
        if len(content) == expected:
            _check_count(count)
            facets = np.frombuffer(content, dtype=_STL_FACET, offset=_STL_HEADER)
            return mesh_from_corners(facets["corners"].astype(np.float64), None, None)
    if content.lstrip()[:5].lower() == b"solid":
        return _read_ascii_stl(content)
    if len(content) < _STL_HEADER:
        raise ValueError(f"no STL file: {len(content)} bytes are less than a header")
    raise ValueError(f"{count} triangles take {expected} bytes, the file has {len(content)}")


def _read_ascii_stl(content: bytes) -> Mesh:
    vertices: List[Sequence[float]] = []
    for number, line in enumerate(content.decode("ascii", errors="replace").splitlines(), start=1):
        keyword, *words = line.split() or [""]
        if keyword.lower() != "vertex":
            continue
        try:
            vertices.append(_floats(words, 3))
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from error
    if not vertices or len(vertices) % 3:
        raise ValueError(f"{len(vertices)} vertices do not make triangles")
    _check_count(len(vertices) // 3)
    return mesh_from_corners(np.array(vertices).reshape(-1, 3, 3), None, None)


def _check_count(triangles: int) -> None:
    if triangles > MOST_TRIANGLES:
        raise ValueError(f"it has more than {MOST_TRIANGLES} triangles, at most so many are drawn")


_READERS: Dict[str, Callable[[bytes], Mesh]] = {".obj": _read_obj, ".stl": _read_stl}
