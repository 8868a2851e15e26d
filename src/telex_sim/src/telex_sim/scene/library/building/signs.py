"""Signs and charts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple
from urllib.parse import quote_plus

from telex_control.common.params import require, require_choice, require_range

from ...model import SceneObject, Surface
from ...sealed import seed_of
from .. import materials as look
from ..checks import require_sealed
from ..object_type import ObjectType
from ..shapes import Parts, box, cylinder, sheet, standing, steel_post


@dataclass(frozen=True)
class Sign(ObjectType):
    """Warning sign that looks towards -x.

    Attributes
    ----------
    text : str
        Up to 40 characters, under the symbol.
    shape : str
        triangle, square or circle.
    symbol : str
        usual (that of the shape), none, exclamation, radiation or voltage.
    size : float
        Edge of the board (m).
    height : float
        Of the board's middle over the floor (m).
    post : bool
        On a post of its own; else to be put against a wall, its back at x = 0.
    """

    text: str = ""
    shape: str = "triangle"
    symbol: str = "usual"
    size: float = 0.4
    height: float = 1.5
    post: bool = True

    def __post_init__(self) -> None:
        require(
            len(self.text) <= 40 and all(" " <= character <= "~" for character in self.text),
            f"text is {self.text!r}; at most 40 characters of ASCII are possible",
        )
        symbols = ("usual", "none", "exclamation", "radiation", "voltage")
        require_choice(self, "symbol", symbols)
        require_choice(self, "shape", ("triangle", "square", "circle"))
        require_range(self, "size", 0.05, 3.0)
        require_range(self, "height", 0.5 * self.size, 10.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        query = f"text={quote_plus(self.text)}&shape={self.shape}&symbol={self.symbol}"
        surface = look.picture(f"sign?{query}")
        return standing("sign", _board(self.size, self.size, self.height, surface, self.post))


@dataclass(frozen=True)
class Chart(ObjectType):
    """Chart of optotypes to read, which looks towards -x.

    Attributes
    ----------
    kind : str
        E (tumbling E) or C (Landolt ring).
    seed : int
        Which way they point.
    sealed : str
        A token in place of the seed, which tells nobody which way they point; see `scene.sealed`.
    rows : int
        Each is smaller than that above.
    size : float
        Edge of the board (m).
    height : float
        Of the board's middle over the floor (m).
    post : bool
        On a post of its own; else to be put against a wall, its back at x = 0.
    """

    kind: str = "E"
    seed: int = 1
    sealed: str = ""
    rows: int = 6
    size: float = 0.5
    height: float = 1.0
    post: bool = True

    def __post_init__(self) -> None:
        require_choice(self, "kind", ("E", "C"))
        require_range(self, "seed", 0, 2**31 - 1)
        require_sealed(self.sealed)
        require_range(self, "rows", 1, 12)
        require_range(self, "size", 0.05, 3.0)
        require_range(self, "height", 0.5 * self.size, 10.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        drawn = f"sealed={self.sealed}" if self.sealed else f"seed={self.seed}"
        surface = look.picture(f"chart?kind={self.kind}&{drawn}&rows={self.rows}")
        return standing("chart", _board(self.size, self.size, self.height, surface, self.post))

    def drawn_from(self) -> int:
        """Seed of what is to be read."""
        return seed_of(self.sealed) if self.sealed else self.seed


def _board(width: float, tall: float, height: float, surface: Surface, post: bool) -> Parts:
    """Board with a picture on the side towards -x."""
    thick = 0.012
    parts = [
        box((thick, width + 0.02, tall + 0.02), (-0.5 * thick, 0.0, height), look.ALUMINIUM),
        sheet(width, tall, (-thick, 0.0, height), surface),
    ]
    if post:
        top = height + 0.4 * tall
        parts.append(steel_post(top, 0.04, (0.02, 0.0, 0.0), look.GRAY_PAINT))
        parts.append(cylinder(0.16, 0.03, (0.02, 0.0, 0.015), look.DARK_STEEL))
    return tuple(parts)


TYPES = {
    "sign": Sign,
    "chart": Chart,
}
