"""Message types as rosapi describes them: one TypeDef for a type and each type inside it."""

from __future__ import annotations

import re
from typing import Any, Dict, List, Type

import genpy

from .message_types import message_class

_ARRAY = re.compile(r"(?P<element>.*)\[(?P<length>\d*)\]\Z")
_EXAMPLES = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}
_TIMES = ("time", "duration")
SCALAR, VARIABLE = -1, 0
"""What TypeDef says of a field that is no array, and of an array of any length."""


def type_details(found: Type[genpy.Message]) -> List[Dict[str, Any]]:
    """Return the TypeDefs of a class and of all types inside it, itself first.

    Parameters
    ----------
    found
        Message class, or request or response class of a service.
    """
    details: Dict[str, Dict[str, Any]] = {}
    waiting = [found]
    while waiting:
        next_class = waiting.pop(0)
        if next_class._type in details:
            continue
        details[next_class._type] = _type_def(next_class)
        for field_type in details[next_class._type]["fieldtypes"]:
            if "/" in field_type:
                waiting.append(message_class(field_type))
    return list(details.values())


def _type_def(found: Type[genpy.Message]) -> Dict[str, Any]:
    types, lengths, examples = [], [], []
    for slot_type in found._slot_types:
        array = _ARRAY.match(slot_type)
        element = array["element"] if array else slot_type
        types.append(element)
        lengths.append(int(array["length"] or VARIABLE) if array else SCALAR)
        nested = "/" in element or element in _TIMES
        examples.append("[]" if array else "{}" if nested else _EXAMPLES.get(element, "0"))
    constants = _constants(found)
    return {
        "type": found._type,
        "fieldnames": list(found.__slots__),
        "fieldtypes": types,
        "fieldarraylen": lengths,
        "examples": examples,
        "constnames": list(constants),
        "constvalues": list(constants.values()),
    }


def _constants(found: Type[genpy.Message]) -> Dict[str, str]:
    """Return the constants of a class; genpy makes them plain attributes."""
    return {
        name: str(value)
        for name, value in vars(found).items()
        if not name.startswith("_")
        and name not in found.__slots__
        and isinstance(value, (bool, int, float, str))
    }
