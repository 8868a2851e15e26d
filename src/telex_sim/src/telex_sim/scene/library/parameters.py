"""Declares the parameters of the library's types: default, meaning, and what is possible.

A field of a frozen dataclass is declared by one of the functions below::

    count: int = number(5, "Blocks side by side.", 1, 10)
    mounting: str = choice("stand", ("stand", "wall"))

Its checks, their messages and what ``scene types`` prints of it come from there. The functions
return what `dataclasses.field` does; they are declared as Any, so that they pass as the default of
a field of any type.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Callable, Iterable, Mapping, Union

from telex_control.common.params import require, require_choice, require_range, required

from ..sealed import TOKEN

Bound = Union[float, Callable[[Any], float]]
"""A number, or a function that computes it from the dataclass's other fields."""

_MEANING = "meaning"
_CHECK = "check"
_CHECK_WITH_OTHERS = "check with others"
_Check = Callable[[Any, str], None]


class Declared:
    """Base of dataclasses whose fields are declared by the functions of this module."""

    def __post_init__(self) -> None:
        """Check every field alone, then those with limits by other fields, then `check`."""
        for stage in (_CHECK, _CHECK_WITH_OTHERS):
            for field in dataclasses.fields(self):  # type: ignore[arg-type]
                if stage in field.metadata:
                    field.metadata[stage](self, field.name)
        self.check()

    def check(self) -> None:
        """Check what concerns several fields, or one in a way of its own.

        Raises
        ------
        ConfigError
            The message names the field, its value and what would be right.
        """


def meaning(field: Any) -> str:
    """Meaning of a field that was declared here, with its unit; of any other, an empty string."""
    text: str = field.metadata.get(_MEANING, "")
    return text


def parameter(default: Any, text: str) -> Any:
    """Declare a field that needs no check beyond its type.

    Parameters
    ----------
    default
        `telex_control.common.params.required`: the field must be given.
    text : str
        What it means, with its unit.
    """
    return _declared(default, text, {})


def number(
    default: Any,
    text: str,
    minimum: Bound = -math.inf,
    maximum: Bound = math.inf,
    *,
    above: float = -math.inf,
) -> Any:
    """Declare a number within limits; None passes, where the field's type is Optional.

    Parameters
    ----------
    default, text
        As for `parameter`.
    minimum, maximum : float or callable
        Inclusive.
    above : float
        Exclusive.

    Notes
    -----
    Limits that depend on other fields are checked after those that do not, and may rely on them.
    """

    def check(config: Any, name: str) -> None:
        require_range(config, name, _bound(minimum, config), _bound(maximum, config), above=above)

    with_others = callable(minimum) or callable(maximum)
    return _declared(default, text, {_CHECK_WITH_OTHERS if with_others else _CHECK: check})


def kilograms(default: Any, text: str = "kg.") -> Any:
    """Declare a mass (kg), above 0."""
    return number(default, text, above=0.0)


def numbers(default: Any, text: str, minimum: float, maximum: float) -> Any:
    """Declare a list of numbers, each within limits, bounds included; None passes.

    Parameters
    ----------
    default, text
        As for `parameter`.
    minimum, maximum : float
    """

    def check(config: Any, name: str) -> None:
        for index, value in enumerate(getattr(config, name) or ()):
            require(
                math.isfinite(value) and minimum <= value <= maximum,
                f"{name}[{index}] is {value!r}; it must be at least {minimum:g} and at most"
                f" {maximum:g}",
            )

    return _declared(default, text, {_CHECK: check})


def rgb(default: Any, text: str = "Red, green, blue, 0 to 1.") -> Any:
    """Declare a colour, as in sRGB; None passes."""
    return numbers(default, text, 0.0, 1.0)


def choice(default: str, choices: Iterable[str], text: str = "") -> Any:
    """Declare a string that is one of several.

    Parameters
    ----------
    default, text
        As for `parameter`; without a text, the choices are its meaning.
    choices : iterable of str
    """
    known = tuple(choices)

    def check(config: Any, name: str) -> None:
        require_choice(config, name, known)

    return _declared(default, text or f"{', '.join(known[:-1])} or {known[-1]}.", {_CHECK: check})


def token(text: str) -> Any:
    """Declare a token in place of a seed (`telex_sim.scene.sealed`); by default there is none."""

    def check(config: Any, name: str) -> None:
        value = getattr(config, name)
        require(
            not value or bool(TOKEN.fullmatch(value)),
            f"{name} is {value!r}; 8 to 64 hexadecimal digits, in lower case, are needed",
        )

    return _declared("", text, {_CHECK: check})


def _declared(default: Any, text: str, checks: Mapping[str, _Check]) -> Any:
    metadata = {_MEANING: text, **checks}
    if default is required:
        return dataclasses.field(default_factory=required, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def _bound(bound: Bound, config: Any) -> float:
    return bound(config) if callable(bound) else bound
