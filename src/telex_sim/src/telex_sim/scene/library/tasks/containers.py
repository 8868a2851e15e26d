"""Crates, pallets, bins and barrels."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.params import require

from ...model import Link, ObjectModel, SceneObject, Surface, Vector3
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, kilograms, number, numbers, parameter, rgb
from ..shapes import SHEET, Parts, beam, box, cylinder, opaque, open_box, rigid, seen_only


def _wooden(size: Vector3) -> Parts:
    """Boards with a frame of battens on every side."""
    x, y, z = size
    wide = min(0.08, 0.2 * min(size))
    thick = min(0.015, 0.1 * min(size))
    core = box((x - 2 * thick, y - 2 * thick, z - 2 * thick), (0.0, 0.0, 0.5 * z), look.WOOD)
    parts = [core]
    battens = look.OLD_WOOD
    # Each edge has a bar as thick as both battens that meet there; they reach past one another.
    for low in (0.5 * wide, z - 0.5 * wide):
        for side in (-1.0, 1.0):
            at = side * 0.5 * (y - wide)
            parts.append(beam((-0.5 * x, at, low), (0.5 * x, at, low), wide, wide, battens))
            at = side * 0.5 * (x - wide)
            start, end = -0.5 * y + wide, 0.5 * y - wide
            parts.append(beam((at, start, low), (at, end, low), wide, wide, battens))
    for side_x in (-1.0, 1.0):
        for side_y in (-1.0, 1.0):
            px, py = side_x * 0.5 * (x - wide), side_y * 0.5 * (y - wide)
            parts.append(beam((px, py, wide), (px, py, z - wide), wide, wide, battens))
    for side in (-1.0, 1.0):
        at = side * 0.5 * (y - 1.2 * thick)
        lower = (-0.5 * x + 0.8 * wide, at, 0.8 * wide)
        upper = (0.5 * x - 0.8 * wide, at, z - 0.8 * wide)
        parts.append(beam(lower, upper, 0.8 * thick, 0.8 * wide, battens))
    return tuple(parts)


def _cardboard(size: Vector3) -> Parts:
    x, y, z = size
    tape = look.plain(0.70, 0.52, 0.30)
    return (
        box(size, (0.0, 0.0, 0.5 * z), look.CARDBOARD),
        box((x + 0.001, 0.05, 0.001), (0.0, 0.0, z), tape),
        *(
            box((0.001, 0.05, 0.25 * z), (side * 0.5 * x, 0.0, 0.875 * z), tape)
            for side in (-1.0, 1.0)
        ),
        box((0.3 * x, 0.001, 0.3 * z), (0.2 * x, -0.5 * y, 0.6 * z), look.WHITE),
    )


def _aluminium(size: Vector3) -> Parts:
    x, y, z = size
    edge = min(0.03, 0.1 * min(size))
    parts = [box((x - 0.006, y - 0.006, z - 0.006), (0.0, 0.0, 0.5 * z), look.STAINLESS)]
    profile = look.ALUMINIUM
    for low in (0.5 * edge, 0.72 * z, z - 0.5 * edge):
        for side in (-1.0, 1.0):
            parts.append(box((x, edge, edge), (0.0, side * 0.5 * (y - edge), low), profile))
            parts.append(box((edge, y, edge), (side * 0.5 * (x - edge), 0.0, low), profile))
    for side_x in (-1.0, 1.0):
        for side_y in (-1.0, 1.0):
            at = (side_x * 0.5 * (x - edge), side_y * 0.5 * (y - edge), 0.5 * z)
            parts.append(box((edge, edge, z), at, profile))
            parts.append(
                box((0.04, 0.004, 0.05), (side_x * 0.3 * x, side_y * 0.5 * y, 0.72 * z), look.BLACK)
            )
    return tuple(parts)


_CRATES = {"wood": _wooden, "cardboard": _cardboard, "aluminium": _aluminium}


@dataclass(frozen=True)
class Crate(ObjectType):
    """Wooden or cardboard box, closed."""

    size: Vector3 = numbers((0.6, 0.4, 0.4), "Full extents (m).", 0.05, 5.0)
    mass: float = kilograms(12.0)
    material: str = choice("wood", _CRATES)
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)
    static: bool = parameter(False, "Whether it stands fast.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        solid = box(self.size, (0.0, 0.0, 0.5 * self.size[2]))
        parts = (solid, *seen_only(_CRATES[self.material](self.size)))
        return rigid("crate", self.mass, parts, self.friction, static=self.static)


_BOARD = 0.022
"""Thickness of a pallet's boards (m)."""


