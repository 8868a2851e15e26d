"""Validated reading of nested parameters into frozen dataclasses.

A dataclass field is a number, a string, a bool, a list, a dict or another such dataclass; what the
parameters leave out keeps the field's default, and a key that is no field is an error.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Mapping, Type, TypeVar, get_type_hints

Config = TypeVar("Config")


class ConfigError(ValueError):
    """A parameter is wrong; the message names it, its value and what would be right."""


def read_config(kind: Type[Config], params: Any, name: str) -> Config:
    """Make a `kind` of nested parameters.

    Parameters
    ----------
    kind : dataclass type
    params : mapping
    name : str
        Full name of the parameter that holds them, for messages.

    Raises
    ------
    ConfigError
    """
    if not isinstance(params, Mapping):
        raise ConfigError(f"parameter {name} is {params!r}; a struct is needed")
    hints = get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for key in params:
        if key not in fields:
            raise ConfigError(
                f"parameter {name}/{key} is unknown; known are {', '.join(sorted(fields))}"
            )
    values = {}
    for key, field in fields.items():
        if key in params:
            values[key] = _value(hints[key], params[key], f"{name}/{key}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ConfigError(f"parameter {name}/{key} is missing")
    try:
        return kind(**values)
    except ConfigError as error:
        raise ConfigError(f"parameter {name}: {error}") from None


def _value(kind: Any, value: Any, name: str) -> Any:
    if dataclasses.is_dataclass(kind):
        return read_config(kind, value, name)  # type: ignore[arg-type]
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ConfigError(f"parameter {name} is {value!r}; a number is needed")
        if not math.isfinite(value):
            raise ConfigError(f"parameter {name} is {value}; it must be finite")
        return float(value)
    origin = getattr(kind, "__origin__", None)
    if origin is dict:
        if not isinstance(value, Mapping):
            raise ConfigError(f"parameter {name} is {value!r}; a struct is needed")
        element = kind.__args__[1]
        return {key: _value(element, item, f"{name}/{key}") for key, item in value.items()}
    if origin in (tuple, list):
        if not isinstance(value, (list, tuple)):
            raise ConfigError(f"parameter {name} is {value!r}; a list is needed")
        element = kind.__args__[0]
        if origin is tuple and Ellipsis not in kind.__args__ and len(value) != len(kind.__args__):
            raise ConfigError(
                f"parameter {name} has {len(value)} elements; {len(kind.__args__)} are needed"
            )
        return tuple(_value(element, item, f"{name}[{i}]") for i, item in enumerate(value))
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ConfigError(f"parameter {name} is {value!r}; a {kind.__name__} is needed")
    return value


def require(condition: bool, message: str) -> None:
    """Raise a `ConfigError` with `message` unless `condition` holds."""
    if not condition:
        raise ConfigError(message)
