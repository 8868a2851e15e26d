"""One text that a client sent, as an operation with checked fields."""

from __future__ import annotations

import json
from typing import Any, Dict, Optional, Union

MAX_DIGITS = 20
"""Digits of the longest 64-bit integer; longer ones would only cost time to read."""

MAX_TEXT = 500
"""Characters of the longest name of a topic, service, type or operation."""

Id = Union[str, int, None]

Arguments = Dict[str, Any]
"""Fields of a service's request, as JSON gave them."""


class OperationError(ValueError):
    """The client asked for something that cannot be done; the text says why."""


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def _integer(digits: str) -> int:
    if len(digits) > MAX_DIGITS + 1:
        raise ValueError("a number has too many digits")
    return int(digits)


_DECODER = json.JSONDecoder(parse_int=_integer, parse_constant=_no_constant)


def parse_json(text: str) -> Any:
    """Read JSON strictly: no NaN or infinities, no endless numbers, no endless nesting.

    Raises
    ------
    OperationError
        The text is not such JSON.
    """
    try:
        return _DECODER.decode(text)
    except RecursionError:
        raise OperationError("the JSON is nested too deeply") from None
    except ValueError as error:
        raise OperationError(f"this is not valid JSON: {error}") from None


class Operation:
    """A JSON object with an `op`; its fields are checked when they are read.

    Parameters
    ----------
    text
        What the client sent.
    received
        When it came, on this machine's monotonic clock (s).

    Attributes
    ----------
    sent
        When it was sent, on the same clock (s); None if the client does not tell.
    held
        Time (s) that it has been held since it came; `received` and `sent` are later by as much.

    Raises
    ------
    OperationError
        The text is not a JSON object with an `op`.
    """

    def __init__(self, text: str, received: float) -> None:
        fields = parse_json(text)
        if not isinstance(fields, dict):
            raise OperationError("a message must be a JSON object with an 'op'")
        self._fields: Dict[str, Any] = fields
        self.received = received
        self.sent: Optional[float] = None
        self.held = 0.0
        self.id = self._read_id()
        self.op = self.text("op")

    def hold_until(self, now: float) -> None:
        """Count a message as one that comes only now (s), at the age that it came with."""
        self.held = now - self.received
        self.received = now
        if self.sent is not None:
            self.sent += self.held

    def _read_id(self) -> Id:
        value = self._fields.get("id")
        is_short_text = isinstance(value, str) and len(value) <= 1000
        is_number = isinstance(value, int) and not isinstance(value, bool)
        return value if is_short_text or is_number else None

    def get(self, name: str) -> Any:
        """Return a field as it came, None if it is missing."""
        return self._fields.get(name)

    def text(self, name: str) -> str:
        """Return a field that must be a string and not empty."""
        value = self._fields.get(name)
        if not isinstance(value, str) or not value:
            raise OperationError(f"'{name}' must be a string that is not empty")
        if len(value) > MAX_TEXT:
            raise OperationError(f"'{name}' has {len(value)} characters; {MAX_TEXT} are enough")
        return value

    def optional_text(self, name: str) -> Optional[str]:
        """Return a field that may be missing or null, but otherwise must be a string."""
        return None if self._fields.get(name) is None else self.text(name)

    def flag(self, name: str) -> bool:
        """Return a field that must be true or false; false if it is missing."""
        value = self._fields.get(name)
        if value is None:
            return False
        if not isinstance(value, bool):
            raise OperationError(f"'{name}' must be true or false")
        return value

    def count(self, name: str, default: int) -> int:
        """Return a field that must be a whole number from 0 on; the default if it is missing."""
        value = self._fields.get(name)
        if value is None:
            return default
        # JavaScript has one kind of number: clients may well send 100.0.
        whole = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not whole or value != value // 1 or not 0 <= value < 2**53:
            raise OperationError(f"'{name}' must be a whole number from 0 on")
        return int(value)
