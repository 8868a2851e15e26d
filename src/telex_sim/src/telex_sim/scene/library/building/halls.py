"""Roof, gate and marks on the floor of a hall, to be seen only."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from telex_control.common.params import require

from ...model import SceneObject, Vector3
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import number, rgb
from ..shapes import Parts, beam, box, recolored, rod, seen_only, standing

_STEEL = look.plain(0.42, 0.46, 0.50)
_POST, _CHORD, _BRACE, _PURLIN = 0.14, 0.09, 0.06, 0.10
# Of tape over the floor (m): more than its thickness, so that it shows from afar as well.
_TAPE_HEIGHT = 0.002

_LAMP_LENGTH, _LAMP_WIDTH, _LAMP_DROP = 1.4, 0.22, 0.35


@dataclass(frozen=True)
class Roof(ObjectType):
    """Glazed roof of a hall: trusses on posts, purlins, lamps, and cables between them."""

    length: float = number(16.0, "Of the hall, along x (m).", 2.0, 200.0)
    width: float = number(12.0, "Of the hall, along y, which the trusses span (m).", 2.0, 60.0)
    height: float = number(4.2, "Of the lower side of the trusses over the floor (m).", 2.0, 20.0)
    depth: float = number(0.7, "Of the trusses (m).", 0.2, 3.0)
    trusses: int = number(5, "How many, evenly along the hall.", 2, 40)
    panels: int = number(8, "Of each truss, between its uprights.", 2, 40)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        half, top = 0.5 * self.width, self.height + self.depth
        places = [self.length * (index / (self.trusses - 1) - 0.5) for index in range(self.trusses)]
        parts = [part for at in places for part in self._truss(at)]
        ends = (-0.5 * self.length, 0.5 * self.length)
        for share in (-1.0, -0.5, 0.0, 0.5, 1.0):
            y, z = share * half, top + 0.5 * (_CHORD + _PURLIN)
            start, end = ((x, y, z) for x in ends)
            parts.append(beam(start, end, 0.06, _PURLIN, _STEEL))
        for first, second in zip(places, places[1:]):
            for share in (-0.5, 0.5):
                parts += self._lamp(0.5 * (first + second), share * half)
        for aside, radius in ((0.0, 0.016), (0.05, 0.010)):
            start, end = ((x, 0.25 * half + aside, self.height + _CHORD + radius) for x in ends)
            parts.append(rod(start, end, radius, look.BLACK))
        return standing("roof", seen_only(parts))

    def _truss(self, at: float) -> Parts:
        """One truss with its two posts."""
        half, low, high = 0.5 * self.width, self.height, self.height + self.depth
        step = self.width / self.panels
        parts = [beam((at, -half, z), (at, half, z), _CHORD, _CHORD, _STEEL) for z in (low, high)]
        for side in (-half, half):
            size = (_POST, _POST, high)
            parts.append(box(size, (at, side, 0.5 * high), _STEEL))
        for index in range(self.panels):
            left, right = -half + index * step, -half + (index + 1) * step
            ends = (left, right) if index < 0.5 * self.panels else (right, left)
            start, end = (at, ends[0], high), (at, ends[1], low)
            parts.append(beam(start, end, _BRACE, _BRACE, _STEEL))
            if index:
                parts.append(beam((at, left, low), (at, left, high), _BRACE, _BRACE, _STEEL))
        return tuple(parts)

    def _lamp(self, x: float, y: float) -> Parts:
        """One lamp, hanging below the purlins."""
        z = self.height - _LAMP_DROP
        size = (_LAMP_LENGTH, _LAMP_WIDTH, 0.08)
        tubes = (_LAMP_LENGTH - 0.06, _LAMP_WIDTH - 0.05, 0.02)
        wires = [
            rod((x + aside, y, z), (x + aside, y, self.height + self.depth), 0.005, look.BLACK)
            for aside in (-0.5, 0.5)
        ]
        return (
            box(size, (x, y, z), look.plain(0.75, 0.76, 0.76)),
            box(tubes, (x, y, z - 0.05), look.plain(1.0, 0.98, 0.92, glow=1.0)),
            *wires,
        )


@dataclass(frozen=True)
class Gate(ObjectType):
    """Closed roller gate before a wall, seen from -x, in its frame."""

    width: float = number(3.0, "Along y (m).", 0.5, 20.0)
    height: float = number(2.6, "m.", 0.5, 20.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        count = max(4, round(self.height / 0.2))
        pitch = self.height / count
        shades = (look.plain(0.50, 0.56, 0.60), look.plain(0.44, 0.50, 0.54))
        parts = [
            box(
                (0.03 + 0.01 * (index % 2), self.width, pitch),
                (0.0, 0.0, (index + 0.5) * pitch),
                shades[index % 2],
            )
            for index in range(count)
        ]
        for side in (-1.0, 1.0):
            size = (0.08, 0.12, self.height)
            at = (0.0, side * 0.5 * (self.width + 0.12), 0.5 * self.height)
            parts.append(box(size, at, look.HAZARD))
        at = (-0.08, 0.0, self.height + 0.15)
        parts.append(box((0.3, self.width + 0.24, 0.3), at, look.GRAY_PAINT))
        return standing("gate", seen_only(parts))


@dataclass(frozen=True)
class Tape(ObjectType):
    """Tape on the floor, round a rectangle."""

    length: float = number(2.0, "Of the rectangle, along x, to the tape's outer edge (m).", 0.1)
    width: float = number(1.5, "Of the rectangle, along y, to the tape's outer edge (m).", 0.1)
    tape: float = number(0.06, "Width of the tape (m).", 0.01, 1.0)
    color: Vector3 = rgb((0.90, 0.72, 0.12), "Red, green, blue, 0 to 1.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = recolored(look.YELLOW_PAINT, self.color)
        x, y = 0.5 * (self.length - self.tape), 0.5 * (self.width - self.tape)
        long, wide = (self.length, self.tape), (self.tape, self.width - 2.0 * self.tape)
        places = (((0.0, y), long), ((0.0, -y), long), ((x, 0.0), wide), ((-x, 0.0), wide))
        parts = tuple(
            box((*size, _TAPE_HEIGHT), (*at, 0.5 * _TAPE_HEIGHT), surface) for at, size in places
        )
        return standing("tape", seen_only(parts))

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        shorter = min(self.length, self.width)
        require(
            2.0 * self.tape < shorter,
            f"tape is {self.tape}; a rectangle of {self.length} x {self.width} has no room for it",
        )


TYPES = {
    "roof": Roof,
    "gate": Gate,
    "tape": Tape,
}
