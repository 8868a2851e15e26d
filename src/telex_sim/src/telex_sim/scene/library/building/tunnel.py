"""Tunnels, straight or curved, with niches."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.geometry.quaternions import product
from telex_control.common.params import require, required

from ...model import Part, SceneObject, Vector3
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import Declared, choice, number, parameter
from ..shapes import Parts, along_bend, box, placed, rolled, standing, yawed

_SHELL = 0.15
"""Thickness of the wall (m)."""
_VAULT_PANELS = 4
"""Flat panels from the spring of the vault to its crown."""
_SEAM = 0.02
"""How far panels reach past their neighbours, so that no light comes through (m)."""

_WALL_BETWEEN = 0.3
"""Between two niches (m)."""


@dataclass(frozen=True)
class Niche(Declared):
    """Recess in a tunnel's wall, from the floor."""

    at: float = number(
        required, "Its middle along the tunnel's centre line, from the tunnel's middle (m)."
    )
    side: str = choice("left", ("left", "right"), "left or right, seen along x.")
    width: float = number(1.2, "m.", 0.3, 10.0)
    height: float = number(2.1, "m.", 0.3, 10.0)
    depth: float = number(1.2, "m.", 0.3, 10.0)

    @property
    def sign(self) -> float:
        """1 on the left, -1 on the right."""
        return 1.0 if self.side == "left" else -1.0


