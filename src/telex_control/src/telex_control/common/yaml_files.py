"""Reading YAML files that users write."""

from __future__ import annotations

from typing import Any, Dict, List, Set, TextIO, Tuple

import yaml


class _Loader(yaml.SafeLoader):
    """Takes the entries of a struct once, however often merges (``<<``) name it.

    Otherwise each struct that merges the one before several times multiplies them.
    """

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        super().flatten_mapping(node)
        # Of equal keys the last one counts.
        last = {id(key): (key, value) for key, value in reversed(node.value)}
        node.value = list(reversed(list(last.values())))


def load_yaml(file: TextIO) -> Any:
    """Make plain values of a YAML file, none of which holds itself.

    Anchors and aliases may stand in it; a value within its own anchor has no end, for whoever goes
    through it, and for the parameter server.

    Raises
    ------
    yaml.YAMLError
    """
    try:
        content = yaml.load(file, _Loader)
    except RecursionError:
        raise yaml.YAMLError("it is nested too deeply") from None
    except (AttributeError, ArithmeticError, LookupError, ValueError) as error:
        # Python's own words about a number, a date or a tagged value that cannot be one.
        raise yaml.YAMLError(f"a value in it cannot be: {error}") from error
    _refuse_loops(content)
    return content


def _refuse_loops(content: Any) -> None:
    """Look for a list or struct that stands in itself; without recursion, each only once."""
    within: Set[int] = set()
    done: Dict[int, Any] = {}
    waiting: List[Tuple[Any, str, bool]] = [(content, "the content", False)]
    while waiting:
        value, name, left = waiting.pop()
        key = id(value)
        if left:
            within.discard(key)
            done[key] = value
        elif key in within:
            raise yaml.YAMLError(
                f"{name} is an alias (*) of what it stands in; a value cannot hold itself"
            )
        elif isinstance(value, (dict, list)) and key not in done:
            within.add(key)
            waiting.append((value, name, True))
            items = value.items() if isinstance(value, dict) else enumerate(value)
            waiting.extend((item, f"'{each}'", False) for each, item in items)
