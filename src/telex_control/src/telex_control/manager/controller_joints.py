"""Joints of a controller, from its parameters; optional ones may be missing."""

from __future__ import annotations

from typing import Any, Collection, List

_KEYS = ("joint", "joints", "left_joints", "right_joints", "left_wheel", "right_wheel")


def controller_joints(params: Any) -> List[str]:
    """Return the joints that a controller's parameters name.

    Parameters
    ----------
    params
        The struct of its parameters; each of ``joint``, ``joints``, ``left_joints``,
        ``right_joints``, ``left_wheel`` and ``right_wheel`` holds a name or a list of names.
        Whatever else stands there is left to the controller to refuse.
    """
    found: List[str] = []
    for key in _KEYS:
        value = params.get(key) if isinstance(params, dict) else None
        values = value if isinstance(value, list) else [value]
        found += [each for each in values if isinstance(each, str)]
    return found


def without_joints(params: Any, joints: Collection[str]) -> Any:
    """Return a controller's parameters without some of its joints.

    They go from every list of names, and with what a struct says of each, such as its gains.
    """
    if isinstance(params, dict):
        return {
            key: without_joints(value, joints) for key, value in params.items() if key not in joints
        }
    if isinstance(params, list):
        return [value for value in params if not (isinstance(value, str) and value in joints)]
    return params
