"""Declares the parameters of the library's types, with what only they have.

What ``scene types`` prints of a parameter comes from its declaration as well.
"""

from __future__ import annotations

from typing import Any

from telex_control.common.params import (
    Declared,
    checked,
    choice,
    meaning,
    number,
    numbers,
    parameter,
    require,
)

from ..sealed import TOKEN

__all__ = [
    "Declared",
    "choice",
    "kilograms",
    "meaning",
    "number",
    "numbers",
    "parameter",
    "rgb",
    "token",
]


def kilograms(default: Any, text: str = "kg.") -> Any:
    """Declare a mass (kg), above 0."""
    return number(default, text, above=0.0)


def rgb(default: Any, text: str = "Red, green, blue, 0 to 1.") -> Any:
    """Declare a colour, as in sRGB; None passes."""
    return numbers(default, text, 0.0, 1.0)


def token(text: str) -> Any:
    """Declare a token in place of a seed (`telex_sim.scene.sealed`); by default there is none."""

    def check(config: Any, name: str) -> None:
        value = getattr(config, name)
        require(
            not value or bool(TOKEN.fullmatch(value)),
            f"{name} is {value!r}; 8 to 64 hexadecimal digits, in lower case, are needed",
        )

    return checked("", text, check)
