"""Fields of posts, after ASTM E2828."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from ...model import SceneObject
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, number
from ..shapes import Parts, box, recolored, standing

_SIDE = 10
"""Posts along each side of a pallet."""


@dataclass(frozen=True)
class Stepfield(ObjectType):
    """Pallets of ten by ten square posts of different heights, in a row along x."""

    pattern: str = choice(
        "hill",
        ("flat", "hill", "diagonal"),
        "flat, hill (a ridge across x) or diagonal (a ridge from corner to corner).",
    )
    pallets: int = number(1, "How many.", 1, 10)
    post: float = number(0.1, "Edge of a post, and the step between heights (m).", 0.02, 0.3)
    levels: int = number(4, "The highest post is this many steps high.", 1, 8)
    border: float = number(0.1, "Width of the frame round each pallet (m).", 0.0, 0.5)
    seed: int = number(1, "The same seed gives the same field.", 0, 2**31 - 1)
    friction: float = number(1.0, "Of its surface.", 0.0, 10.0)

    @property
    def pitch(self) -> float:
        """From one pallet to the next (m)."""
        return _SIDE * self.post + 2.0 * self.border

    def heights(self) -> List[List[List[int]]]:
        """Heights of all posts in steps: for each pallet its rows along x, each along y."""
        numbers = random.Random(self.seed)
        fields = []
        for _ in range(self.pallets):
            rows = []
            for row in range(_SIDE):
                rows.append([self._level(row, column, numbers) for column in range(_SIDE)])
            fields.append(rows)
        return fields

    def _level(self, row: int, column: int, numbers: random.Random) -> int:
        half = 0.5 * (_SIDE - 1)
        if self.pattern == "flat":
            mean = 1.5
        elif self.pattern == "hill":
            mean = self.levels - (self.levels - 1) * abs(row - half) / half
        else:
            mean = self.levels - (self.levels - 1) * abs(row - column) / (_SIDE - 1)
        # random() alone is promised to stay the same from one Python to the next.
        level = round(mean + 1.6 * (numbers.random() - 0.5))
        return min(self.levels, max(1, level))

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        parts: List = []
        for index, rows in enumerate(self.heights()):
            middle = (index - 0.5 * (self.pallets - 1)) * self.pitch
            parts.extend(self._pallet(middle, rows))
        return standing("stepfield", tuple(parts), self.friction)

    def _pallet(self, middle: float, rows: List[List[int]]) -> Parts:
        parts = []
        edge = self.post - 0.002
        for row, levels in enumerate(rows):
            for column, level in enumerate(levels):
                x = middle + (row - 0.5 * (_SIDE - 1)) * self.post
                y = (column - 0.5 * (_SIDE - 1)) * self.post
                height = level * self.post
                # The tone follows the height, so that it is seen from above.
                surface = _TONES[(level - 1) % len(_TONES)]
                parts.append(box((edge, edge, height), (x, y, 0.5 * height), surface))
        if self.border > 0.0:
            inside, b, high = _SIDE * self.post, self.border, self.post
            for side in (-1.0, 1.0):
                at = side * 0.5 * (inside + b)
                size = (inside + 2.0 * b, b, high)
                parts.append(box(size, (middle, at, 0.5 * high), look.OLD_WOOD))
                parts.append(box((b, inside, high), (middle + at, 0.0, 0.5 * high), look.OLD_WOOD))
        return tuple(parts)


_TONES = (
    look.OLD_WOOD,
    look.WOOD,
    look.PLYWOOD,
    recolored(look.WOOD, (0.86, 0.52, 0.30)),
)

TYPES = {"stepfield": Stepfield}
