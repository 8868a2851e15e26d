"""Fixtures and loose objects: cones, lamps, trays, hoses, rails, racks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from ...model import SceneObject, Vector3
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, kilograms, number, numbers, parameter, rgb
from ..shapes import (
    LYING_X,
    Parts,
    band,
    box,
    cone,
    cylinder,
    rigid,
    rod,
    sphere,
    standing,
    steel_post,
)


@dataclass(frozen=True)
class Cone(ObjectType):
    """Traffic cone."""

    height: float = number(0.5, "m.", 0.1, 2.0)
    mass: float = kilograms(1.5)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        h = self.height
        edge, foot, radius = 0.6 * h, 0.05 * h, 0.24 * h
        rise = h - foot

        def width(share: float) -> float:
            return radius * (1.0 - 0.8 * share)

        solids = [box((edge, edge, foot), (0.0, 0.0, 0.5 * foot), look.BLACK)]
        for low, high in ((0.0, 0.33), (0.33, 0.66), (0.66, 1.0)):
            # As wide as the cone in the middle of each third.
            solids.append(
                cylinder(
                    width(0.5 * (low + high)),
                    (high - low) * rise,
                    (0.0, 0.0, foot + 0.5 * (low + high) * rise),
                )
            )
        bands = []
        for low in (0.30, 0.62):
            # Up to where the cone is four fifths as wide as there.
            high = 0.25 + 0.8 * low
            at = (0.0, 0.0, foot + low * rise)
            bands.append(band(width(low) + 0.002, (high - low) * rise, at, look.WHITE))
        parts = (
            *solids,
            cone(radius, rise, (0.0, 0.0, foot), look.ORANGE),
            *bands,
        )
        return rigid("cone", self.mass, parts)


@dataclass(frozen=True)
class LampFixture(ObjectType):
    """Lamp to be seen, hanging below a ceiling; its light is one of the scene's lamps."""

    length: float = number(1.2, "Along x (m).", 0.1, 5.0)
    height: float = number(3.0, "Of its lower side over the floor (m).", 0.1, 20.0)
    lit: bool = parameter(True, "Whether its tubes glow.")
    drop: float = number(0.3, "How far above it its rods end (m); 0: none.", 0.0, 10.0)
    color: Vector3 = rgb((1.0, 0.97, 0.88), "Of the light: red, green, blue, 0 to 1.")

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        tubes = look.plain(*self.color, glow=1.0) if self.lit else look.plain(0.5, 0.5, 0.48)
        parts = [
            box((self.length, 0.14, 0.05), (0.0, 0.0, self.height + 0.045), look.LIGHT_PAINT),
            box((self.length - 0.06, 0.11, 0.03), (0.0, 0.0, self.height + 0.015), tubes),
        ]
        if self.drop > 0.0:
            for side in (-1.0, 1.0):
                at = side * 0.35 * self.length
                low, high = self.height + 0.07, self.height + 0.07 + self.drop
                parts.append(rod((at, 0.0, low), (at, 0.0, high), 0.006, look.STEEL))
        return standing("lamp", tuple(parts))


@dataclass(frozen=True)
class CableTray(ObjectType):
    """Ladder tray along x with cables in it."""

    length: float = number(3.0, "m.", 0.3, 50.0)
    width: float = number(0.3, "m.", 0.08, 2.0)
    height: float = number(2.1, "Of its lower side over the floor (m).", 0.05, 10.0)
    cables: int = number(5, "How many lie in it.", 0, 30)
    carried: str = choice(
        "brackets",
        ("legs", "brackets", "rods"),
        "How: legs (on the floor), brackets (to a wall at y > 0) or rods (from a ceiling).",
    )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z = self.length, self.width, self.height
        parts = [
            box((x, 0.006, 0.06), (0.0, side * 0.5 * y, z + 0.03), look.STAINLESS)
            for side in (-1.0, 1.0)
        ]
        rungs = max(2, round(x / 0.3))
        for index in range(rungs):
            at = (index + 0.5) * x / rungs - 0.5 * x
            parts.append(box((0.03, y, 0.012), (at, 0.0, z + 0.006), look.STAINLESS))
        for index in range(self.cables):
            radius = (0.014, 0.009, 0.018, 0.011)[index % 4]
            color = (look.BLACK, look.ORANGE, look.DARK_STEEL, look.BLUE_PAINT)[index % 4]
            across = ((index + 0.5) / self.cables - 0.5) * (y - 0.05)
            middle = (0.0, across, z + 0.012 + radius)
            parts.append(cylinder(radius, x, middle, color, LYING_X, solid=False))
        holders = max(2, round(x / 1.5))
        for index in range(holders):
            at = (index + 0.5) * x / holders - 0.5 * x
            parts.extend(self._holder(at))
        return standing("tray", tuple(parts))

    def _holder(self, at: float) -> Parts:
        y, z = self.width, self.height
        if self.carried == "brackets":
            reach = 0.5 * y + 0.05
            return (
                box((0.04, y + 0.05, 0.03), (at, 0.025, z - 0.015), look.STEEL),
                box((0.04, 0.02, 0.2), (at, reach - 0.01, z - 0.07), look.STEEL),
            )
        if self.carried == "rods":
            return tuple(
                rod((at, side * 0.45 * y, z), (at, side * 0.45 * y, z + 0.6), 0.006, look.STEEL)
                for side in (-1.0, 1.0)
            )
        return tuple(
            steel_post(z, 0.04, (at, side * (0.5 * y - 0.02), 0.0), look.STEEL)
            for side in (-1.0, 1.0)
        )


