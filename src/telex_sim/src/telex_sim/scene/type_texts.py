"""Descriptions of the library's types, for people."""

from __future__ import annotations

import dataclasses
import inspect
from typing import Any, List, Tuple, Type, Union, get_type_hints

from telex_control.common.params import required

from .library.object_type import ObjectType
from .library.parameters import meaning


def summary(kind: Type[ObjectType]) -> str:
    """The first line of a type's documentation."""
    return (inspect.getdoc(kind) or "").split("\n", 1)[0]


def parameters(kind: Type[ObjectType]) -> List[Tuple[str, str, str]]:
    """Name, default and meaning of every parameter, as they are declared."""
    hints = get_type_hints(kind)
    return [
        (each.name, _default(each), f"{_type_name(hints[each.name])}. {meaning(each)}")
        for each in dataclasses.fields(kind)  # type: ignore[arg-type]
    ]


def _type_name(hint: Any) -> str:
    """Name of a field's type, such as ``tuple of 3 floats`` or ``float, optional``."""
    origin = getattr(hint, "__origin__", None)
    if origin is Union:
        return f"{_type_name(hint.__args__[0])}, optional"
    if origin is tuple:
        element = _type_name(hint.__args__[0])
        count = "" if Ellipsis in hint.__args__ else f"{len(hint.__args__)} "
        return f"tuple of {count}{'floats' if element == 'float' else element}"
    name: str = hint.__name__
    return name


def _default(field: Any) -> str:
    if field.default_factory is required or (
        field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    ):
        return "required"
    value = field.default
    if value is dataclasses.MISSING:
        value = field.default_factory()
    return _yaml(value)


def _yaml(value: Any) -> str:
    """A value as it would stand in a scene file, roughly."""
    if dataclasses.is_dataclass(value):
        pairs = ((f.name, getattr(value, f.name)) for f in dataclasses.fields(value))
        return "{" + ", ".join(f"{name}: {_yaml(item)}" for name, item in pairs) + "}"
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_yaml(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    if value is None:
        return "none"
    return value if isinstance(value, str) and value else repr(value)
