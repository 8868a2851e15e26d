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
from typing import Collection, Dict, List, Optional, Tuple, Union

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

CSI = re.compile(rb"\x1b\[([\x30-\x3f]*)([\x20-\x2f]*)([\x40-\x7e])?")
SS3 = re.compile(rb"\x1bO([\x40-\x7e])")
# Strings that terminals send in answer to questions: DCS, OSC and their like, up to their end.
STRING = re.compile(rb"\x1b[P\]X^_].*?(?:\x1b\\|\x07)", re.DOTALL)
# Ends of control sequences that are no keys: answers to questions and reports of the mouse.
ANSWERS = frozenset("RcntyMm")


class KeyDecoder:
    """Decodes a stream of bytes that may be cut anywhere.

    The byte of the escape key also begins every sequence. Escape is the emergency stop, so what is
    not clearly something else is the escape key.

    Parameters
    ----------
    alt_names
        Keys with alt, ``"alt+x"``, that mean something; for others it was escape and then ``x``.
    escape_time
        An escape byte that nothing follows for so long (s), or no complete sequence, was the escape
        key.
    paste_time
        A pasted text that does not go on for so long (s) has ended.
    """

    def __init__(
        self,
        alt_names: Collection[str] = (),
        escape_time: float = 0.05,
        paste_time: float = 0.3,
    ) -> None:
        self._alt_names = alt_names
        self._escape_time = escape_time
        self._paste_time = paste_time
        self._buffer = bytearray()
        self._waiting_since = 0.0
        self._last_byte = 0.0
        self._exact = False
        self._pasting = False

    def feed(self, data: bytes, now: float) -> List[Event]:
        """Decode what has come, perhaps nothing, by `now` (monotonic time, s)."""
        if not data and now - self._last_byte >= self._paste_time:
            self._pasting = False
        if data:
            # A sequence is waited for from its first byte on: keys that follow do not prolong it.
            if not self._buffer:
                self._waiting_since = now
            self._buffer += data
            self._last_byte = now
        events: List[Event] = []
        while self._buffer:
            taken, event = self._next()
            if taken == 0:
                waited = now - self._waiting_since >= self._escape_time
                if not waited and len(self._buffer) < LONGEST_SEQUENCE:
                    break
                # The rest is not coming. A piece of a sequence must not pass for other keys.
                event = ESCAPE_KEY if self._buffer[0] == ESCAPE else None
                taken = len(self._buffer)
            del self._buffer[:taken]
            self._waiting_since = now
            if isinstance(event, KittyReply):
                self._exact = event.exact
            # terminals take escape out of pasted text, so there too it was the key
            if event is not None and (not self._pasting or _is_escape(event)):
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
            return 1, ESCAPE_KEY
        if second == ord("["):
            return self._control_sequence()
        if second == ord("O"):
            return self._function_key()
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
        if not taken:
            return 0, None
        name = f"alt+{event.name}" if isinstance(event, KeyEvent) else ""
        return (taken + 1, _plain(name)) if name in self._alt_names else (1, ESCAPE_KEY)

    def _function_key(self) -> Tuple[int, Optional[Event]]:
        if len(self._buffer) == 2:
            return 0, None
        found = SS3.match(self._buffer)
        name = LETTER_KEYS.get(found.group(1).decode()) if found else None
        if found is None or name is None:
            return (found.end() if found else 2), ESCAPE_KEY
        return found.end(), _plain(name)

    def _control_sequence(self) -> Tuple[int, Optional[Event]]:
        found = CSI.match(self._buffer)
        assert found is not None
        if found.group(3) is None:
            # either the rest is still to come, or a byte that no sequence has
            return (0, None) if found.end() == len(self._buffer) else (found.end(), ESCAPE_KEY)
        parameters, final = found.group(1).decode(), found.group(3).decode()
        if not _is_known(parameters, found.group(2), final):
            return found.end(), ESCAPE_KEY
        if final == "~" and parameters in PASTE_MARKS:
            # a text that is dropped on the window is no command to a robot
            self._pasting = PASTE_MARKS[parameters]
        return found.end(), _control_sequence(parameters, final, self._exact)


def _is_known(parameters: str, intermediates: bytes, final: str) -> bool:
    """Tell whether terminals send such a sequence, whatever it means."""
    if intermediates:
        return final == "y"
    if not parameters:
        return final in LETTER_KEYS or final in "IOZ"
    return final in LETTER_KEYS or final in "~u" or final in ANSWERS


def _is_escape(event: Event) -> bool:
    return isinstance(event, KeyEvent) and event.name == "escape"


def _plain(name: str) -> KeyEvent:
    return KeyEvent(name, name, KeyKind.TYPED)


ESCAPE_KEY = _plain("escape")


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
