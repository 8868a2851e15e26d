"""Validated reading of nested parameters into frozen dataclasses.

A dataclass field is a number, a string, a bool, a list, a dict, another such dataclass, or Optional
of one of these; what the parameters leave out keeps the field's default, and a key that is no field
is an error. What a type cannot say, a dataclass checks in its `__post_init__`, with `require` and
its relatives; they name a parameter within its struct, `read_config` adds the struct's own name.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Iterable, Mapping, Type, TypeVar, Union, get_type_hints

Config = TypeVar("Config")

_WANTED = {
    int: "an integer",
    str: "a string",
    bool: "true or false",
    dict: "a struct",
    list: "a list",
}


class ConfigError(ValueError):
    """A parameter is wrong; the message names it, its value and what would be right."""


def read_config(kind: Type[Config], params: Any, name: str) -> Config:
    """Make a `kind` of nested parameters.

    Parameters
    ----------
    name : str
        Full name of the parameter that holds them, for messages.

    Raises
    ------
    ConfigError
    """
    try:
        return read_struct(kind, params, name)
    except ConfigError as error:
        raise ConfigError(f"parameter {error}") from None


def read_struct(kind: Type[Config], params: Any, name: str = "") -> Config:
    """Make a `kind` of nested values that are no ROS parameters, as those of a file.

    Parameters
    ----------
    name : str
        Of the struct, for messages; without one they begin with the name of the value.

    Raises
    ------
    ConfigError
    """
    if not isinstance(params, Mapping):
        raise ConfigError(f"{name or 'it'} is {_shown(params)}; a struct is needed")
    inside = f"{name}/" if name else ""
    hints = get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for key in params:
        if key not in fields:
            raise ConfigError(f"{inside}{key} is unknown; known are {', '.join(sorted(fields))}")
    values = {}
    for key, field in fields.items():
        if key in params:
            values[key] = read_value(hints[key], params[key], f"{inside}{key}")
        elif _is_required(field):
            raise ConfigError(f"{inside}{key} is missing")
    try:
        return kind(**values)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}" if name else str(error)) from None


def required() -> Any:
    """Stand in as the default_factory of a field that has none but follows fields with a default.

    A derived dataclass needs it; Python 3.8 does not have what the standard library offers for it,
    `kw_only`.

    Raises
    ------
    ConfigError
        Always.
    """
    raise ConfigError("a required parameter is missing")


def _is_required(field: Any) -> bool:
    no_default = field.default is dataclasses.MISSING
    return no_default and field.default_factory in (dataclasses.MISSING, required)


def _shown(value: Any) -> str:
    """Show a value in a message, shortened where somebody gave a whole file of it."""
    try:
        text = repr(value)
    except ValueError:
        # Python does not write integers of thousands of digits.
        text = f"a {type(value).__name__} too long to show"
    return text if len(text) <= 80 else text[:77] + "..."


def read_value(kind: Any, value: Any, name: str) -> Any:
    """Return one value, checked as a field of the type `kind` would be.

    Parameters
    ----------
    kind : type
        For ``float``, integers are taken too, and the value must be finite.
    name : str
        For messages.

    Raises
    ------
    ConfigError
    """
    if dataclasses.is_dataclass(kind):
        return read_struct(kind, value, name)  # type: ignore[arg-type]
    if kind is float:
        return _number(value, name)
    origin = getattr(kind, "__origin__", None)
    if origin is Union:
        return None if value is None else read_value(kind.__args__[0], value, name)
    if origin is dict:
        if not isinstance(value, Mapping):
            raise ConfigError(f"{name} is {_shown(value)}; a struct is needed")
        element = kind.__args__[1]
        # YAML reads a bare 1 as a number, also where it is a key.
        return {str(key): read_value(element, item, f"{name}/{key}") for key, item in value.items()}
    if origin in (tuple, list):
        return _elements(kind, value, name)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ConfigError(f"{name} is {_shown(value)}; {_WANTED[kind]} is needed")
    return value


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ConfigError(f"{name} is {_shown(value)}; a number is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ConfigError(f"{name} is {_shown(value)}; it must be finite")
    return number


def _elements(kind: Any, value: Any, name: str) -> Any:
    if not isinstance(value, (list, tuple)):
        raise ConfigError(f"{name} is {_shown(value)}; a list is needed")
    element = kind.__args__[0]
    fixed = kind.__origin__ is tuple and Ellipsis not in kind.__args__
    if fixed and len(value) != len(kind.__args__):
        raise ConfigError(f"{name} has {len(value)} elements; {len(kind.__args__)} are needed")
    return tuple(read_value(element, item, f"{name}[{i}]") for i, item in enumerate(value))


def require(condition: bool, message: str) -> None:
    """Raise a `ConfigError` with `message` unless `condition` holds."""
    if not condition:
        raise ConfigError(message)


def require_range(
    config: object,
    name: str,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    *,
    above: float = -math.inf,
) -> None:
    """Raise a `ConfigError` unless a number is finite and in range.

    Parameters
    ----------
    name : str
        Its field to check; None is taken there, as "not given".
    minimum, maximum : float
        Inclusive.
    above : float
        Exclusive.
    """
    value = getattr(config, name)
    if value is None:
        return
    bounds = [
        words
        for words, bound in (
            (f"above {above:g}", above),
            (f"at least {minimum:.12g}", minimum),
            (f"at most {maximum:.12g}", maximum),
        )
        if math.isfinite(bound)
    ]
    require(
        math.isfinite(value) and minimum <= value <= maximum and value > above,
        f"{name} is {value!r}; it must be {' and '.join(bounds) or 'finite'}",
    )


def require_choice(config: object, name: str, choices: Iterable[str]) -> None:
    """Raise a `ConfigError` unless the field `name` of `config` is one of `choices`."""
    value, known = getattr(config, name), list(choices)
    require(value in known, f"{name} is {value!r}; {', '.join(known)} are possible")


def require_text(config: object, name: str) -> None:
    """Raise a `ConfigError` when the string `name` of `config` is empty."""
    require(bool(getattr(config, name)), f"{name} is ''; it must not be empty")


def require_names(config: object, name: str) -> None:
    """Raise a `ConfigError` unless the field is a list, not empty, of distinct strings, not empty.

    Parameters
    ----------
    name : str
        Its field to check.
    """
    names = getattr(config, name)
    require(
        bool(names) and all(names) and len(set(names)) == len(names),
        f"{name} is {list(names)}; a list of distinct names is needed",
    )
