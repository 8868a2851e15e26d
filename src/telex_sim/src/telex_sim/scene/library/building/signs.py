"""Signs and charts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple
from urllib.parse import quote_plus

from telex_control.common.params import require

from ...model import SceneObject, Surface
from ...sealed import seed_of
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import choice, number, parameter, token
from ..shapes import Parts, box, cylinder, sheet, standing, steel_post

_SYMBOLS = ("usual", "none", "exclamation", "radiation", "voltage")


@dataclass(frozen=True)
class Sign(ObjectType):
    """Warning sign that looks towards -x."""

    text: str = parameter("", "Up to 40 characters, under the symbol.")
    shape: str = choice("triangle", ("triangle", "square", "circle"))
    symbol: str = choice(
        "usual", _SYMBOLS, "usual (that of the shape), none, exclamation, radiation or voltage."
    )
    size: float = number(0.4, "Edge of the board (m).", 0.05, 3.0)
    height: float = number(
        1.5, "Of the board's middle over the floor (m).", lambda own: 0.5 * own.size, 10.0
    )
    post: bool = parameter(
        True, "On a post of its own; else to be put against a wall, its back at x = 0."
    )

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            len(self.text) <= 40 and all(" " <= character <= "~" for character in self.text),
            f"text is {self.text!r}; at most 40 characters of ASCII are possible",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        query = f"text={quote_plus(self.text)}&shape={self.shape}&symbol={self.symbol}"
        surface = look.picture(f"sign?{query}")
        return standing("sign", _board(self.size, self.size, self.height, surface, self.post))


@dataclass(frozen=True)
class Chart(ObjectType):
    """Chart of optotypes to read, which looks towards -x."""

    kind: str = choice("E", ("E", "C"), "E (tumbling E) or C (Landolt ring).")
    seed: int = number(1, "Which way they point.", 0, 2**31 - 1)
    sealed: str = token(
        "A token in place of the seed, which tells nobody which way they point; see `scene.sealed`."
    )
    rows: int = number(6, "Each is smaller than that above.", 1, 12)
    size: float = number(0.5, "Edge of the board (m).", 0.05, 3.0)
    height: float = number(
        1.0, "Of the board's middle over the floor (m).", lambda own: 0.5 * own.size, 10.0
    )
    post: bool = parameter(
        True, "On a post of its own; else to be put against a wall, its back at x = 0."
    )

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
