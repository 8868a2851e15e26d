"""An instructor's changes of the scene, in words; from telex_msgs/InstructorAction."""

from __future__ import annotations

import json
from typing import Any, Callable, Dict, Mapping, Tuple

from .entries import Entry, decode

_LONGEST = 120


def action_of(entry: Entry) -> Tuple[str, str]:
    """Return who has done something, and what, in words.

    Raises
    ------
    telex_training.judging.entries.BadEntryError
    """
    message = decode(entry, "telex_msgs/InstructorAction")
    try:
        fields = json.loads(message.request)
    except (ValueError, RecursionError):
        fields = None
    words = _WORDS.get(message.service)
    if words is None or not isinstance(fields, dict):
        return str(message.by), str(message.service)[:_LONGEST]
    return str(message.by), words(fields)[:_LONGEST]


def interference(by: str) -> str:
    """Why an exam is invalid in which somebody has changed the scene, in words."""
    return f"{by[:40]} has changed the scene"


def _text(fields: Mapping[str, Any], name: str) -> str:
    return str(fields.get(name, ""))[:_LONGEST]


def _share(fields: Mapping[str, Any], name: str) -> str:
    value = fields.get(name, 0.0)
    return f"{value:.0%}" if isinstance(value, (int, float)) else "?"


def _place(fields: Mapping[str, Any]) -> str:
    place: Any = fields
    for name in ("pose", "position"):
        place = place.get(name) if isinstance(place, dict) else None
    if not isinstance(place, dict):
        return "elsewhere"
    numbers = [place.get(axis, 0.0) for axis in "xyz"]
    if not all(isinstance(number, (int, float)) for number in numbers):
        return "elsewhere"
    return "to " + ", ".join(f"{number:.2f}" for number in numbers)


_WORDS: Dict[str, Callable[[Mapping[str, Any]], str]] = {
    "sim/spawn": lambda fields: f"put in: {_text(fields, 'object')}",
    "sim/delete": lambda fields: f"took out '{_text(fields, 'name')}'",
    "sim/move": lambda fields: f"moved '{_text(fields, 'name')}' {_place(fields)}",
    "sim/set_light": lambda fields: (
        f"set daylight to {_share(fields, 'daylight')}, lamps to {_share(fields, 'lamps')}"
    ),
}
