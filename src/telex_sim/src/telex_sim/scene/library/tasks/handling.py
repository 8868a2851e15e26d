"""Things to grip and carry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Optional, Tuple

from telex_control.common.params import require

from ...model import Closer, Joint, Link, Motion, ObjectModel, SceneObject, Surface, Vector3
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import kilograms, number, numbers, parameter, rgb
from ..shapes import (
    LYING_X,
    Parts,
    box,
    cone,
    cylinder,
    mesh,
    opaque,
    placed,
    rigid,
    seen_only,
    sphere,
    tube,
)

_ROLLING = 0.0005
"""Rolling friction of round things to be handled (m)."""
_HARDWOOD, _STEEL = 700.0, 7850.0
"""Densities (kg/m3)."""


@dataclass(frozen=True)
class Briefcase(ObjectType):
    """Case with a handle on top, standing upright."""

    size: Vector3 = numbers(
        (0.45, 0.13, 0.33),
        "Of the case without its handle: length, thickness, height (m).",
        0.05,
        1.5,
    )
    mass: float = kilograms(5.0)
    handle: float = number(0.025, "Thickness of the square bar (m).", 0.01, 0.1)
    clearance: float = number(0.05, "Free height under the bar (m).", 0.02, 0.3)
    color: Vector3 = rgb((0.16, 0.14, 0.13))

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(self.size[0] >= 0.2, f"size[0] is {self.size[0]}; a handle needs at least 0.2")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z = self.size
        bar = self.handle
        shell = Surface(opaque(self.color), "generated:rubber", 0.3)
        top = z + self.clearance
        grip = (
            box((0.15, bar, bar), (0.0, 0.0, top + 0.5 * bar), look.RUBBER),
            *(
                box(
                    (bar, bar, self.clearance + bar),
                    (side * (0.075 + 0.5 * bar), 0.0, z + 0.5 * (self.clearance + bar)),
                    look.STEEL,
                )
                for side in (-1.0, 1.0)
            ),
        )
        parts = (box(self.size, (0.0, 0.0, 0.5 * z)), *grip, *seen_only(self._shell(shell)))
        return rigid("case", self.mass, parts)

    def _shell(self, shell: Surface) -> Parts:
        x, y, z = self.size
        edge = 0.014
        parts = [box((x - 0.004, y - 0.004, z - 0.004), (0.0, 0.0, 0.5 * z), shell)]
        # Two frames of aluminium where the halves meet, corners, locks and hinges.
        for height in (0.5 * edge, z - 0.5 * edge):
            parts.append(box((x, 0.03, edge), (0.0, 0.0, height), look.ALUMINIUM))
        for side in (-1.0, 1.0):
            parts.append(
                box((edge, 0.03, z), (side * 0.5 * (x - edge), 0.0, 0.5 * z), look.ALUMINIUM)
            )
            parts.append(box((0.045, 0.05, 0.006), (side * 0.33 * x, 0.0, z), look.STAINLESS))
            for depth in (-1.0, 1.0):
                for height in (0.02, z - 0.02):
                    at = (side * (0.5 * x - 0.02), depth * (0.5 * y - 0.02), height)
                    parts.append(box((0.04, 0.04, 0.04), at, look.ALUMINIUM))
        return tuple(parts)


@dataclass(frozen=True)
class Cube(ObjectType):
    """Cube to pick."""

    edge: float = number(0.05, "m; the tasks use 0.03 to 0.10.", 0.01, 1.0)
    mass: Optional[float] = kilograms(None, "kg; left out, that of hardwood (700 kg/m3).")
    color: Vector3 = rgb((0.85, 0.20, 0.12))
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        mass = _HARDWOOD * self.edge**3 if self.mass is None else self.mass
        # Of small pieces of wood one sees several rings.
        surface = Surface(opaque(self.color), "generated:wood", 0.1)
        part = box((self.edge,) * 3, (0.0, 0.0, 0.5 * self.edge), surface)
        return rigid("cube", mass, (part,), self.friction)


@dataclass(frozen=True)
class Cylinder(ObjectType):
    """Round bar to pick."""

    radius: float = number(0.03, "m.", 0.005, 3.0)
    length: float = number(0.15, "m.", 0.005, 3.0)
    mass: float = kilograms(0.4)
    color: Vector3 = rgb((0.20, 0.45, 0.25))
    lying: bool = parameter(False, "Lies along x instead of standing.")
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = Surface(opaque(self.color), "generated:painted_metal", 0.5)
        band = 0.1 * self.length
        standing = (
            cylinder(self.radius, self.length, (0.0, 0.0, 0.5 * self.length), surface),
            *(
                cylinder(1.002 * self.radius, band, (0.0, 0.0, at), look.WHITE, solid=False)
                for at in (0.2 * self.length, 0.8 * self.length)
            ),
        )
        parts = _laid(standing, self.length, self.radius) if self.lying else standing
        return rigid("cylinder", self.mass, parts, self.friction, _ROLLING)


@dataclass(frozen=True)
class Pipe(ObjectType):
    """Piece of pipe; it looks hollow, its wall is a fifth of the radius."""

    radius: float = number(0.025, "Outside (m).", 0.005, 1.0)
    length: float = number(0.4, "m.", 0.02, 12.0)
    mass: Optional[float] = kilograms(None, "kg; left out, that of steel.")
    lying: bool = parameter(True, "Lies along x instead of standing.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        r, length = self.radius, self.length
        wall = math.pi * (r**2 - (0.8 * r) ** 2) * length
        mass = _STEEL * wall if self.mass is None else self.mass
        middle = (0.0, 0.0, 0.5 * length)
        standing = (
            # One solid: it rolls round, where staves would rattle.
            cylinder(r, length, middle),
            tube(r, length, middle, look.STEEL),
        )
        parts = _laid(standing, length, r) if self.lying else standing
        return rigid("pipe", mass, parts, 1.0, _ROLLING)


@dataclass(frozen=True)
class Bottle(ObjectType):
    """Bottle with a neck and a cap."""

    radius: float = number(0.04, "m.", 0.01, 0.5)
    height: float = number(0.26, "m.", 0.05, 2.0)
    mass: float = kilograms(0.8)
    color: Vector3 = rgb((0.16, 0.42, 0.30))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        r, h = self.radius, self.height
        body, shoulder, neck = 0.62 * h, 0.18 * h, 0.35 * r
        glass = Surface(opaque(self.color))
        parts = (
            cylinder(r, body, (0.0, 0.0, 0.5 * body), glass),
            # The shoulder carries as a narrower cylinder.
            cylinder(0.6 * r, shoulder, (0.0, 0.0, body + 0.5 * shoulder)),
            cylinder(neck, h - body - shoulder, (0.0, 0.0, 0.5 * (h + body + shoulder)), glass),
            cone(0.999 * r, 1.23 * shoulder, (0.0, 0.0, body), glass),
            *seen_only(
                (
                    cylinder(1.003 * r, 0.5 * body, (0.0, 0.0, 0.5 * body), look.WHITE),
                    cylinder(1.005 * r, 0.03 * h, (0.0, 0.0, 0.62 * body), look.RED_PAINT),
                    cylinder(1.25 * neck, 0.08 * h, (0.0, 0.0, 0.966 * h), look.ORANGE),
                )
            ),
        )
        return rigid("bottle", self.mass, parts, 0.8, _ROLLING)


@dataclass(frozen=True)
class Sphere(ObjectType):
    """Ball to pick."""

    radius: float = number(0.04, "m.", 0.005, 0.5)
    mass: float = kilograms(0.5)
    color: Vector3 = rgb((0.90, 0.42, 0.08))
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        r, at = self.radius, (0.0, 0.0, self.radius)
        parts = (
            sphere(r, at, Surface(opaque(self.color))),
            # Shows how it turns.
            cylinder(1.004 * r, 0.25 * r, at, look.WHITE, solid=False),
        )
        return rigid("sphere", self.mass, parts, self.friction, _ROLLING)


@dataclass(frozen=True)
class Wedge(ObjectType):
    """Wedge to pick; it rises along x."""

    length: float = number(0.12, "Along x, y and z (m).", 0.01, 1.0)
    width: float = number(0.06, "Along x, y and z (m).", 0.01, 1.0)
    height: float = number(0.06, "Along x, y and z (m).", 0.01, 1.0)
    mass: Optional[float] = kilograms(None, "kg; left out, that of hardwood (700 kg/m3).")
    color: Vector3 = rgb((0.88, 0.74, 0.15))
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        size = (self.length, self.width, self.height)
        volume = 0.5 * self.length * self.width * self.height
        mass = _HARDWOOD * volume if self.mass is None else self.mass
        surface = Surface(opaque(self.color), "generated:wood", 0.4)
        # It is convex, so that what is seen can be touched as well.
        part = replace(mesh("wedge", size, (0.0, 0.0, 0.0), surface), solid=True)
        return rigid("wedge", mass, (part,), self.friction)


@dataclass(frozen=True)
class Plate(ObjectType):
    """Flat plate of steel, standing on its edge or lying."""

    size: Vector3 = numbers(
        (0.15, 0.01, 0.10),
        "Length, thickness and height as it stands: along x, y and z (m).",
        0.002,
        1.5,
    )
    mass: Optional[float] = kilograms(None, "kg; left out, that of steel.")
    lying: bool = parameter(False, "Lies on its side instead of standing.")
    friction: float = number(1.0, "Of its surface.", 0.0, 2.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z = self.size
        mass = _STEEL * x * y * z if self.mass is None else self.mass
        size = (x, z, y) if self.lying else self.size
        part = box(size, (0.0, 0.0, 0.5 * size[2]), look.STAINLESS)
        return rigid("plate", mass, (part,), self.friction)


_SWAB = (0.015, 0.17)
"""Radius of a swab's handle, and its whole length (m)."""
_TIP = (0.011, 0.005, 0.035)
"""Radius of a swab's tip and of its stick, and how far it looks out of the handle (m)."""
_TIP_MASS = 0.02  # kg