@dataclass(frozen=True)
class Tunnel(ObjectType):
    """Tunnel with upright walls and a vault, along x in its middle."""

    length: float = number(20.0, "Along the centre line (m).", 1.0, 500.0)
    radius: float = number(
        0.0,
        "Of the bend (m): positive to the left, negative to the right, 0 for a straight tunnel.",
    )
    width: float = number(3.6, "Inside (m).", 1.0, 20.0)
    height: float = number(3.4, "Inside (m).", lambda own: own.wall_height + 0.1, 20.0)
    wall_height: float = number(2.2, "Of the upright walls, below the vault (m).", 0.5, 10.0)
    segment: float = number(2.0, "Largest length of a straight piece (m).", 0.5, 20.0)
    closed: str = choice(
        "none",
        ("none", "start", "end", "both"),
        "Which ends have a wall: none, start, end or both.",
    )
    niches: Tuple[Niche, ...] = parameter(
        (), "Recesses, each with at, side, width, height and depth."
    )

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.radius == 0.0 or abs(self.radius) >= max(self.width, self.length / math.pi),
            f"radius is {self.radius}; it must be 0, or at least"
            f" {max(self.width, self.length / math.pi):g} to either side",
        )
        for index, niche in enumerate(self.niches):
            require(
                abs(niche.at) + 0.5 * niche.width <= 0.5 * self.length
                and niche.height <= self.wall_height,
                f"niches[{index}] does not fit into the wall: at is {niche.at}, width"
                f" {niche.width}, height {niche.height}; the wall is {self.length:g} long and"
                f" {self.wall_height:g} high",
            )
        for (i, one), (j, other) in itertools.combinations(enumerate(self.niches), 2):
            room = 0.5 * (one.width + other.width) + _WALL_BETWEEN
            require(
                one.side != other.side or abs(one.at - other.at) >= room,
                f"niches[{i}] and niches[{j}] are {abs(one.at - other.at):g} apart; on one side of"
                f" the tunnel they need at least {room:g}",
            )

    def place(self, along: float, aside: float) -> Tuple[float, float, float]:
        """Find a place in the tunnel.

        Parameters
        ----------
        along : float
            Way along the centre line, from the tunnel's middle (m).
        aside : float
            To the left of the centre line (m).

        Returns
        -------
        tuple of 3 floats
            x, y (m) and the heading there (rad).
        """
        return along_bend(along, aside, self.radius)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        parts: List = []
        for side in (1.0, -1.0):
            niches = [niche for niche in self.niches if niche.sign == side]
            cuts = self._cuts(niches)
            for start, end in zip(cuts, cuts[1:]):
                middle = 0.5 * (start + end)
                open_height = max(
                    (n.height for n in niches if abs(middle - n.at) < 0.5 * n.width), default=0.0
                )
                parts.extend(self._panels(start, end, side, open_height))
            for niche in niches:
                parts.extend(self._niche(niche))
        for end, name in ((-1.0, "start"), (1.0, "end")):
            if self.closed in (name, "both"):
                x, y, heading = self.place(end * 0.5 * self.length, 0.0)
                size = (_SHELL, self.width + 2.0 * _SHELL, self.height + _SHELL)
                wall = box(size, (end * 0.5 * _SHELL, 0.0, 0.5 * size[2]), look.TUNNEL_WALL)
                parts.extend(placed((wall,), (x, y, 0.0), yawed(heading)))
        return standing("tunnel", tuple(parts))

    def _cuts(self, niches: List[Niche]) -> List[float]:
        """Ends of the straight pieces along the centre line (m)."""
        count = math.ceil(self.length / self.segment)
        cuts = [(index / count - 0.5) * self.length for index in range(count + 1)]
        for niche in niches:
            left, right = niche.at - 0.5 * niche.width, niche.at + 0.5 * niche.width
            # Ends inside the niche, or so near its edges that a sliver would remain, give way.
            keep = [c for c in cuts[1:-1] if c < left - 0.1 or c > right + 0.1]
            cuts = sorted({cuts[0], *keep, left, right, cuts[-1]})
        return cuts

    def _profile(self) -> List[Tuple[float, float]]:
        """Distance from the centre line and height of the panels' edges, from the floor up."""
        half, rise = 0.5 * self.width, self.height - self.wall_height
        points = [(half, 0.0), (half, self.wall_height)]
        for index in range(1, _VAULT_PANELS + 1):
            angle = 0.5 * math.pi * index / _VAULT_PANELS
            points.append((half * math.cos(angle), self.wall_height + rise * math.sin(angle)))
        return points

    def _panels(self, start: float, end: float, side: float, open_height: float) -> Parts:
        profile = self._profile()
        if open_height > 0.0:
            profile[0] = (profile[0][0], open_height)
        parts = []
        for (y0, z0), (y1, z1) in zip(profile, profile[1:]):
            if math.hypot(y1 - y0, z1 - z0) > 1e-6:
                parts.append(self._panel(start, end, (side * y0, z0), (side * y1, z1), side))
        if open_height == 0.0:
            # A painted line along the wall, by which the eye follows the bend.
            inside = side * (0.5 * self.width - 0.004)
            line = self._panel(start, end, (inside, 1.25), (inside, 1.37), side, painted=True)
            parts.append(line)
        return tuple(parts)

    def _panel(
        self,
        start: float,
        end: float,
        low: Tuple[float, float],
        high: Tuple[float, float],
        side: float,
        painted: bool = False,
    ) -> Part:
        """One flat panel: its inner face spans the profile from `low` to `high` (aside, height)."""
        aside, height = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])
        # Of both edges, the outer one is the longer.
        outer = max(low[0], high[0], key=lambda y: self._chord(start, end, y))
        x0, y0, _ = self.place(start, aside)
        x1, y1, _ = self.place(end, aside)
        heading = math.atan2(y1 - y0, x1 - x0)
        tilt = math.atan2(high[1] - low[1], high[0] - low[0])
        thickness = 0.004 if painted else _SHELL
        wide = math.hypot(high[0] - low[0], high[1] - low[1]) + (0.0 if painted else _SEAM)
        size = (self._chord(start, end, outer) + _SEAM, wide, thickness)
        turn = product(yawed(heading), rolled(tilt))
        # On the left the panel's z axis looks inwards, on the right outwards.
        shell = box(
            size,
            (0.0, 0.0, -side * 0.5 * thickness),
            look.GREEN_PAINT if painted else look.TUNNEL_WALL,
            solid=not painted,
        )
        middle: Vector3 = (0.5 * (x0 + x1), 0.5 * (y0 + y1), height)
        return placed((shell,), middle, turn)[0]

    def _chord(self, start: float, end: float, aside: float) -> float:
        x0, y0, _ = self.place(start, aside)
        x1, y1, _ = self.place(end, aside)
        return math.hypot(x1 - x0, y1 - y0)

    def _niche(self, niche: Niche) -> Parts:
        w, h, deep = niche.width, niche.height, niche.depth
        sheet = 0.1
        out = niche.sign
        surface = look.CONCRETE
        # Behind the inner face of the tunnel's wall, whose edges line the opening.
        front = 0.5 * _SHELL
        middle, long = out * 0.5 * (front + deep), deep - front
        inside = (
            box(
                (w + 2.0 * sheet, sheet, h + sheet),
                (0.0, out * (deep + 0.5 * sheet), 0.5 * (h + sheet)),
                surface,
            ),
            box((w + 2.0 * sheet, long, sheet), (0.0, middle, h + 0.5 * sheet), surface),
            *(
                box((sheet, long, h), (end * 0.5 * (w + sheet), middle, 0.5 * h), surface)
                for end in (-1.0, 1.0)
            ),
        )
        # The wall between two cuts is straight: the niche begins on its chord.
        x0, y0, _ = self.place(niche.at - 0.5 * w, out * 0.5 * self.width)
        x1, y1, _ = self.place(niche.at + 0.5 * w, out * 0.5 * self.width)
        heading = math.atan2(y1 - y0, x1 - x0)
        return placed(inside, (0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0), yawed(heading))


TYPES = {"tunnel": Tunnel}
