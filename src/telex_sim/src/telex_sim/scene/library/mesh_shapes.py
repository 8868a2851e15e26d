"""The meshes of the library, made by code.

``python -m telex_sim.scene.library.mesh_shapes FOLDER`` writes them; the shipped ones stand in
``telex_sim/meshes``. All are about unit size, to be scaled.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Dict, List, Tuple

from .shapes import BAND_TOP, CONE_TOP, RING_THICKNESS, TUBE_INNER

Point = Tuple[float, float, float]
Face = Tuple[int, ...]
_AROUND = 40
_AROUND_BAR = 12


def shape_files() -> Dict[str, str]:
    """Content of each OBJ file by its name without extension."""
    return {
        "wedge": _obj(*_wedge()),
        "cone": _obj(*_turned([(0.0, 0.0), (1.0, 0.0), (CONE_TOP, 1.0), (0.0, 1.0)])),
        "band": _obj(*_turned([(0.0, 0.0), (1.0, 0.0), (BAND_TOP, 1.0), (0.0, 1.0)])),
        "tube": _obj(*_turned(_TUBE, closed=True)),
        "ring": _obj(*_turned(_bar(), closed=True)),
    }


def write_shapes(folder: Path) -> None:
    """Write all files into `folder`."""
    for name, content in shape_files().items():
        (folder / f"{name}.obj").write_text(content)


_TUBE = [(TUBE_INNER, -0.5), (1.0, -0.5), (1.0, 0.5), (TUBE_INNER, 0.5)]


def _bar() -> List[Tuple[float, float]]:
    angles = [2.0 * math.pi * index / _AROUND_BAR for index in range(_AROUND_BAR)]
    return [
        (1.0 + RING_THICKNESS * math.cos(angle), RING_THICKNESS * math.sin(angle))
        for angle in angles
    ]


def _wedge() -> Tuple[List[Point], List[Face]]:
    points = [(x, y, z) for y in (-0.5, 0.5) for x, z in ((-0.5, 0.0), (0.5, 0.0), (0.5, 1.0))]
    faces: List[Face] = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (0, 2, 5, 3)]
    return points, faces


def _turned(
    profile: List[Tuple[float, float]], closed: bool = False
) -> Tuple[List[Point], List[Face]]:
    """Turn a profile of radius and height, anticlockwise in that plane, about z."""
    points: List[Point] = []
    rows: List[List[int]] = []
    for radius, height in profile:
        row: List[int] = []
        for index in range(_AROUND):
            if index and radius == 0.0:
                row.append(row[0])
                continue
            angle = 2.0 * math.pi * index / _AROUND
            row.append(len(points))
            points.append((radius * math.cos(angle), radius * math.sin(angle), height))
        rows.append(row)
    faces: List[Face] = []
    for lower, upper in zip(rows, rows[1:] + rows[:1] if closed else rows[1:]):
        for index in range(_AROUND):
            following = (index + 1) % _AROUND
            corners = (lower[index], lower[following], upper[following], upper[index])
            # Next to the axis two corners are one.
            faces.append(tuple(dict.fromkeys(corners)))
    return points, faces


def _obj(points: List[Point], faces: List[Face]) -> str:
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    lines += ["f " + " ".join(str(index + 1) for index in face) for face in faces]
    return "\n".join(lines).replace("-0.000000", "0.000000") + "\n"


if __name__ == "__main__":
    write_shapes(Path(sys.argv[1]))
