"""Dimensions that the parts of the hull are fitted to (m), in base_link: x forward, z up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

from ..figures import Figures
from ..link_model import LinkModel

Point = Tuple[float, float]


@dataclass(frozen=True)
class HullPlan:
    """The hull under construction, and where its outer faces lie."""

    figures: Figures
    link: LinkModel

    @property
    def nose(self) -> float:
        """Half the length."""
        return self.figures.hull["length"] / 2

    @property
    def side(self) -> float:
        """Half the width."""
        return self.figures.hull["width"] / 2

    @property
    def deck(self) -> float:
        """Height of the upper face."""
        return self.figures.hull["deck"]

    @property
    def belly(self) -> float:
        """Height of the lower face."""
        return self.figures.hull["belly"]

    def profile(self) -> List[Point]:
        """Return the side view: edges cut off, so that the belly slides over the edge of a step."""
        nose, deck, belly = self.nose, self.deck, self.belly
        half = [(nose - 0.040, belly), (nose, 0.0), (nose, deck - 0.055), (nose - 0.055, deck)]
        return [*half, *[(-x, z) for x, z in reversed(half)]]
