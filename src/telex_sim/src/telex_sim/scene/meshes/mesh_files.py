"""Readers for the mesh files that URDF visuals name: OBJ, STL and COLLADA (DAE)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ..visual_scene import Color
from .appearance import Corners, FilePart, Look, read_mtl
from .collada import read_collada
from .meshes import Mesh
from .normals import mesh_from_corners

MOST_TRIANGLES = 500_000
"""A file with more is refused: pictures would take longer than anybody waits."""

# A coordinate beyond this is a mistake, and too coarse in single precision (in the file's unit).
_LARGEST = 1.0e6

_STL_HEADER = 84
_STL_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

# What ends or continues a line in `_read_obj`, but not in PyBullet.
_OTHER_LINES = re.compile(rb"\\\n|\r(?!\n)|[\x0b\x0c\x1c-\x1e]")

# Position, texture coordinate and normal of a face's corner, counted from 0; -1 when absent.
_Corner = Tuple[int, int, int]


class MeshFileError(ValueError):
    """A mesh file is missing or cannot be used; the message names the file."""


class MeshPart(NamedTuple):
    """What of a mesh has one material.

    Attributes
    ----------
    mesh
        Its triangles.
    color
        Red, green, blue, alpha, as in sRGB; None: the file has none for it.
    texture
        Picture that is multiplied by the colour, or None.
    """

    mesh: Mesh
    color: Optional[Color] = None
    texture: Optional[Path] = None


def load_mesh(path: Path) -> Mesh:
    """Read an OBJ, STL or COLLADA file without its materials.

    Normals come from the file where it has them for every corner, and are computed otherwise.

    Raises
    ------
    MeshFileError
        When the file is missing, of another kind, broken or too large; or when it has a
        coordinate that is not finite, or no triangle with an area.
    """
    try:
        return mesh_from_corners(*_joined([part.corners for part in _read(path, False)]))
    except ValueError as error:
        raise _refused(path, error) from error


def load_parts(path: Path) -> List[MeshPart]:
    """Read an OBJ, STL or COLLADA file, one part for each of its materials.

    Raises
    ------
    MeshFileError
        As for `load_mesh`, and when a library of materials is missing or broken.
    """
    try:
        return [
            MeshPart(mesh_from_corners(*part.corners), part.look.color, part.look.texture)
            for part in _read(path, True)
        ]
    except ValueError as error:
        raise _refused(path, error) from error


def rewritten(path: Path) -> Optional[bytes]:
    """Write a file of which PyBullet makes another shape than `load_mesh` as a binary STL.

    Of STL it reads binary files only; in OBJ a carriage return ends no line, and a backslash
    continues none; of COLLADA it takes triangles only.

    Returns
    -------
    bytes, optional
        None: PyBullet can read the file as it is, or there is none.

    Raises
    ------
    MeshFileError
        The file is broken or too large.
    """
    try:
        if not _is_read_otherwise(path):
            return None
    except OSError:
        return None
    positions = np.concatenate([part.corners.positions for part in _read(path, False)])
    facets = np.zeros(len(positions), dtype=_STL_FACET)
    facets["corners"] = positions
    return bytes(_STL_HEADER - 4) + len(facets).to_bytes(4, "little") + facets.tobytes()


def _is_read_otherwise(path: Path) -> bool:
    kind = path.suffix.lower()
    if kind not in (".obj", ".stl"):
        return kind == ".dae"
    content = path.read_bytes()
    if kind == ".obj":
        return _OTHER_LINES.search(content) is not None
    return len(content) != _binary_size(content)


def _refused(path: Path, error: ValueError) -> MeshFileError:
    return error if isinstance(error, MeshFileError) else MeshFileError(f"{path}: {error}")


def _read(path: Path, with_looks: bool) -> List[FilePart]:
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshFileError(f"{path}: unknown kind of mesh, expected {' or '.join(_READERS)}")
    try:
        parts = reader(path, with_looks)
        _check_count(sum(len(part.corners.positions) for part in parts))
        if any(np.abs(part.corners.positions).max(initial=0.0) > _LARGEST for part in parts):
            raise ValueError(f"a coordinate is beyond {_LARGEST:g}")
        return parts
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise MeshFileError(f"{path}: {reason}") from error


def _joined(parts: Sequence[Corners]) -> Corners:
    """Put all triangles together; what not all of them have is left out."""
    normals = [part.normals for part in parts if part.normals is not None]
    uvs = [part.uvs for part in parts if part.uvs is not None]
    return Corners(
        np.concatenate([part.positions for part in parts]),
        np.concatenate(normals) if len(normals) == len(parts) else None,
        np.concatenate(uvs) if len(uvs) == len(parts) else None,
    )


def _read_obj(path: Path, with_looks: bool) -> List[FilePart]:
    content = path.read_bytes()
    positions: List[Sequence[float]] = []
    uvs: List[Sequence[float]] = []
    normals: List[Sequence[float]] = []
    triangles: List[_Corner] = []
    looks: Dict[str, Look] = {}
    # Material of each triangle, by its place in ``names``.
    names: List[str] = [""]
    material: List[int] = []
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
                material += [len(names) - 1] * (len(triangles) // 3 - len(material))
            elif keyword == "usemtl":
                names.append(" ".join(words))
            elif keyword == "mtllib" and with_looks:
                looks.update(read_mtl(path.parent / " ".join(words)))
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from error
    if not triangles:
        raise ValueError("there is no face")
    corners = np.array(triangles, dtype=np.intp).reshape(-1, 3, 3)
    of = [looks.get(name, Look()) for name in names]
    groups: Dict[Look, List[int]] = {}
    for triangle, place in enumerate(material):
        groups.setdefault(of[place], []).append(triangle)
    points = np.array(positions)
    return [
        FilePart(
            Corners(
                points[corners[members, :, 0]],
                _looked_up(normals, corners[members, :, 2]),
                _looked_up(uvs, corners[members, :, 1]),
            ),
            look,
        )
        for look, members in groups.items()
    ]


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


def _read_stl(path: Path, _: bool) -> List[FilePart]:
    return [FilePart(Corners(_stl_corners(path.read_bytes())))]


def _stl_corners(content: bytes) -> np.ndarray:
    # Binary files may begin with the text files' keyword, so the size decides.
    expected = _binary_size(content)
    count = (expected - _STL_HEADER) // _STL_FACET.itemsize
    if len(content) == expected:
        _check_count(count)
        facets = np.frombuffer(content, dtype=_STL_FACET, offset=_STL_HEADER)
        return facets["corners"].astype(np.float64)
    if content.lstrip()[:5].lower() == b"solid":
        return _read_ascii_stl(content)
    if len(content) < _STL_HEADER:
        raise ValueError(f"no STL file: {len(content)} bytes are less than a header")
    raise ValueError(f"{count} triangles take {expected} bytes, the file has {len(content)}")


def _binary_size(content: bytes) -> int:
    """Bytes that an STL file has if it is a binary one."""
    count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    return _STL_HEADER + count * _STL_FACET.itemsize


def _read_ascii_stl(content: bytes) -> np.ndarray:
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
    return np.array(vertices).reshape(-1, 3, 3)


def _check_count(triangles: int) -> None:
    if triangles > MOST_TRIANGLES:
        raise ValueError(f"it has more than {MOST_TRIANGLES} triangles, at most so many are drawn")


_READERS: Dict[str, Callable[[Path, bool], List[FilePart]]] = {
    ".obj": _read_obj,
    ".stl": _read_stl,
    ".dae": lambda path, _: read_collada(path),
}
