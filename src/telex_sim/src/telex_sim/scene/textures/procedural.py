"""Pictures that the renderer draws itself, by name: ``generated:NAME?key=value&key=value``.

The same address gives the same picture everywhere, so that a renderer on another machine needs no
files. Nothing here needs OpenGL: whoever validates a scene may ask `check_texture`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Tuple, Union
from urllib.parse import unquote_plus

import numpy as np

from ..sealed import TOKEN
from . import floors, optotypes
from . import labels as texture_pictures
from . import surfaces as texture_materials
from .optotypes import ChartRow

PREFIX = "generated:"


class TextureNameError(ValueError):
    """An address names no texture; the message says what would."""


@dataclass(frozen=True)
class _Whole:
    default: int
    minimum: int
    maximum: int

    def read(self, text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            raise ValueError("a whole number is needed") from None
        if not self.minimum <= value <= self.maximum:
            raise ValueError(f"{self.minimum} to {self.maximum} is possible")
        return value


@dataclass(frozen=True)
class _Even(_Whole):
    def read(self, text: str) -> int:
        value = super().read(text)
        if value % 2:
            raise ValueError("an even number is needed")
        return value


@dataclass(frozen=True)
class _Number:
    default: float
    minimum: float
    maximum: float

    def read(self, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise ValueError("a number is needed") from None
        # Also refuses NaN, which compares with nothing.
        if not self.minimum <= value <= self.maximum:
            raise ValueError(f"{self.minimum:g} to {self.maximum:g} is possible")
        return value


@dataclass(frozen=True)
class _Choice:
    default: str
    options: Tuple[str, ...]

    def read(self, text: str) -> str:
        if text not in self.options:
            raise ValueError(f"there are {', '.join(self.options)}")
        return text


@dataclass(frozen=True)
class _Text:
    default: str
    longest: int

    def read(self, text: str) -> str:
        if len(text) > self.longest:
            raise ValueError(f"at most {self.longest} characters are possible")
        if not all(" " <= character <= "~" for character in text):
            raise ValueError("only the printable characters of ASCII are possible")
        return text


@dataclass(frozen=True)
class _Token:
    default: str = ""

    def read(self, text: str) -> str:
        if not TOKEN.fullmatch(text):
            raise ValueError("8 to 64 hexadecimal digits, in lower case, are needed")
        return text


_Parameter = Union[_Whole, _Number, _Choice, _Text, _Token]


@dataclass(frozen=True)
class _Texture:
    make: Callable[..., np.ndarray]
    parameters: Mapping[str, _Parameter]


def _seed(default: int) -> _Whole:
    return _Whole(default, 0, 2**31 - 1)


def _material(make: Callable[..., np.ndarray], seed: int, **parameters: _Parameter) -> _Texture:
    return _Texture(make, {"seed": _seed(seed), **parameters})


_KIND = _Choice("E", tuple(optotypes.DIRECTIONS))
_CHART: Dict[str, _Parameter] = {
    "kind": _KIND,
    "seed": _seed(0),
    "rows": _Whole(8, 1, 12),
    "sealed": _Token(),
}
_OPTOTYPE: Dict[str, _Parameter] = {
    "kind": _KIND,
    "angle": _Whole(0, 0, 359),
    "sealed": _Token(),
    "of": _Whole(0, 0, 99),
}

_TEXTURES: Dict[str, _Texture] = {
    "concrete": _material(floors.concrete, 1, slabs=_Whole(2, 0, 16), worn=_Whole(0, 0, 1)),
    "asphalt": _material(texture_materials.asphalt, 2),
    "gravel": _material(texture_materials.gravel, 3),
    "brick": _material(texture_materials.brick, 4, rows=_Even(12, 2, 64), columns=_Whole(4, 1, 32)),
    "plaster": _material(texture_materials.plaster, 5),
    "wood": _material(texture_materials.wood, 6),
    "planks": _material(texture_materials.planks, 7, count=_Whole(6, 1, 32)),
    "crate": _material(texture_materials.crate, 8),
    "cardboard": _material(texture_materials.cardboard, 9),
    "tread_plate": _material(texture_materials.tread_plate, 10, bars=_Even(8, 2, 32)),
    "brushed_metal": _material(texture_materials.brushed_metal, 11),
    "painted_metal": _material(texture_materials.painted_metal, 12),
    "rubber": _material(texture_materials.rubber, 13),
    "tiles": _material(texture_materials.tiles, 14, count=_Whole(5, 1, 32)),
    "tunnel_wall": _material(texture_materials.tunnel_wall, 15),
    "checker": _material(texture_materials.checker, 16),
    "hazard_stripes": _material(texture_materials.hazard_stripes, 17),
    "sign": _Texture(
        texture_pictures.sign,
        {
            "text": _Text("", 40),
            "shape": _Choice("triangle", ("triangle", "square", "circle")),
            "symbol": _Choice(
                texture_pictures.USUAL, (texture_pictures.USUAL, *texture_pictures.SYMBOLS)
            ),
        },
    ),
    "label": _Texture(
        texture_pictures.label,
        {
            "text": _Text("", 80),
            "aspect": _Number(2.0, 0.1, 10.0),
            "color": _Choice("white", tuple(texture_pictures.LABEL_COLORS)),
        },
    ),
    "chart": _Texture(optotypes.chart, _CHART),
    "optotype": _Texture(optotypes.optotype, _OPTOTYPE),
}


def texture_names() -> List[str]:
    """Names that may follow the prefix, in alphabetical order."""
    return sorted(_TEXTURES)


def is_generated(address: str) -> bool:
    """Whether an address is of this kind, rightly made or not."""
    return address.startswith(PREFIX)


def check_texture(address: str) -> None:
    """Find out whether `generate_texture` would make a picture, without making it.

    Raises
    ------
    TextureNameError
        When the name or a key is unknown, or a value is not possible.
    """
    _parsed(address)


def generate_texture(address: str) -> np.ndarray:
    """Draw the picture that an address names.

    Parameters
    ----------
    address
        ``generated:NAME`` or ``generated:NAME?key=value&key=value``; in a value, + is a blank and
        %26 a &, as in web addresses.

    Returns
    -------
    numpy.ndarray
        RGB, shape (height, width, 3), uint8, rows from above.

    Raises
    ------
    TextureNameError
        As `check_texture`.
    """
    texture, values = _parsed(address)
    return texture.make(**values)


def chart_answers(address: str) -> List[ChartRow]:
    """Rows of a chart, from above: how large its characters are, and where they open.

    Raises
    ------
    TextureNameError
        As `check_texture`, or when the address is no chart's.
    """
    texture, values = _parsed(address)
    if texture.make is not optotypes.chart:
        raise TextureNameError(f"'{address}' is no chart; {PREFIX}chart is needed")
    if values["sealed"]:
        raise TextureNameError(f"'{address}' is sealed; it tells nobody its answers")
    return optotypes.chart_rows(values["kind"], values["seed"], values["rows"])


def _parsed(address: str) -> Tuple[_Texture, Dict[str, Any]]:
    if not is_generated(address):
        raise TextureNameError(f"'{address}': an address of this kind begins with {PREFIX}")
    name, _, query = address[len(PREFIX) :].partition("?")
    if name not in _TEXTURES:
        known = ", ".join(texture_names())
        raise TextureNameError(f"'{address}': texture '{name}' is unknown; there are {known}")
    texture = _TEXTURES[name]
    values: Dict[str, Any] = {key: item.default for key, item in texture.parameters.items()}
    given = set()
    for pair in query.split("&") if query else []:
        key, equals, text = pair.partition("=")
        if key not in texture.parameters:
            known = ", ".join(texture.parameters)
            raise TextureNameError(f"'{address}': {name} has no '{key}'; it has {known}")
        if key in given:
            raise TextureNameError(f"'{address}': '{key}' is given twice")
        if not equals:
            raise TextureNameError(f"'{address}': '{key}' has no value; {key}=… is needed")
        given.add(key)
        try:
            values[key] = texture.parameters[key].read(unquote_plus(text))
        except ValueError as error:
            raise TextureNameError(f"'{address}': {key} is '{text}'; {error}") from None
    return texture, values
