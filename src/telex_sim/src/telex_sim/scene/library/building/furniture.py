"""Tables, shelves and cabinets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Tuple

from telex_control.common.params import require

from ...model import Joint, Link, Motion, ObjectModel, SceneObject
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import kilograms, number, parameter
from ..shapes import Parts, box, open_box, rod, standing, steel_post


@dataclass(frozen=True)
class Table(ObjectType):
    """Table on four legs, with an apron."""

    length: float = number(1.2, "m.", 0.2, 10.0)
    width: float = number(0.7, "m.", 0.2, 10.0)
    height: float = number(0.75, "m.", 0.1, 3.0)
    top: float = number(0.03, "Thickness of its top (m).", 0.01, 0.1)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z = self.length, self.width, self.height
        leg, inset = 0.05, 0.04
        under = z - self.top
        apron = min(0.06, 0.5 * under)
        parts = [
            box((x, y, self.top), (0.0, 0.0, z - 0.5 * self.top), look.PLYWOOD),
            box(
                (x + 0.004, y + 0.004, 0.6 * self.top),
                (0.0, 0.0, z - 0.5 * self.top),
                look.BLACK,
                solid=False,
            ),
        ]
        dx, dy = 0.5 * x - inset - 0.5 * leg, 0.5 * y - inset - 0.5 * leg
        for side_x in (-1.0, 1.0):
            for side_y in (-1.0, 1.0):
                parts.append(
                    steel_post(under, leg, (side_x * dx, side_y * dy, 0.0), look.GRAY_PAINT)
                )
        level = under - 0.5 * apron
        for side in (-1.0, 1.0):
            parts.append(
                box((2.0 * dx - leg, 0.03, apron), (0.0, side * dy, level), look.GRAY_PAINT)
            )
            parts.append(
                box((0.03, 2.0 * dy - leg, apron), (side * dx, 0.0, level), look.GRAY_PAINT)
            )
        return standing("table", tuple(parts))


@dataclass(frozen=True)
class Shelf(ObjectType):
    """Rack of boards on uprights, open in front (-x side) and behind."""

    width: float = number(1.0, "m; the width lies along y.", 0.2, 6.0)
    depth: float = number(0.4, "m; the width lies along y.", 0.2, 6.0)
    height: float = number(1.5, "m; the width lies along y.", 0.3, 4.0)
    levels: int = number(4, "Boards, the lowest 0.1 m above the floor, the highest on top.", 2, 12)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        post, board = 0.04, 0.025
        dx, dy = 0.5 * (self.depth - post), 0.5 * (self.width - post)
        parts = [
            steel_post(self.height, post, (side_x * dx, side_y * dy, 0.0), look.BLUE_PAINT)
            for side_x in (-1.0, 1.0)
            for side_y in (-1.0, 1.0)
        ]
        # The topmost board ends flush with the uprights.
        step = (self.height - 0.1 - board) / (self.levels - 1)
        for level in range(self.levels):
            height = 0.1 + 0.5 * board + level * step
            size = (self.depth - 0.045, self.width - 2.0 * post, board)
            parts.append(box(size, (0.0, 0.0, height), look.PLYWOOD))
            for side in (-1.0, 1.0):
                rail = (0.025, self.width - 2.0 * post, 0.05)
                at = (side * 0.5 * (self.depth - 0.02), 0.0, height - 0.5 * (0.05 - board))
                parts.append(box(rail, at, look.ORANGE))
        for side in (-1.0, 1.0):
            for low, high in ((0.15, 0.5), (0.5, 0.85)):
                start = (-dx, side * dy, low * self.height)
                end = (dx, side * dy, high * self.height)
                parts.append(rod(start, end, 0.008, look.BLUE_PAINT, solid=False))
        return standing("shelf", tuple(parts))


@dataclass(frozen=True)
class Drawers(ObjectType):
    """Cabinet with drawers that slide out towards -x, each with a bar to pull."""

    count: int = number(3, "Drawers above one another.", 1, 8)
    width: float = number(0.5, "Of the cabinet (m); the width lies along y.", 0.2, 3.0)
    depth: float = number(0.5, "Of the cabinet (m); the width lies along y.", 0.2, 3.0)
    height: float = number(0.75, "Of the cabinet (m); the width lies along y.", 0.2, 3.0)
    friction: float = number(6.0, "Of a drawer's slide (N).", 0.0)
    travel: Optional[float] = number(
        None,
        "How far a drawer slides (m); left out, 0.8 of the depth.",
        0.05,
        lambda own: 0.95 * own.depth,
    )
    handle: float = number(0.025, "Thickness of the bar (m).", 0.01, 0.05)
    mass: float = kilograms(3.0, "Of a drawer (kg).")
    opened: Tuple[float, ...] = parameter(
        (), "How far each drawer is open at the start (m), from below; shut where there is none."
    )

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.height / self.count >= 0.12,
            f"height is {self.height}; {self.count} drawers need at least {0.12 * self.count:g}",
        )
        require(
            len(self.opened) <= self.count and all(0.0 <= at <= self.stroke for at in self.opened),
            f"opened is {list(self.opened)}; at most {self.count} numbers from 0 to {self.stroke:g}"
            " are needed",
        )

    @property
    def stroke(self) -> float:
        """How far a drawer slides (m)."""
        return 0.8 * self.depth if self.travel is None else self.travel

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        pitch = (self.height - 2.0 * _SHEET) / self.count
        drawer = self._drawer(pitch)
        links = [Link("cabinet", 0.0, self._cabinet(pitch))]
        joints = []
        for index in range(self.count):
            name = f"drawer_{index + 1}"
            links.append(Link(name, self.mass, drawer))
            joints.append(
                Joint(
                    f"{name}_slide",
                    Motion.SLIDE,
                    "cabinet",
                    name,
                    position=(0.0, 0.0, _SHEET + index * pitch + 0.004),
                    axis=(-1.0, 0.0, 0.0),
                    upper=self.stroke,
                    start=self.opened[index] if index < len(self.opened) else 0.0,
                    friction=self.friction,
                    damping=2.0,
                )
            )
        return single(ObjectModel(tuple(links), tuple(joints), static=True))

    def _cabinet(self, pitch: float) -> Parts:
        x, y, z = self.depth, self.width, self.height
        paint = look.GRAY_PAINT
        parts = [
            box((x, y, _SHEET), (0.0, 0.0, 0.5 * _SHEET), paint),
            box((x, y, _SHEET), (0.0, 0.0, z - 0.5 * _SHEET), paint),
            box((_SHEET, y, z - 2.0 * _SHEET), (0.5 * (x - _SHEET), 0.0, 0.5 * z), paint),
        ]
        for side in (-1.0, 1.0):
            size = (x - _SHEET, _SHEET, z - 2.0 * _SHEET)
            parts.append(box(size, (-0.5 * _SHEET, side * 0.5 * (y - _SHEET), 0.5 * z), paint))
        return tuple(parts)

    def _drawer(self, pitch: float) -> Parts:
        """Drawer about the cabinet's middle; its front closes the cabinet."""
        gap, wall = 0.003, 0.008
        front = 0.018
        inside = self.depth - _SHEET - front - 0.01
        inner = (inside - 2.0 * wall, self.width - 2.0 * (_SHEET + 0.008 + wall), 0.6 * pitch)
        middle = -0.5 * self.depth + front + 0.5 * inside
        bar, away = self.handle, 0.05
        face = (front, self.width - 2.0 * (_SHEET + gap), pitch - 0.008)
        at = -0.5 * self.depth + 0.5 * front
        grip = -0.5 * self.depth - away - 0.5 * bar
        height = 0.5 * face[2]
        reach = 0.5 * min(0.16, 0.6 * face[1])
        return (
            *open_box(inner, wall, look.PLYWOOD, (middle, 0.0, 0.0)),
            box(face, (at, 0.0, height), look.BLUE_PAINT),
            box((bar, 2.0 * reach, bar), (grip, 0.0, height), look.ALUMINIUM),
            *(
                box(
                    (away, bar, bar),
                    (-0.5 * self.depth - 0.5 * away, side * (reach - 0.5 * bar), height),
                    look.ALUMINIUM,
                )
                for side in (-1.0, 1.0)
            ),
            box(
                (0.002, 0.09, 0.03),
                (-0.5 * self.depth - 0.001, 0.0, face[2] - 0.025),
                look.WHITE,
                solid=False,
            ),
        )


_SHEET = 0.015
"""Thickness of the cabinet's walls (m)."""

TYPES = {"table": Table, "shelf": Shelf, "drawers": Drawers}
