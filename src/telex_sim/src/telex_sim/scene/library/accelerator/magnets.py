"""Magnets of an accelerator; the beam runs along x."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from ...model import SceneObject, Surface, Vector3
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import number, rgb
from ..shapes import LYING_X, box, cylinder, opaque, placed, rod, rolled, seen_only, standing
from .beam_parts import BEAM_HEIGHT, flanged_pipe, jack


@dataclass(frozen=True)
class Dipole(ObjectType):
    """Bending magnet: a yoke of iron with coils that reach out at both ends."""

    length: float = number(2.0, "Of the yoke (m).", 0.5, 15.0)
    width: float = number(0.75, "Of the yoke (m).", 0.3, 2.0)
    tall: float = number(0.62, "Of the yoke (m).", 0.3, 2.0)
    height: float = number(
        BEAM_HEIGHT, "Of the beam over the floor (m).", lambda own: 0.5 * own.tall + 0.15, 3.0
    )
    color: Vector3 = rgb((0.12, 0.30, 0.58))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z, h = self.length, self.width, self.tall, self.height
        paint = Surface(opaque(self.color), "generated:painted_metal", 1.0)
        gap = 0.1
        pole = 0.5 * (z - gap)
        side = 0.22 * y
        parts = [
            *(
                box((x, y, pole), (0.0, 0.0, h + end * 0.5 * (gap + pole)), paint)
                for end in (-1.0, 1.0)
            ),
            *(box((x, side, gap), (0.0, end * 0.5 * (y - side), h), paint) for end in (-1.0, 1.0)),
        ]
        for end in (-1.0, 1.0):
            out = end * (0.5 * x + 0.05)
            for up in (-1.0, 1.0):
                at = (out, 0.0, h + up * (0.5 * gap + 0.075))
                parts.append(box((0.1, y - 2.0 * side, 0.09), at, look.COPPER))
            # Water and current.
            for across in (-0.35, -0.25, 0.25, 0.35):
                near = (out - end * 0.05, across * y, h + 0.3 * z)
                far = (out + end * 0.05, across * y, h + 0.3 * z)
                parts.append(rod(near, far, 0.012, look.COPPER, solid=False))
        ribs = max(2, round(x / 0.5))
        for index in range(ribs + 1):
            along = (index / ribs - 0.5) * (x - 0.03)
            parts.append(
                box((0.03, y + 0.012, 0.5 * z), (along, 0.0, h + 0.1 * z), paint, solid=False)
            )
        name = look.picture("label?text=DIPOLE&aspect=3.6")
        plate = (0.5, y + 0.003 + 0.012, 0.14)
        parts.append(box(plate, (0.0, 0.0, h + 0.22 * z), name, solid=False))
        for lug in (-0.35, 0.35):
            parts.append(
                box((0.06, 0.03, 0.08), (lug * x, 0.0, h + 0.5 * z + 0.04), look.YELLOW_PAINT)
            )
        parts.extend(flanged_pipe(-0.5 * x - 0.2, 0.5 * x + 0.2, 0.04, h))
        for foot in (-0.3, 0.3):
            parts.extend(jack((foot * x, 0.0, 0.0), 0.9 * y, h - 0.5 * z))
        return standing("dipole", tuple(parts))


@dataclass(frozen=True)
class Quadrupole(ObjectType):
    """Focusing magnet: a square yoke with four coils about the pipe."""

    length: float = number(0.8, "Of the yoke (m).", 0.2, 5.0)
    width: float = number(0.6, "Of the yoke (m).", 0.3, 2.0)
    height: float = number(
        BEAM_HEIGHT, "Of the beam over the floor (m).", lambda own: 0.5 * own.width + 0.15, 3.0
    )
    color: Vector3 = rgb((0.70, 0.15, 0.12))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, w, h = self.length, self.width, self.height
        paint = Surface(opaque(self.color), "generated:painted_metal", 1.0)
        thick = 0.17 * w
        centre = (0.0, 0.0, h)
        parts: List = []
        for quarter in range(4):
            turn = rolled(0.5 * math.pi * quarter)
            # Four beams of the yoke, a pole and its coil between them on each diagonal.
            yoke = box((x, w - thick, thick), (0.0, -0.5 * thick, 0.5 * (w - thick)), paint)
            parts.extend(placed((yoke,), centre, turn))
            diagonal = rolled(0.25 * math.pi + 0.5 * math.pi * quarter)
            pole = box((x - 0.01, 0.11 * w, 0.36 * w), (0.0, 0.0, 0.34 * w), look.DARK_STEEL)
            coil = box((x + 0.12, 0.2 * w, 0.15 * w), (0.0, 0.0, 0.36 * w), look.COPPER)
            parts.extend(seen_only(placed((pole, coil), centre, diagonal)))
        name = look.picture("label?text=QUADRUPOLE&aspect=4")
        plate = (0.4, w + 0.003, 0.1)
        parts.append(box(plate, (0.0, 0.0, h + 0.25 * w), name, solid=False))
        parts.extend(flanged_pipe(-0.5 * x - 0.2, 0.5 * x + 0.2, 0.04, h))
        parts.extend(jack((0.0, 0.0, 0.0), 0.9 * w, h - 0.5 * w))
        return standing("quadrupole", tuple(parts))


@dataclass(frozen=True)
class Cryostat(ObjectType):
    """Superconducting magnet in its long round vessel."""

    length: float = number(5.0, "m.", 1.0, 20.0)
    radius: float = number(0.46, "m.", 0.2, 1.0)
    height: float = number(
        BEAM_HEIGHT, "Of the vessel's axis over the floor (m).", lambda own: own.radius + 0.1, 3.0
    )
    color: Vector3 = rgb((0.14, 0.32, 0.62))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, r, h = self.length, self.radius, self.height
        paint = Surface(opaque(self.color), "generated:painted_metal", 1.5)
        parts = [cylinder(r, x - 0.3, (0.0, 0.0, h), paint, LYING_X)]
        for end in (-1.0, 1.0):
            parts.append(
                cylinder(r + 0.03, 0.05, (end * (0.5 * x - 0.175), 0.0, h), paint, LYING_X)
            )
            parts.append(
                cylinder(0.8 * r, 0.15, (end * (0.5 * x - 0.075), 0.0, h), look.STAINLESS, LYING_X)
            )
            for ripple in range(4):
                at = end * (0.5 * x - 0.02 - 0.033 * ripple)
                parts.append(
                    cylinder(0.84 * r, 0.014, (at, 0.0, h), look.STAINLESS, LYING_X, solid=False)
                )
        bands = max(2, round(x / 2.5))
        for index in range(1, bands):
            at = (index / bands - 0.5) * x
            parts.append(cylinder(r + 0.012, 0.08, (at, 0.0, h), paint, LYING_X, solid=False))
        # A white stripe along its waist, as a mark of the vessel's axis.
        parts.append(box((x - 0.5, 2.0 * r + 0.004, 0.03), (0.0, 0.0, h), look.WHITE, solid=False))
        for at in (-0.3 * x, 0.3 * x):
            top = h - 0.8 * r
            parts.append(box((0.35, 1.1 * r, top), (at, 0.0, 0.5 * top), look.CONCRETE))
            parts.append(
                box((0.25, 1.3 * r, 0.35 * r), (at, 0.0, top + 0.1 * r), look.YELLOW_PAINT)
            )
        return standing("cryostat", tuple(parts))


TYPES = {
    "dipole": Dipole,
    "quadrupole": Quadrupole,
    "cryostat": Cryostat,
}
