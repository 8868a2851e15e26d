"""Parameters that are changed while the node runs."""

from __future__ import annotations

import dataclasses
from typing import Any, Collection, Dict, Mapping, TypeVar

import yaml

from telex_control.common.params import ConfigError, read_struct

from ...scene.files.yaml_text import read_yaml

Config = TypeVar("Config")


def changed(config: Config, text: str, fixed: Collection[str]) -> Config:
    """Make a configuration that differs from another as a text says.

    Parameters
    ----------
    text : str
        YAML: a struct with some of its keys, and keys of structs in it; empty for none.
    fixed : collection of str
        Fields that cannot be changed.

    Raises
    ------
    ConfigError
        Something in the text is wrong.
    """
    try:
        changes = read_yaml(text)
    except ConfigError as error:
        raise ConfigError(f"parameters: {error}") from None
    if changes is None:
        return config
    if not isinstance(changes, Mapping):
        raise ConfigError(f"parameters are {changes!r}; a struct is needed, e.g. {{rate: 5}}")
    before = dataclasses.asdict(config)  # type: ignore[call-overload]
    for key in fixed:
        if key in changes and changes[key] != before[key]:
            raise ConfigError(f"{key} cannot be changed while the node runs")
    return read_struct(type(config), _merged(before, changes))


def _merged(before: Mapping[str, Any], changes: Mapping[str, Any]) -> Dict[str, Any]:
    merged = dict(before)
    for key, value in changes.items():
        inner = before.get(key)
        nested = isinstance(inner, Mapping) and isinstance(value, Mapping)
        merged[str(key)] = _merged(inner, value) if nested else value  # type: ignore[arg-type]
    return merged


def as_yaml(values: Mapping[str, Any]) -> str:
    """Write parameters in one line."""
    return yaml.safe_dump(plain(values), default_flow_style=True, width=10**6).strip()


def plain(value: Any) -> Any:
    """Values as YAML and the parameter server have them, of what `dataclasses.asdict` gives."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value
