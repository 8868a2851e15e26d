"""Reading YAML that nobody has checked: bounded in size, depth and kind, with line numbers."""

from __future__ import annotations

import re
from typing import Any

import yaml

from telex_control.common.params import ConfigError

MOST_BYTES = 1_000_000
"""A longer file is refused before it is read."""
_MOST_NODES = 200_000
_DEEPEST = 24
_LONGEST_NUMBER = 1000
"""Characters; YAML 1.1 also has numbers to the base 60, which take long to read."""


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Plain values only; 1e-3 and 3.7e13 are numbers, as everywhere but in YAML 1.1."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)


def _value(loader: yaml.Loader, node: yaml.ScalarNode) -> Any:
    kind = node.tag.rpartition(":")[2]
    if kind in ("int", "float") and len(node.value) > _LONGEST_NUMBER:
        raise ConfigError(
            f"line {node.start_mark.line + 1}: a number has {len(node.value)} characters; at most "
            f"{_LONGEST_NUMBER} are read"
        )
    try:
        return getattr(loader, f"construct_yaml_{kind}")(node)
    except (AttributeError, IndexError, KeyError) as error:  # PyYAML takes it for one that fits
        raise ConfigError(
            f"line {node.start_mark.line + 1}: a value is {node.value[:60]!r}; it does not fit "
            f"its tag !!{kind}"
        ) from error


for _tag in ("bool", "int", "float", "timestamp"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _value)


def read_yaml(text: str, most_bytes: int = MOST_BYTES) -> Any:
    """Make plain values of a YAML text.

    What could make much of little (anchors and aliases), stack without end, or hide a mistake (a
    key that stands twice) is refused.

    Raises
    ------
    ConfigError
        With the line, as far as it is known.
    """
    size = len(text.encode("utf-8", errors="replace"))
    if size > most_bytes:
        raise ConfigError(f"it has {size} bytes; at most {most_bytes} are read")
    try:
        _check_events(text)
        loader = _Loader(text)
        try:
            node = loader.get_single_node()
            _check_keys(node)
            return None if node is None else loader.construct_document(node)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}: " if mark else ""
        raise ConfigError(f"{where}no YAML: {error.problem or error.context}") from error
    except yaml.YAMLError as error:
        raise ConfigError(f"no YAML: {' '.join(str(error).split())}") from error
    except (ValueError, OverflowError) as error:
        if isinstance(error, ConfigError):
            raise
        # Python's own words about a number or a date that cannot be one.
        raise ConfigError(f"a value cannot be read: {error}") from error


def _check_events(text: str) -> None:
    """Go through the text without building anything of it."""
    nodes = depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            raise ConfigError(f"line {line}: anchors and aliases (& and *) are not allowed")
        if isinstance(event, yaml.NodeEvent):
            nodes += 1
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if nodes > _MOST_NODES:
            raise ConfigError(f"line {line}: more than {_MOST_NODES} values")
        if depth > _DEEPEST:
            raise ConfigError(f"line {line}: nested deeper than {_DEEPEST} levels")


def _check_keys(node: Any) -> None:
    """Refuse keys that stand twice in one struct: YAML would silently keep the last."""
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _check_keys(item)
    elif isinstance(node, yaml.MappingNode):
        seen = set()
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise ConfigError(f"line {key.start_mark.line + 1}: a key must be one word")
            if key.value in seen:
                raise ConfigError(f"line {key.start_mark.line + 1}: '{key.value}' stands twice")
            seen.add(key.value)
            _check_keys(value)
