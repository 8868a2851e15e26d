"""Task panels of the dexterity tests (after ASTM E3408 and its relatives).

They look towards -x, as everything mounted (`telex_sim.scene.library.tasks.mounts`); their height
is that of the panel's middle. The tests use 0.1, 0.8 and 1.5 m.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.geometry.quaternions import product, rotate
from telex_control.common.params import require

from ...model import Closer, Joint, Link, Motion, ObjectModel, SceneObject, Vector3
from ...textures.optotypes import sealed_angle
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, number, token
from ..shapes import (
    LYING_X,
    TOWARDS_US,
    Parts,
    box,
    cylinder,
    placed,
    seen_only,
    standing,
    staves,
    tube,
    yawed,
)
from .mounts import MOUNTS, PLATE, SEATED, mount

_PIPE_RADIUS = 0.025


@dataclass(frozen=True)
class InspectionPipes(ObjectType):
    """Pipes of 50 mm to look into, with a Landolt ring at the bottom of each."""

    layout: str = choice(
        "star",
        ("row", "star"),
        "row: five side by side; star: one straight on, four at 45 degrees round it.",
    )
    length: float = number(0.6, "Of the pipes (m).", 0.05, 1.0)
    height: float = number(
        0.8, "Of the middle over the floor (m); a star's pipes need room below.", 0.05, 2.5
    )
    seed: int = number(1, "Which way the rings are open.", 0, 2**31 - 1)
    sealed: str = token(
        "A token in place of the seed, which tells nobody which way; see `scene.sealed`."
    )
    mounting: str = choice("stand", MOUNTS)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        lowest = 0.1 + math.sqrt(0.5) * self.length
        require(
            self.layout == "row" or self.height >= lowest,
            f"height is {self.height}; the lowest pipe of a star needs at least {lowest:.2f}",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        parts: List = list(mount(self.mounting, self.height, 0.62, 0.3, look.PLYWOOD))
        for index, ((offset, turn), gap) in enumerate(zip(self._places(), self.gaps())):
            # Pipes stand on z = 0 and point along z, towards us; those of the star lean outwards.
            opens = f"sealed={self.sealed}&of={index}" if self.sealed else f"angle={gap}"
            pipe = self._pipe(opens)
            parts.extend(placed(placed(pipe, offset, turn), self._centre, TOWARDS_US))
        if self.layout == "star":
            parts.append(box((0.06, 0.1, 0.1), (-PLATE - 0.03, 0.0, self.height), look.PLYWOOD))
        return standing("pipes", tuple(parts))

    def _places(self) -> List[Tuple[Vector3, Tuple[float, float, float, float]]]:
        upright = (0.0, 0.0, 0.0, 1.0)
        if self.layout == "row":
            return [((0.0, (index - 2) * 0.12, 0.0), upright) for index in range(5)]
        places: List[Tuple[Vector3, Tuple[float, float, float, float]]] = []
        places.append(((0.0, 0.0, 0.06), upright))
        for quarter in range(4):
            around = yawed(0.5 * math.pi * quarter)
            lean = rotate(around, (0.052, 0.0, 0.028))
            # About y, z turns towards x.
            places.append((lean, product(around, _LEANING)))
        return places

    def mouths(self) -> List[Tuple[Vector3, Vector3]]:
        """Middle of each pipe's open end (m), and where it points to, in the object's frame."""
        x, y, z = self._centre
        found = []
        for offset, turn in self._places():
            axis = rotate(TOWARDS_US, rotate(turn, (0.0, 0.0, 1.0)))
            dx, dy, dz = rotate(TOWARDS_US, offset)
            length = self.length
            end = (x + dx + length * axis[0], y + dy + length * axis[1], z + dz + length * axis[2])
            found.append((end, axis))
        return found

    @property
    def _centre(self) -> Vector3:
        return (-PLATE, 0.0, self.height)

    def gaps(self) -> List[int]:
        """Where the ring of each pipe opens (degrees, anticlockwise from the right)."""
        if self.sealed:
            return [sealed_angle("C", self.sealed, index) for index in range(5)]
        numbers = random.Random(self.seed)
        return [45 * int(8.0 * numbers.random()) for _ in range(5)]

    def _pipe(self, opens: str) -> Parts:
        length = self.length
        edge = 1.5 * _PIPE_RADIUS
        ring = look.picture(f"optotype?kind=C&{opens}", glow=0.35)
        return (
            cylinder(_PIPE_RADIUS, length, (0.0, 0.0, 0.5 * length)),
            tube(_PIPE_RADIUS, length, (0.0, 0.0, 0.5 * length), look.LIGHT_PAINT),
            *seen_only(
                (
                    cylinder(0.9 * _PIPE_RADIUS, 0.004, (0.0, 0.0, 0.002), look.WHITE),
                    box((edge, edge, 0.002), (0.0, 0.0, 0.006), ring),
                    tube(1.12 * _PIPE_RADIUS, 0.02, (0.0, 0.0, length - 0.01), look.BLUE_PAINT),
                )
            ),
        )


_LEANING = (0.0, math.sin(math.pi / 8.0), 0.0, math.cos(math.pi / 8.0))
"""45 degrees about y."""


@dataclass(frozen=True)
class TouchPanel(ObjectType):
    """Blocks with dots to touch, which stand fast or give way on springs."""

    count: int = number(5, "Blocks side by side.", 1, 10)
    dot: float = number(0.02, "Diameter of a dot (m); the tests allow 0.01 of error.", 0.004, 0.08)
    travel: float = number(
        0.0, "How far a block gives way on its spring (m); 0: it stands fast.", 0.0, 0.05
    )
    spring: float = number(
        800.0, "What each metre of that way adds to the 4 N that it begins with (N/m).", 0.0, 1.0e5
    )
    height: float = number(0.8, "Of the middle over the floor (m).", 0.08, 2.5)
    mounting: str = choice("stand", MOUNTS)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        panel: List = list(mount(self.mounting, self.height, _row(self.count), 0.26, look.PLYWOOD))
        front = -PLATE - _BLOCK
        if self.travel == 0.0:
            for at in columns(self.count):
                panel.extend(placed(self._block(_BLOCK), (front, at, self.height)))
            return standing("panel", tuple(panel))
        links, joints = [], []
        for index, at in enumerate(columns(self.count)):
            guide = cylinder(0.02, _BLOCK, (0.5 * front, at, self.height), look.STEEL, LYING_X)
            panel.extend(seen_only((guide,)))
            name = f"block_{index + 1}"
            links.append(Link(name, 0.3, self._block(_BLOCK - self.travel)))
            joints.append(
                Joint(
                    f"{name}_slide",
                    Motion.SLIDE,
                    "panel",
                    name,
                    position=(front, at, self.height),
                    axis=(1.0, 0.0, 0.0),
                    upper=self.travel,
                    damping=20.0,
                    closer=Closer(_PRELOAD, self.spring),
                )
            )
        model = ObjectModel((Link("panel", 0.0, tuple(panel)), *links), tuple(joints), static=True)
        return single(model)

    def _block(self, deep: float) -> Parts:
        """Block behind x = 0 with a dot on its face."""
        dots = (
            cylinder(radius, thick, (-0.5 * thick, 0.0, 0.0), surface, LYING_X)
            for radius, thick, surface in (
                (0.040, 0.001, look.BLACK),
                (0.034, 0.002, look.WHITE),
                (0.5 * self.dot, 0.003, look.RED_PAINT),
            )
        )
        return (
            box((deep, 0.1, 0.1), (0.5 * deep, 0.0, 0.0), look.WOOD),
            *seen_only(tuple(dots)),
        )


@dataclass(frozen=True)
class RotatePanel(ObjectType):
    """Caps to turn by half a turn."""

    count: int = number(5, "Caps side by side.", 1, 10)
    width: float = number(0.05, "Of a cap's grip (m).", 0.02, 0.1)
    friction: float = number(0.5, "Torque below which a cap does not turn (N m).", 0.0, 100.0)
    height: float = number(0.8, "Of the middle over the floor (m).", 0.08, 2.5)
    mounting: str = choice("stand", MOUNTS)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        panel: List = list(mount(self.mounting, self.height, _row(self.count), 0.26, look.PLYWOOD))
        links, joints = [], []
        base = 0.05
        for index, at in enumerate(columns(self.count)):
            middle = (-PLATE - 0.5 * base, at, self.height)
            panel.append(cylinder(0.045, base, middle, look.LIGHT_PAINT, LYING_X))
            for mark, surface in ((0.055, look.RED_PAINT), (-0.055, look.GREEN_PAINT)):
                panel.append(
                    box(
                        (0.002, 0.008, 0.016),
                        (-PLATE - 0.001, at, self.height + mark),
                        surface,
                        solid=False,
                    )
                )
            name = f"cap_{index + 1}"
            links.append(Link(name, 0.3, self._cap()))
            joints.append(
                Joint(
                    f"{name}_hinge",
                    Motion.HINGE,
                    "panel",
                    name,
                    position=(-PLATE - base - 0.001, at, self.height),
                    orientation=TOWARDS_US,
                    upper=math.pi,
                    friction=self.friction,
                    damping=0.01,
                )
            )
        model = ObjectModel((Link("panel", 0.0, tuple(panel)), *links), tuple(joints), static=True)
        return single(model)

    def _cap(self) -> Parts:
        """Cap that points along z, with a bar across and a mark at one end of it."""
        half = 0.042
        return (
            cylinder(half, 0.02, (0.0, 0.0, 0.01), look.BLUE_PAINT),
            box((2.0 * half, 0.45 * self.width, 0.045), (0.0, 0.0, 0.0425), look.BLUE_PAINT),
            box((0.016, 0.008, 0.001), (half - 0.012, 0.0, 0.0655), look.WHITE, solid=False),
        )


@dataclass(frozen=True)
class ExtractPanel(ObjectType):
    """Caps that stick in holes, to be pulled out towards -x."""

    count: int = number(5, "Side by side.", 1, 10)
    radius: float = number(0.025, "Of a cap (m).", 0.01, 0.04)
    hold: float = number(15.0, "Pull at which one comes out (N).", 3.0, 1000.0)
    height: float = number(0.8, "Of the middle over the floor (m).", 0.08, 2.5)
    mounting: str = choice("stand", MOUNTS)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        panel: List = list(mount(self.mounting, self.height, _row(self.count), 0.26, look.PLYWOOD))
        links, joints = [], []
        deep, gap = 0.04, 0.003
        for index, at in enumerate(columns(self.count)):
            middle = (-PLATE - 0.5 * deep, at, self.height)
            hole = staves(self.radius + gap, self.radius + 0.012, deep, 8, look.DARK_STEEL)
            panel.extend(placed(hole, middle, TOWARDS_US))
            name = f"cap_{index + 1}"
            links.append(Link(name, 0.2, self._cap(deep - 0.005)))
            joints.append(
                Joint(
                    f"{name}_latch",
                    Motion.LATCH,
                    "panel",
                    name,
                    position=(-PLATE - deep, at, self.height),
                    orientation=TOWARDS_US,
                    hold=self.hold,
                    across=SEATED,
                )
            )
        model = ObjectModel((Link("panel", 0.0, tuple(panel)), *links), tuple(joints), static=True)
        return single(model)

    def _cap(self, inside: float) -> Parts:
        """Cap that points along z, out of its hole; z = 0 is the rim."""
        out = 0.08
        length = inside + out
        return (
            cylinder(self.radius, length, (0.0, 0.0, 0.5 * (out - inside)), look.ORANGE),
            cylinder(1.01 * self.radius, 0.012, (0.0, 0.0, out - 0.02), look.WHITE, solid=False),
        )


@dataclass(frozen=True)
class PlacePanel(ObjectType):
    """Tray with holes from above, to put cylinders or caps in."""

    count: int = number(5, "Holes side by side.", 1, 10)
    radius: float = number(0.035, "Of a hole (m).", 0.01, 0.06)
    depth: float = number(0.06, "Of a hole (m).", 0.01, 0.2)
    height: float = number(
        0.8, "Of the tray's upper side over the floor (m).", lambda own: own.depth + 0.02, 2.5
    )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        wide, deep, thick = _row(self.count), 0.2, 0.015
        bottom = self.height - self.depth
        parts: List = [
            box((deep, wide, thick), (0.0, 0.0, bottom - 0.5 * thick), look.PLYWOOD),
        ]
        for at in columns(self.count):
            middle = (0.0, at, bottom + 0.5 * self.depth)
            parts.extend(
                placed(
                    staves(self.radius, self.radius + 0.008, self.depth, 8, look.LIGHT_PAINT),
                    middle,
                )
            )
            parts.append(
                cylinder(
                    self.radius, 0.002, (0.0, at, bottom + 0.001), look.GREEN_PAINT, solid=False
                )
            )
        post = bottom - thick
        if post > 0.03:
            parts.append(box((0.08, 0.08, post), (0.0, 0.0, 0.5 * post), look.GRAY_PAINT))
            parts.append(box((0.4, 0.45, 0.012), (0.0, 0.0, 0.006), look.DARK_STEEL))
        else:
            parts.append(box((deep, wide, post), (0.0, 0.0, 0.5 * post), look.DARK_STEEL))
        return standing("tray", tuple(parts))


_SPACING = 0.13
_BLOCK = 0.1
"""From a touch panel's plate to the face of its blocks (m)."""
_PRELOAD = 4.0
"""With which a block's spring begins (N): more than what friction could hold."""


def _row(count: int) -> float:
    """Width of a panel with so many places (m)."""
    return count * _SPACING + 0.02


def columns(count: int) -> List[float]:
    """Where the places lie along y (m)."""
    return [(index - 0.5 * (count - 1)) * _SPACING for index in range(count)]


TYPES = {
    "inspection_pipes": InspectionPipes,
    "touch_panel": TouchPanel,
    "rotate_panel": RotatePanel,
    "extract_panel": ExtractPanel,
    "place_panel": PlacePanel,
}
