"""Bytes of a terminal decoded into key events.

Two dialects are understood, mixed as they come: what terminals have always sent (one report per
press or automatic repeat, no release), and the kitty keyboard protocol with its event types
(https://sw.kovidgoyal.net/kitty/keyboard-protocol/), which reports presses and releases exactly.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from enum import Enum
from typing import Dict, List, Optional, Tuple, Union

__all__ = ["Event", "FocusEvent", "KeyDecoder", "KeyEvent", "KeyKind", "KittyReply"]

ESCAPE = 0x1B
# A sequence longer than this is noise.
LONGEST_SEQUENCE = 4096


class KeyKind(Enum):
    """What happened to a key; TYPED: went down or repeated, and its release will not be told."""

    TYPED = "typed"
    PRESSED = "pressed"
    REPEATED = "repeated"
    RELEASED = "released"


@dataclass(frozen=True)
class KeyEvent:
    """One report about a key.

    Attributes
    ----------
    name
        ``"w"``, ``"W"``, ``"space"``, ``"up"``, ``"ctrl+c"``.
    key
        The key itself, the same at press and release whatever modifiers came or went meanwhile.
    kind
        What happened.
    """

    name: str
    key: str
    kind: KeyKind


@dataclass(frozen=True)
class FocusEvent:
    """The terminal's window got or lost the keyboard."""

    gained: bool


@dataclass(frozen=True)
class KittyReply:
    """The terminal speaks the kitty keyboard protocol; `exact`: and it reports releases now."""

    exact: bool


Event = Union[KeyEvent, FocusEvent, KittyReply]

CONTROL_NAMES = {0x00: "ctrl+space", 0x09: "tab", 0x0D: "enter", 0x0A: "enter", 0x7F: "backspace"}
LETTER_KEYS = {
    "A": "up",
    "B": "down",
    "C": "right",
    "D": "left",
    "H": "home",
    "F": "end",
    "P": "f1",
    "Q": "f2",
    "R": "f3",
    "S": "f4",
}
NUMBER_KEYS = {
    1: "home",
    2: "insert",
    3: "delete",
    4: "end",
    5: "pageup",
    6: "pagedown",
    **{number: f"f{index}" for index, number in enumerate((11, 12, 13, 14, 15), 1)},
    **{number: f"f{index}" for index, number in enumerate((17, 18, 19, 20, 21), 6)},
    23: "f11",
    24: "f12",
}
KITTY_KEYS = {
    9: "tab",
    13: "enter",
    27: "escape",
    32: "space",
    127: "backspace",
    **{57399 + digit: str(digit) for digit in range(10)},  # keypad
    57412: "-",
    57413: "+",
    57414: "enter",
}
# Where kitty's functional keys lie; those that KITTY_KEYS does not name (modifiers, media) are
# nobody's.
PRIVATE_USE = range(57344, 63744)
KITTY_KINDS = {1: KeyKind.PRESSED, 2: KeyKind.REPEATED, 3: KeyKind.RELEASED}
SHIFT = 1
PASTE_MARKS = {"200": True, "201": False}
REPORT_EVENT_TYPES = 2  # kitty's flag
# In the order in which they stand in a name; caps lock and num lock are none.
MODIFIERS: Dict[int, str] = {4: "ctrl", 2: "alt", 8: "super", 16: "hyper", 32: "meta"}

CSI = re.compile(rb"\x1b\[([\x30-\x3f]*)[\x20-\x2f]*([\x40-\x7e])")
SS3 = re.compile(rb"\x1bO([\x40-\x7e])")
# Strings that terminals send in answer to questions: DCS, OSC and their like, up to their end.
STRING = re.compile(rb"\x1b[P\]X^_].*?(?:\x1b\\|\x07)", re.DOTALL)


