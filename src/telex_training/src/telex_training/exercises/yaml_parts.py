"""Lists and structs on the top level of a YAML file, of a size that somebody wrote by hand."""

from __future__ import annotations

from typing import Any, List, Mapping, Tuple, Type, TypeVar

from telex_control.common.params import read_struct, require

MOST = 100
"""Entries of a list, or of a struct with names of the author's choice."""

Made = TypeVar("Made")


def struct_of(content: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """Return the struct of a key; empty: there is none. Raises a ConfigError."""
    given = content.get(key)
    if given is None:
        return {}
    require(isinstance(given, Mapping), f"{key} is {str(given)[:60]!r}; a struct is needed")
    require(len(given) <= MOST, f"{key} has {len(given)} entries; at most {MOST} fit")
    return {str(name): value for name, value in given.items()}


def list_of(content: Mapping[str, Any], key: str) -> List[Any]:
    """Return the list of a key; empty: there is none. Raises a ConfigError."""
    given = content.get(key)
    if given is None:
        return []
    require(isinstance(given, list), f"{key} is {str(given)[:60]!r}; a list is needed")
    require(len(given) <= MOST, f"{key} has {len(given)} entries; at most {MOST} fit")
    return given


def structs_of(content: Mapping[str, Any], key: str, kind: Type[Made]) -> Tuple[Made, ...]:
    """Read the list of a key, each of its entries as a dataclass. Raises a ConfigError."""
    return tuple(
        read_struct(kind, given, f"{key}[{i}]") for i, given in enumerate(list_of(content, key))
    )
