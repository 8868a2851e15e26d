"""Appearance of parts of mesh files: corners, colour, texture; libraries of materials."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Sequence

import numpy as np

from ..visual_scene import Color


class Corners(NamedTuple):
    """Triangles that share no vertices.

    Attributes
    ----------
    positions, normals, uvs
        Shapes (T, 3, 3), (T, 3, 3) and (T, 3, 2); the last two may be missing.
    """

    positions: np.ndarray
    normals: Optional[np.ndarray] = None
    uvs: Optional[np.ndarray] = None


class Look(NamedTuple):
    """A material: colour as in sRGB, and the picture that it is multiplied by."""

    color: Optional[Color] = None
    texture: Optional[Path] = None


class FilePart(NamedTuple):
    """Triangles with the same material."""

    corners: Corners
    look: Look = Look()


def read_mtl(path: Path) -> Dict[str, Look]:
    """Read a library of materials: their diffuse colour, opacity and texture.

    Raises
    ------
    ValueError
        When it is missing, or a number in it makes no sense.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise ValueError(f"its materials {path.name}: {error.strerror}") from error
    looks: Dict[str, Look] = {}
    name = ""
    for number, line in enumerate(text.splitlines(), start=1):
        keyword, *words = line.split() or [""]
        if keyword == "newmtl":
            name = " ".join(words)
            looks[name] = Look()
            continue
        look = looks.get(name)
        if look is None:
            continue
        red, green, blue, alpha = look.color or (1.0, 1.0, 1.0, 1.0)
        try:
            if keyword == "Kd":
                # A texture is multiplied by nothing: exporters leave any colour beside it.
                red, green, blue = _shares(words, 3)
                looks[name] = look._replace(color=(red, green, blue, alpha))
            elif keyword in ("d", "Tr"):
                (share,) = _shares(words[-1:], 1)
                opacity = share if keyword == "d" else 1.0 - share
                looks[name] = look._replace(color=(red, green, blue, opacity))
            elif keyword == "map_Kd" and words:
                looks[name] = look._replace(texture=path.parent / _file_name(words))
        except ValueError as error:
            raise ValueError(f"its materials {path.name}, line {number}: {error}") from error
    return {name: _white_below_texture(look) for name, look in looks.items()}


def _white_below_texture(look: Look) -> Look:
    if look.texture is None:
        return look
    return look._replace(color=(1.0, 1.0, 1.0, look.color[3] if look.color else 1.0))


def _shares(words: Sequence[str], count: int) -> List[float]:
    if len(words) < count:
        raise ValueError(f"expected {count} numbers, got {len(words)}")
    shares = [float(word) for word in words[:count]]
    if not all(0.0 <= share <= 1.0 for share in shares):
        raise ValueError(f"{shares} must lie within 0..1")
    return shares


def _file_name(words: Sequence[str]) -> str:
    """Leave out options such as ``-s 1 1 1``, which stand before the name of the picture."""
    start = 0
    while start < len(words) - 1 and words[start].startswith("-"):
        start += 1
        while start < len(words) - 1 and _is_option_value(words[start]):
            start += 1
    return " ".join(words[start:]).replace("\\", "/")


def _is_option_value(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return word in ("on", "off")
    return True
