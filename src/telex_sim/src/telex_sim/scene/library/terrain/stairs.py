"""Stairs and landings, generated from rise and run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from ...model import Part, SceneObject, Surface
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, number
from ..shapes import Parts, box, rod, standing

_NOSING = 0.035
"""Width of the stripe along the edge of a tread (m)."""
_PROUD = 0.0015
"""How far the stripe, which is only seen, stands out of tread and riser (m)."""
_RAIL_HEIGHT = 0.95
_FINISHES = {"concrete": look.CONCRETE, "steel": look.TREAD_PLATE}
PLATFORMS = {"wood": look.PLYWOOD, "concrete": look.CONCRETE, "steel": look.TREAD_PLATE}
"""Looks of platforms."""


@dataclass(frozen=True)
class Stairs(ObjectType):
    """Straight stairs that rise along x, of boxes from the floor up, and the landing on top."""

    rise: float = number(
        0.17,
        "Of a step (m): 0.17 and 0.28 are comfortable, 0.20 and 0.20 are 45 degrees.",
        0.02,
        0.5,
    )
    run: float = number(
        0.28,
        "Of a step (m): 0.17 and 0.28 are comfortable, 0.20 and 0.20 are 45 degrees.",
        0.05,
        3.0,
    )
    steps: int = number(8, "In a flight.", 1, 60)
    flights: int = number(1, "Between two, and on top, there is a landing.", 1, 10)
    width: float = number(1.2, "m.", 0.4, 20.0)
    landing: float = number(1.2, "Length of each landing (m).", 0.1, 20.0)
    form: str = choice(
        "up",
        ("up", "up_and_down"),
        "up: they end at the last landing; up_and_down: they go down again behind it.",
    )
    railings: str = choice(
        "both", ("none", "left", "right", "both"), "none, left, right or both; left is y > 0."
    )
    finish: str = choice("concrete", _FINISHES)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    @property
    def height(self) -> float:
        """Of the last landing over the floor (m)."""
        return self.rise * self.steps * self.flights

    def treads(self) -> List[Tuple[float, float, float]]:
        """Start and end along x from the middle of the footprint, and height of every tread (m).

        The last of a flight is the landing.
        """
        treads: List[Tuple[float, float, float]] = []
        at = 0.0
        for step in range(1, self.steps * self.flights + 1):
            length = self.run if step % self.steps else self.landing
            treads.append((at, at + length, step * self.rise))
            at += length
        if self.form == "up_and_down":
            for step in range(self.steps * self.flights - 1, 0, -1):
                length = self.run if step % self.steps else self.landing
                treads.append((at, at + length, step * self.rise))
                at += length
        return [(start - 0.5 * at, end - 0.5 * at, top) for start, end, top in treads]

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = _FINISHES[self.finish]
        treads = self.treads()
        parts: List = []
        low = 0.0
        for index, (start, end, top) in enumerate(treads):
            middle, length = 0.5 * (start + end), end - start
            parts.append(box((length, self.width, top), (middle, 0.0, 0.5 * top), surface))
            following = treads[index + 1][2] if index + 1 < len(treads) else 0.0
            if top > low:
                parts.append(self._nosing(start + 0.5 * _NOSING - _PROUD, top))
            if following < top and self.form == "up_and_down":
                parts.append(self._nosing(end - 0.5 * _NOSING + _PROUD, top))
            low = top
        for side, name in ((1.0, "left"), (-1.0, "right")):
            if self.railings in (name, "both"):
                parts.extend(self._railing(side * (0.5 * self.width - 0.03)))
        return standing("stairs", tuple(parts), self.friction)

    def _nosing(self, at: float, top: float) -> Part:
        """Yellow stripe along an edge."""
        size = (_NOSING, self.width - 0.004, 0.02)
        return box(size, (at, 0.0, top - 0.01 + _PROUD), look.YELLOW_PAINT, solid=False)

    def _railing(self, side: float) -> Parts:
        """Posts, a handrail and a bar at half the height, which follow the steps."""
        treads = self.treads()
        height = min(_RAIL_HEIGHT, 0.35 * self.width + 0.6)
        feet = []
        for start, end, top in treads:
            if end - start > 1.5 * self.run or len(treads) == 1:
                feet += [(start + 0.04, top), (end - 0.04, top)]
            else:
                feet.append((0.5 * (start + end), top))
        spacing = max(1, math.ceil(0.8 / self.run))
        kept = [
            foot
            for index, foot in enumerate(feet)
            if index in (0, len(feet) - 1) or index % spacing == 0 or self._is_corner(feet, index)
        ]
        posts = [
            rod((x, side, top), (x, side, top + height), 0.018, look.STAINLESS) for x, top in kept
        ]
        rails = []
        for share, radius in ((1.0, 0.021), (0.5, 0.012)):
            for (x0, z0), (x1, z1) in zip(kept, kept[1:]):
                low = (x0, side, z0 + share * height)
                high = (x1, side, z1 + share * height)
                rails.append(rod(low, high, radius, look.STAINLESS))
        return (*posts, *rails)

    @staticmethod
    def _is_corner(feet: List[Tuple[float, float]], index: int) -> bool:
        (x0, z0), (x1, z1), (x2, z2) = feet[index - 1 : index + 2]
        return abs((z1 - z0) * (x2 - x1) - (z2 - z1) * (x1 - x0)) > 1e-6


@dataclass(frozen=True)
class Platform(ObjectType):
    """Block to climb: a single step, or a stage; its edges are marked."""

    length: float = number(1.5, "m.", 0.1, 50.0)
    width: float = number(1.5, "m.", 0.1, 50.0)
    height: float = number(0.5, "m.", 0.01, 5.0)
    finish: str = choice("wood", PLATFORMS)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        size = (self.length, self.width, self.height)
        parts = platform(size, 0.0, PLATFORMS[self.finish])
        return standing("platform", parts, self.friction)


SIDES = {
    "wood": look.OLD_WOOD,
    "concrete": look.plain(0.60, 0.60, 0.58),
    "steel": look.plain(0.45, 0.47, 0.50),
}
"""Looks of the sides of ramps, which can have no texture."""


def platform(size: Tuple[float, float, float], at: float, surface: Surface) -> Parts:
    """Block with its middle at `at` along x, hazard stripes on both edges across x."""
    length, width, height = size
    stripe = min(0.06, 0.2 * length)
    return (
        box(size, (at, 0.0, 0.5 * height), surface),
        *(
            box(
                (stripe, width - 0.004, 0.004),
                (at + side * 0.5 * (length - stripe - 0.004), 0.0, height - 0.001),
                look.HAZARD,
                solid=False,
            )
            for side in (-1.0, 1.0)
        ),
    )


TYPES = {"stairs": Stairs, "platform": Platform}
