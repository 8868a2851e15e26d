"""Which joints a controller is for, as its parameters say."""

from __future__ import annotations

from typing import Any, List

_KEYS = ("joint", "joints", "left_wheel", "right_wheel")


def controller_joints(params: Any) -> List[str]:
    """Return the joints that a controller's parameters name.

    Parameters
    ----------
    params
        The struct of its parameters; each of ``joint``, ``joints``, ``left_wheel`` and
        ``right_wheel`` holds a name or a list of names. Whatever else stands there is left to the
        controller to refuse.
    """
    found: List[str] = []
    for key in _KEYS:
        value = params.get(key) if isinstance(params, dict) else None
        values = value if isinstance(value, list) else [value]
        found += [each for each in values if isinstance(each, str)]
    return found