@dataclass(frozen=True)
class Hose(ObjectType):
    """Cable or hose that lies on the floor along x, in waves."""

    length: float = number(2.0, "m.", 0.2, 20.0)
    radius: float = number(0.02, "m.", 0.003, 0.1)
    amplitude: float = number(0.1, "Of its waves (m).", 0.0, 2.0)
    waves: float = number(1.5, "How many.", 0.0, 20.0)
    color: Vector3 = rgb((0.12, 0.12, 0.13))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = look.plain(*self.color)
        count = max(4, math.ceil(12 * self.waves))
        points = []
        for index in range(count + 1):
            share = index / count
            sway = self.amplitude * math.sin(2.0 * math.pi * self.waves * share)
            points.append(((share - 0.5) * self.length, sway, self.radius))
        pieces = [rod(a, b, self.radius, surface) for a, b in zip(points, points[1:])]
        joints = [sphere(self.radius, point, surface, solid=False) for point in points]
        return standing("hose", (*pieces, *joints))


@dataclass(frozen=True)
class Rails(ObjectType):
    """Two parallel rails along x to drive on, one under each track."""

    gauge: float = number(
        0.345,
        "From the middle of one to that of the other (m); the robot's belts are 0.345 apart.",
        lambda own: own.width,
        3.0,
    )
    width: float = number(0.14, "Of a rail (m).", 0.03, 1.0)
    heights: Tuple[float, float] = numbers(
        (0.1, 0.1), "Of the left and of the right rail (m).", 0.02, 1.0
    )
    length: float = number(2.4, "m.", 0.3, 20.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        parts = []
        for side, height in zip((1.0, -1.0), self.heights):
            at = side * 0.5 * self.gauge
            size = (self.length, self.width, height)
            parts.append(box(size, (0.0, at, 0.5 * height), look.WOOD))
            for end in (-1.0, 1.0):
                # A painted end, so that it is seen from the robot's cameras.
                paint = (0.004, self.width + 0.002, height + 0.002)
                middle = (end * 0.5 * self.length, at, 0.5 * height)
                parts.append(box(paint, middle, look.YELLOW_PAINT, solid=False))
        return standing("rails", tuple(parts))


@dataclass(frozen=True)
class Rack(ObjectType):
    """Rack of electronics that looks towards -x, with lamps that show it is on."""

    width: float = number(0.6, "m; the width lies along y.", 0.2, 3.0)
    depth: float = number(0.7, "m; the width lies along y.", 0.2, 3.0)
    height: float = number(1.9, "m; the width lies along y.", 0.3, 3.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        x, y, z = self.depth, self.width, self.height
        parts = [
            box((x, y, z - 0.06), (0.0, 0.0, 0.5 * z + 0.03), look.GRAY_PAINT),
            box((x - 0.05, y - 0.05, 0.06), (0.0, 0.0, 0.03), look.BLACK),
        ]
        front = -0.5 * x
        tall = 0.11
        units = int((z - 0.3) / (tall + 0.02))
        for index in range(units):
            at = 0.2 + index * (tall + 0.02)
            shade = (0.16, 0.22, 0.30)[index % 3]
            unit = look.plain(shade, shade, shade + 0.02)
            parts.append(box((0.01, y - 0.06, tall), (front - 0.003, 0.0, at), unit, solid=False))
            for lamp in range(1 + index % 4):
                color = (0.2, 0.95, 0.3) if (index + lamp) % 3 else (0.98, 0.6, 0.1)
                spot = (front - 0.009, 0.5 * y - 0.08 - 0.03 * lamp, at + 0.03)
                parts.append(
                    box((0.004, 0.014, 0.014), spot, look.plain(*color, glow=0.9), solid=False)
                )
            parts.append(
                box(
                    (0.02, 0.012, 0.6 * tall),
                    (front - 0.014, -0.5 * y + 0.06, at),
                    look.ALUMINIUM,
                    solid=False,
                )
            )
        return standing("rack", tuple(parts))


TYPES = {
    "cone": Cone,
    "lamp_fixture": LampFixture,
    "cable_tray": CableTray,
    "hose": Hose,
    "rails": Rails,
    "rack": Rack,
}
