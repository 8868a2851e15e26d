"""Inclined planes and ramps, with the dimensions of ASTM E2803, E2826 and E2827."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.params import require

from ...model import UPRIGHT, SceneObject
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, number, parameter
from ..shapes import box, placed, standing, wedge, yawed
from .stairs import PLATFORMS, SIDES, platform

_TURNED = yawed(math.pi)


@dataclass(frozen=True)
class Ramp(ObjectType):
    """Wedge that rises along x."""

    length: float = number(1.2, "m.", 0.1, 20.0)
    width: float = number(1.2, "m.", 0.1, 20.0)
    height: float = number(0.3, "m.", 0.02, 5.0)
    finish: str = choice("wood", PLATFORMS)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = PLATFORMS[self.finish]
        sides = SIDES[self.finish]
        parts = wedge(self.length, self.width, self.height, surface, sides)
        return standing("ramp", parts, self.friction)


@dataclass(frozen=True)
class InclinedPlane(ObjectType):
    """Plane that rises along x to a platform."""

    angle: float = number(
        math.radians(15.0),
        "rad; the test starts at 15 degrees (0.262) and adds 5.",
        math.radians(2.0),
        math.radians(60.0),
    )
    length: float = number(2.4, "Along the slope (m).", 0.3, 20.0)
    width: float = number(2.4, "m.", 0.3, 20.0)
    platform: float = number(1.2, "Length of the platform on top (m); 0: none.", 0.0, 20.0)
    side_walls: bool = parameter(False, "Boards 0.15 m high along both edges.")
    finish: str = choice("wood", PLATFORMS)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    @property
    def run(self) -> float:
        """Of the slope along x (m)."""
        return self.length * math.cos(self.angle)

    @property
    def height(self) -> float:
        """Of the upper end (m)."""
        return self.length * math.sin(self.angle)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = PLATFORMS[self.finish]
        slope_at, top_at = -0.5 * self.platform, 0.5 * self.run
        slope = wedge(self.run, self.width, self.height, surface, SIDES[self.finish])
        parts: List = list(placed(slope, (slope_at, 0.0, 0.0)))
        if self.platform > 0.0:
            parts.extend(platform((self.platform, self.width, self.height), top_at, surface))
        if self.side_walls:
            board, high = 0.03, 0.15
            lean = (0.0, -math.sin(0.5 * self.angle), 0.0, math.cos(0.5 * self.angle))
            up = 0.5 * high / math.cos(self.angle)
            for side in (-1.0, 1.0):
                across = side * 0.5 * (self.width + board)
                middle = (slope_at, across, 0.5 * self.height + up)
                parts.append(box((self.length, board, high), middle, look.YELLOW_PAINT, lean))
        return standing("plane", tuple(parts), self.friction)


@dataclass(frozen=True)
class CrossingRamps(ObjectType):
    """Lane of ramps in two or more columns, up and down in turn.

    In the crossing pattern neighbouring columns rise where the others fall: the robot pitches and
    rolls. In the continuous one they rise together.
    """

    pattern: str = choice("crossing", ("crossing", "continuous"))
    rows: int = number(4, "Ramps along x in a column, an even number: as many up as down.", 2, 40)
    columns: int = number(2, "Side by side along y.", 1, 10)
    length: float = number(1.2, "Of a ramp (m).", 0.3, 3.0)
    width: float = number(0.6, "Of a ramp (m).", 0.3, 3.0)
    angle: float = number(math.radians(15.0), "rad.", math.radians(3.0), math.radians(35.0))
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(self.rows % 2 == 0, f"rows is {self.rows}; it must be even")

    @property
    def height(self) -> float:
        """Of a ridge (m)."""
        return self.length * math.tan(self.angle)

    def ramps(self) -> List[Tuple[float, float, bool]]:
        """Middle along x and y of every ramp, and whether it rises along x.

        In the crossing pattern every other column begins, and ends, one ramp later: so every
        column begins and ends on the floor.
        """
        crossing = self.pattern == "crossing"
        places = self.rows + 1 if crossing and self.columns > 1 else self.rows
        ramps = []
        for column in range(self.columns):
            shift = column % 2 if crossing else 0
            for row in range(self.rows):
                x = (row + shift - 0.5 * (places - 1)) * self.length
                y = (column - 0.5 * (self.columns - 1)) * self.width
                ramps.append((x, y, row % 2 == 0))
        return ramps

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        parts: List = []
        for index, (x, y, rising) in enumerate(self.ramps()):
            surface = look.PLYWOOD if index % 2 else look.WOOD
            ramp = wedge(self.length, self.width, self.height, surface, look.OLD_WOOD)
            parts.extend(placed(ramp, (x, y, 0.0), UPRIGHT if rising else _TURNED))
        return standing("ramps", tuple(parts), self.friction)


TYPES = {"ramp": Ramp, "inclined_plane": InclinedPlane, "crossing_ramps": CrossingRamps}
