"""Gaps and hurdles, with the dimensions of ASTM E2801 and E2802."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.params import require

from ...model import Joint, Link, Motion, ObjectModel, SceneObject
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, number
from ..shapes import LYING_Y, Parts, box, cylinder, placed, standing, wedge
from .stairs import PLATFORMS, SIDES, platform


@dataclass(frozen=True)
class Gap(ObjectType):
    """Two platforms with a gap between them across x, and ramps up to both ends."""

    gap: float = number(0.3, "m; the test starts at 0.1 and adds 0.1.", 0.02, 3.0)
    width: float = number(1.2, "Of the lane (m): 2.4, 1.2 or 0.6.", 0.4, 10.0)
    platform: float = number(1.2, "Length of each platform (m).", 0.3, 10.0)
    height: float = number(0.2, "Of the platforms (m).", 0.05, 2.0)
    ramp: float = number(0.8, "Length of the ramps (m); 0: none.", 0.0, 10.0)
    finish: str = choice("wood", PLATFORMS)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.ramp == 0.0 or self.ramp >= 0.5 * self.height,
            f"ramp is {self.ramp}; a ramp to a height of {self.height} needs at least"
            f" {0.5 * self.height:g}, or 0 for none",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        surface = PLATFORMS[self.finish]
        away = 0.5 * (self.gap + self.platform)
        outside = 0.5 * self.gap + self.platform + 0.5 * self.ramp
        parts: List = []
        for side in (-1.0, 1.0):
            size = (self.platform, self.width, self.height)
            parts.extend(platform(size, side * away, surface))
            if self.ramp > 0.0:
                rising = wedge(self.ramp, self.width, self.height, surface, SIDES[self.finish])
                turn = (0.0, 0.0, 0.0, 1.0) if side < 0.0 else (0.0, 0.0, 1.0, 0.0)
                parts.extend(placed(rising, (side * outside, 0.0, 0.0), turn))
        return standing("gap", tuple(parts), self.friction)


@dataclass(frozen=True)
class Hurdle(ObjectType):
    """Barrier across x, with square edges, or with a pipe on each edge that rolls freely."""

    height: float = number(0.2, "m: 0.1, 0.2, 0.3, 0.4 or 0.5.", 0.05, 1.5)
    length: float = number(0.6, "Along x (m).", 0.2, 10.0)
    width: float = number(1.2, "Of the lane (m): 2.4, 1.2 or 0.6.", 0.2, 10.0)
    edge: str = choice("square", ("square", "pipe"))
    pipe_radius: float = number(0.035, "m.", 0.01, 0.1)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.edge == "square" or 2.0 * self.pipe_radius < min(self.height, 0.5 * self.length),
            f"pipe_radius is {self.pipe_radius}; a hurdle {self.height} high and {self.length} long"
            f" has no room for it",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        if self.edge == "square":
            return standing("hurdle", self._posts(self.length, self.height), self.friction)
        # Pipes take the place of the edges; what lies between and below carries.
        r = self.pipe_radius
        body = (
            *self._posts(self.length, self.height - 2.0 * r),
            box(
                (self.length - 4.0 * r, self.width, 2.0 * r),
                (0.0, 0.0, self.height - r),
                look.PLYWOOD,
            ),
        )
        links, joints = [Link("hurdle", 0.0, body, self.friction)], []
        for name, side in (("front", -1.0), ("rear", 1.0)):
            pipe = (
                cylinder(r, self.width, surface=look.YELLOW_PAINT),
                # A stripe along it shows that it turns.
                box((2.02 * r, 0.2 * r, self.width - 0.004), surface=look.BLACK, solid=False),
            )
            lying = placed(pipe, orientation=LYING_Y)
            links.append(Link(f"{name}_pipe", 6.0 * self.width, lying, self.friction))
            joints.append(
                Joint(
                    f"{name}_axle",
                    Motion.HINGE,
                    "hurdle",
                    f"{name}_pipe",
                    position=(side * (0.5 * self.length - r), 0.0, self.height - r),
                    axis=(0.0, 1.0, 0.0),
                    # More turns than anything drives it through.
                    lower=-5000.0,
                    upper=5000.0,
                    friction=0.02,
                )
            )
        return single(ObjectModel(tuple(links), tuple(joints), static=True))

    def _posts(self, length: float, height: float) -> Parts:
        """Barrier as one block, seen as posts of about 0.1 m on one another."""
        count = max(1, round(height / 0.1))
        tall = height / count
        parts: List = [box((length, self.width, height), (0.0, 0.0, 0.5 * height))]
        for index in range(count):
            surface = look.WOOD if index % 2 == 0 else look.PLYWOOD
            # A hair smaller in turn, so that the joints show.
            slim = 0.006 if index % 2 else 0.0
            size = (length - slim, self.width - slim, tall)
            parts.append(box(size, (0.0, 0.0, (index + 0.5) * tall), surface, solid=False))
        return tuple(parts)


TYPES = {"gap": Gap, "hurdle": Hurdle}