@dataclass(frozen=True)
class Pallet(ObjectType):
    """Pallet after EN 13698-1: 1.2 x 0.8 m, of boards and blocks."""

    length: float = number(1.2, "m.", 0.6, 3.0)
    width: float = number(0.8, "m.", 0.6, 3.0)
    height: float = number(
        0.144, "m; the blocks take what the three layers of boards leave.", 0.1, 0.3
    )
    mass: float = kilograms(25.0)
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)
    static: bool = parameter(False, "Whether it stands fast.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        return single(self.model())

    def model(self) -> ObjectModel:
        """Make the pallet alone."""
        return ObjectModel(
            (Link("pallet", self.mass, self._parts(), self.friction),), static=self.static
        )

    def _parts(self) -> Parts:
        x, y, z = 0.5 * self.length, 0.5 * self.width, self.height
        block = z - 3.0 * _BOARD
        outer, middle = 0.1, 0.145
        parts: List = []

        def board(start: Vector3, end: Vector3, width: float, surface: Surface) -> None:
            parts.append(beam(start, end, width, _BOARD, surface))

        rows = ((-y + 0.5 * outer, outer), (0.0, middle), (y - 0.5 * outer, outer))
        columns = (-x + 0.5 * middle, 0.0, x - 0.5 * middle)
        for at, width in rows:
            board((-x, at, 0.5 * _BOARD), (x, at, 0.5 * _BOARD), width, look.OLD_WOOD)
            for column in columns:
                middle_height = _BOARD + 0.5 * block
                size = (middle, width, block)
                parts.append(box(size, (column, at, middle_height), look.OLD_WOOD))
        low = _BOARD + block + 0.5 * _BOARD
        for column in columns:
            board((column, -y, low), (column, y, low), middle, look.OLD_WOOD)
        high = z - 0.5 * _BOARD
        for index in range(5):
            width = middle if index % 2 == 0 else outer
            at = (index - 2) * 0.5 * (y - 0.5 * middle)
            board((-x, at, high), (x, at, high), width, look.WOOD)
        return tuple(parts)


@dataclass(frozen=True)
class PalletStack(ObjectType):
    """Pallets on top of one another, each free."""

    count: int = number(4, "How many.", 1, 12)
    height: float = number(0.125, "Of one pallet (m): four of 0.125 make a step of 0.5.", 0.1, 0.3)
    mass: float = kilograms(25.0, "Of one pallet (kg).")
    static: bool = parameter(False, "Whether they stand fast.")
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        pallet = Pallet(
            height=self.height, mass=self.mass, friction=self.friction, static=self.static
        ).model()
        return tuple(
            SceneObject(str(index + 1), pallet, (0.0, 0.0, index * self.height))
            for index in range(self.count)
        )


@dataclass(frozen=True)
class Bin(ObjectType):
    """Box without a lid, to put things in."""

    size: Vector3 = numbers((0.4, 0.3, 0.18), "Full extents (m).", 0.05, 3.0)
    wall: float = number(0.008, "Thickness (m).", 0.003, 0.1)
    mass: float = kilograms(1.5)
    color: Vector3 = rgb((0.16, 0.36, 0.62))
    label: str = parameter("", "Written on its long sides; letters, digits and spaces.")
    static: bool = parameter(False, "Whether it stands fast.")

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            2.0 * self.wall < min(self.size[:2]) and self.wall < self.size[2],
            f"wall is {self.wall}; a bin of {list(self.size)} has no room inside",
        )
        require(
            all(character.isalnum() or character == " " for character in self.label),
            f"label is {self.label!r}; only letters, digits and spaces are possible",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        return rigid("bin", self.mass, self._parts(), static=self.static)

    def _parts(self) -> Parts:
        x, y, z = self.size
        surface = Surface(opaque(self.color))
        inner = (x - 2.0 * self.wall, y - 2.0 * self.wall, z - self.wall)
        parts = list(open_box(inner, self.wall, surface))
        # A rim outside, for the look and for fingers.
        rim = 0.012
        for side in (-1.0, 1.0):
            along = box(
                (x + 2.0 * rim, rim, rim), (0.0, side * 0.5 * (y + rim), z - 0.5 * rim), surface
            )
            across = box((rim, y, rim), (side * 0.5 * (x + rim), 0.0, z - 0.5 * rim), surface)
            parts += [along, across]
            if self.label:
                aspect = min(10.0, max(0.1, 0.6 * x / (0.5 * z)))
                query = f"text={self.label.replace(' ', '+')}&aspect={aspect:.2f}"
                text = look.picture(f"label?{query}")
                plate = (0.6 * x, SHEET, 0.5 * z)
                at = (0.0, side * 0.5 * (y + SHEET), 0.5 * z)
                parts.append(box(plate, at, text, solid=False))
        return tuple(parts)


@dataclass(frozen=True)
class Barrel(ObjectType):
    """Steel drum of 200 litres."""

    radius: float = number(0.29, "m.", 0.05, 3.0)
    height: float = number(0.88, "m.", 0.05, 3.0)
    mass: float = kilograms(22.0)
    color: Vector3 = rgb((0.13, 0.33, 0.55))
    friction: float = number(0.8, "Of its surface.", 0.0, 2.0)
    static: bool = parameter(False, "Whether it stands fast.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        r, h = self.radius, self.height
        paint = Surface(opaque(self.color), "generated:painted_metal", 1.0)
        hoops = [
            cylinder(r, 0.02, (0.0, 0.0, at), paint) for at in (0.01, 0.34 * h, 0.66 * h, h - 0.01)
        ]
        top = 0.012
        parts = (
            cylinder(r, h, (0.0, 0.0, 0.5 * h)),
            *seen_only(
                (
                    cylinder(0.96 * r, h - 2.0 * top, (0.0, 0.0, 0.5 * h), paint),
                    *hoops,
                    cylinder(0.9 * r, 0.004, (0.0, 0.0, h), look.DARK_STEEL),
                    cylinder(0.1 * r, 0.012, (0.6 * r, 0.0, h), look.STEEL),
                    cylinder(0.06 * r, 0.012, (-0.6 * r, 0.2 * r, h), look.STEEL),
                )
            ),
        )
        return rigid("barrel", self.mass, parts, self.friction, 0.002, static=self.static)


TYPES = {
    "crate": Crate,
    "pallet": Pallet,
    "pallet_stack": PalletStack,
    "bin": Bin,
    "barrel": Barrel,
}