@dataclass(frozen=True)
class Swab(ObjectType):
    """Swab to sample a surface with, standing on its tip, whose stick gives way into its handle."""

    travel: float = number(0.025, "How far its stick gives way (m).", 0.005, 0.03)
    preload: float = number(1.0, "Force at which it begins to give way (N).", 0.5, 20.0)
    spring: float = number(400.0, "What each metre of that way adds (N/m).", 0.0, 1000.0)
    mass: float = kilograms(0.1, "Of its handle (kg).")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        (radius, whole), (tip, stick, out) = _SWAB, _TIP
        grip = whole - out
        handle = (
            cylinder(radius, grip, (0.0, 0.0, out + 0.5 * grip), look.BLUE_PAINT),
            cylinder(1.01 * radius, 0.01, (0.0, 0.0, out + 0.01), look.WHITE, solid=False),
        )
        end = (
            sphere(tip, (0.0, 0.0, tip), look.WHITE),
            cylinder(stick, out, (0.0, 0.0, 0.5 * out), look.WOOD, solid=False),
        )
        slide = Joint(
            "stick",
            Motion.SLIDE,
            "handle",
            "tip",
            upper=self.travel,
            damping=4.0,
            closer=Closer(self.preload, self.spring),
        )
        links = (Link("handle", self.mass, handle), Link("tip", _TIP_MASS, end))
        return single(ObjectModel(links, (slide,)))


def _laid(standing: Parts, length: float, radius: float) -> Parts:
    """Lay what stands upright along x, about the middle of its footprint."""
    return placed(standing, (-0.5 * length, 0.0, radius), LYING_X)


TYPES = {
    "briefcase": Briefcase,
    "cube": Cube,
    "cylinder": Cylinder,
    "pipe": Pipe,
    "bottle": Bottle,
    "sphere": Sphere,
    "wedge": Wedge,
    "plate": Plate,
    "swab": Swab,
}
