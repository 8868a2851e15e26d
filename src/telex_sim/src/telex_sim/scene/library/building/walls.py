"""Walls and columns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Optional, Tuple

from telex_control.common.params import require

from ...model import SceneObject, Surface, Vector3
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, number, parameter, rgb
from ..shapes import box, cylinder, recolored, standing

FINISHES: Dict[str, Surface] = {
    "concrete": look.CONCRETE,
    "plaster": look.PLASTER,
    "brick": look.BRICK,
    "wood": look.PLYWOOD,
    "tiles": look.TILES,
    "metal": look.GRAY_PAINT,
}
"""Looks of walls and columns."""


@dataclass(frozen=True)
class Wall(ObjectType):
    """Straight wall along x, perhaps with an opening."""

    length: float = number(4.0, "m.", 0.1, 200.0)
    height: float = number(2.5, "m.", 0.05, 20.0)
    thickness: float = number(0.12, "m.", 0.01, 2.0)
    finish: str = choice("plaster", FINISHES)
    color: Optional[Vector3] = rgb(None, "Red, green, blue, 0 to 1, in place of the finish's own.")
    opening: float = number(0.0, "Width of a gap for a door, from the floor (m); 0: none.", 0.0)
    opening_height: float = number(2.1, "m.", 0.1)
    opening_at: float = parameter(0.0, "Its middle along the wall (m), from the wall's.")
    skirting: bool = parameter(True, "A dark band along its foot.")

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        reach = abs(self.opening_at) + 0.5 * self.opening
        require(
            self.opening == 0.0 or reach <= 0.5 * self.length,
            f"opening_at is {self.opening_at}; an opening of {self.opening} has no room there in a"
            f" wall of {self.length}",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = FINISHES[self.finish]
        if self.color is not None:
            surface = recolored(surface, self.color)
        half = 0.5 * self.length
        spans = [(-half, half, 0.0)]
        if self.opening > 0.0:
            left, right = (self.opening_at + side * 0.5 * self.opening for side in (-1.0, 1.0))
            lintel = min(self.opening_height, self.height)
            spans = [(-half, left, 0.0), (right, half, 0.0), (left, right, lintel)]
        parts = []
        for start, end, low in spans:
            if end - start < 1e-6 or self.height - low < 1e-6:
                continue
            middle, long, high = 0.5 * (start + end), end - start, self.height - low
            size = (long, self.thickness, high)
            parts.append(box(size, (middle, 0.0, low + 0.5 * high), surface))
            if self.skirting and low == 0.0:
                foot = (long + 0.004, self.thickness + 0.02, min(0.1, 0.2 * self.height))
                at = (middle, 0.0, 0.5 * foot[2])
                parts.append(box(foot, at, look.DARK_STEEL, solid=False))
        return standing("wall", tuple(parts))


@dataclass(frozen=True)
class Column(ObjectType):
    """Upright, square or round, with a warning band."""

    width: float = number(0.3, "m.", 0.05, 5.0)
    height: float = number(3.0, "m.", 0.1, 20.0)
    round: bool = parameter(False, "A round one; else it is square.")
    finish: str = choice("concrete", FINISHES)
    band: bool = parameter(True, "Hazard stripes round its foot.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        w, h = self.width, self.height
        surface = FINISHES[self.finish]
        middle = (0.0, 0.0, 0.5 * h)
        body = (
            cylinder(0.5 * w, h, middle, surface) if self.round else box((w, w, h), middle, surface)
        )
        parts = [body]
        if self.band:
            high = min(0.4, 0.3 * h)
            at, wide = (0.0, 0.0, 0.1 + 0.5 * high), w + 0.006
            parts.append(
                cylinder(0.5 * wide, high, at, look.HAZARD, solid=False)
                if self.round
                else box((wide, wide, high), at, look.HAZARD, solid=False)
            )
        return standing("column", tuple(parts))


TYPES = {
    "wall": Wall,
    "column": Column,
}
