"""Checks of parameters that several types of the library need."""

from __future__ import annotations

import math

from telex_control.common.params import require, require_range

from ..sealed import TOKEN


def require_each(
    config: object,
    names: str,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    *,
    above: float = -math.inf,
) -> None:
    """Call `require_range` for several fields, their names separated by blanks."""
    for name in names.split():
        require_range(config, name, minimum, maximum, above=above)


def require_elements(config: object, name: str, minimum: float, maximum: float) -> None:
    """Raise a `ConfigError` unless each number of a list is in range, bounds included."""
    for index, value in enumerate(getattr(config, name)):
        require(
            math.isfinite(value) and minimum <= value <= maximum,
            f"{name}[{index}] is {value!r}; it must be at least {minimum:g} and at most"
            f" {maximum:g}",
        )


def require_color(config: object, name: str) -> None:
    """Raise a `ConfigError` unless the field is a colour."""
    require_elements(config, name, 0.0, 1.0)


def require_sealed(token: str) -> None:
    """Raise a `ConfigError` unless a token in place of a seed is one, or empty."""
    require(
        not token or bool(TOKEN.fullmatch(token)),
        f"sealed is {token!r}; 8 to 64 hexadecimal digits, in lower case, are needed",
    )