class KeyDecoder:
    """Decodes a stream of bytes that may be cut anywhere.

    Parameters
    ----------
    escape_time
        An escape byte that nothing follows for so long (s) was the escape key.
    """

    def __init__(self, escape_time: float = 0.05) -> None:
        self._escape_time = escape_time
        self._buffer = bytearray()
        self._last_byte = 0.0
        self._exact = False
        self._pasting = False

    def feed(self, data: bytes, now: float) -> List[Event]:
        """Decode what has come, perhaps nothing, by `now` (monotonic time, s)."""
        if data:
            self._buffer += data
            self._last_byte = now
        events: List[Event] = []
        while self._buffer:
            taken, event = self._next()
            if taken == 0:
                waited = now - self._last_byte >= self._escape_time
                if not waited and len(self._buffer) < LONGEST_SEQUENCE:
                    break
                # The rest is not coming. A piece of a sequence must not pass for keys.
                taken = len(self._buffer)
                event = _plain("escape") if self._buffer == bytes([ESCAPE]) else None
            del self._buffer[:taken]
            if isinstance(event, KittyReply):
                self._exact = event.exact
            if event is not None and not self._pasting:
                events.append(event)
        return events

    @property
    def incomplete(self) -> bool:
        """Whether bytes wait for the rest of their sequence."""
        return bool(self._buffer)

    def _next(self) -> Tuple[int, Optional[Event]]:
        """Return how many bytes the first event takes (0: it is not complete) and the event."""
        if self._buffer[0] != ESCAPE:
            return self._character()
        if len(self._buffer) == 1:
            return 0, None
        second = self._buffer[1]
        if second == ESCAPE:
            return 1, _plain("escape")
        if second == ord("["):
            return self._sequence(CSI)
        if second == ord("O"):
            return self._sequence(SS3)
        if second in b"P]X^_":
            found = STRING.match(self._buffer)
            return (found.end(), None) if found else (0, None)
        return self._with_alt()

    def _character(self) -> Tuple[int, Optional[Event]]:
        first = self._buffer[0]
        if first < 0x20 or first == 0x7F:
            return 1, _plain(CONTROL_NAMES.get(first, f"ctrl+{chr(first + 0x60)}"))
        decoder = codecs.getincrementaldecoder("utf-8")("replace")
        for taken in range(1, len(self._buffer) + 1):
            text = decoder.decode(bytes(self._buffer[taken - 1 : taken]))
            if text:
                name = "space" if text == " " else text
                return taken, _plain(name) if text != "\ufffd" else None
        return 0, None

    def _with_alt(self) -> Tuple[int, Optional[Event]]:
        escape = self._buffer.pop(0)
        try:
            taken, event = self._character()
        finally:
            self._buffer.insert(0, escape)
        if isinstance(event, KeyEvent):
            event = _plain(f"alt+{event.name}")
        return (taken + 1, event) if taken else (0, None)

    def _sequence(self, pattern: re.Pattern[bytes]) -> Tuple[int, Optional[Event]]:
        found = pattern.match(self._buffer)
        if found is None:
            return 0, None
        if pattern is SS3:
            name = LETTER_KEYS.get(found.group(1).decode())
            return found.end(), _plain(name) if name else None
        parameters, final = found.group(1).decode(), found.group(2).decode()
        if final == "~" and parameters in PASTE_MARKS:
            # a text that is dropped on the window is no command to a robot
            self._pasting = PASTE_MARKS[parameters]
        return found.end(), _control_sequence(parameters, final, self._exact)


def _plain(name: str) -> KeyEvent:
    return KeyEvent(name, name, KeyKind.TYPED)


def _control_sequence(parameters: str, final: str, exact: bool) -> Optional[Event]:
    """Return the event of ``CSI parameters final``, None for what is no key."""
    if parameters.startswith("?"):
        flags = parameters[1:]
        if final != "u" or not flags.isdecimal():
            return None
        return KittyReply(exact=bool(int(flags) & REPORT_EVENT_TYPES))
    if final in "IO" and not parameters:
        return FocusEvent(gained=final == "I")
    if final == "Z":
        return _plain("shift+tab")
    fields = _fields(parameters)
    if fields is None:
        return None
    code = fields[0][0] or 1
    modifiers, kind = _modifiers_and_kind(fields, exact)
    if final == "u":
        shifted = fields[0][1] if len(fields[0]) > 1 else 0
        return _kitty_key(fields[0][0], shifted, modifiers, kind)
    name = NUMBER_KEYS.get(code) if final == "~" else LETTER_KEYS.get(final)
    if name is None:
        return None
    return KeyEvent(_with_modifiers(name, modifiers, keep_shift=True), name, kind)


def _fields(parameters: str) -> Optional[List[List[int]]]:
    """Return the numbers of ``1:2;3``; an absent one is 0; None when it is no such list."""
    try:
        return [
            [int(part) if part else 0 for part in field.split(":")]
            for field in parameters.split(";")
        ]
    except ValueError:
        return None


def _modifiers_and_kind(fields: List[List[int]], exact: bool) -> Tuple[int, KeyKind]:
    field = fields[1] if len(fields) > 1 else [1]
    if len(field) > 1:
        kind = KITTY_KINDS.get(field[1], KeyKind.PRESSED)
    else:
        # kitty leaves the type of a press out, and old terminals know no types
        kind = KeyKind.PRESSED if exact else KeyKind.TYPED
    return max(field[0] - 1, 0), kind


def _kitty_key(code: int, shifted: int, modifiers: int, kind: KeyKind) -> Optional[Event]:
    if code in KITTY_KEYS:
        name = KITTY_KEYS[code]
        return KeyEvent(_with_modifiers(name, modifiers, keep_shift=len(name) > 1), str(code), kind)
    if code in PRIVATE_USE or code < 32 or code > 0x10FFFF:
        return None
    name = chr(code)
    if modifiers & SHIFT:
        name = chr(shifted) if 32 < shifted <= 0x10FFFF else name.upper()
    return KeyEvent(_with_modifiers(name, modifiers, keep_shift=False), str(code), kind)


def _with_modifiers(name: str, modifiers: int, keep_shift: bool) -> str:
    parts = [text for bit, text in MODIFIERS.items() if modifiers & bit]
    if keep_shift and modifiers & SHIFT:
        parts.append("shift")
    return "+".join([*parts, name])
