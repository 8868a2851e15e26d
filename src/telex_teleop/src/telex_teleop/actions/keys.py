"""Names of keys, as configuration files have them, and as a browser does."""

from __future__ import annotations

from typing import Tuple

_NAMED = {
    "tab": ("Tab", "Tab"),
    "enter": ("Enter", "Enter"),
    "space": ("Space", "Space"),
    "backspace": ("Backspace", "Backspace"),
    "escape": ("Escape", "Esc"),
    "up": ("ArrowUp", "↑"),
    "down": ("ArrowDown", "↓"),
    "left": ("ArrowLeft", "←"),
    "right": ("ArrowRight", "→"),
    "home": ("Home", "Home"),
    "end": ("End", "End"),
    "insert": ("Insert", "Ins"),
    "delete": ("Delete", "Del"),
    "pageup": ("PageUp", "PgUp"),
    "pagedown": ("PageDown", "PgDn"),
    # those of the function keys that browsers leave to pages
    **{f"f{number}": (f"F{number}", f"F{number}") for number in (1, 2, 3, 4, 6, 7, 8, 9, 10)},
    **{f"numpad{digit}": (f"Numpad{digit}", f"Num {digit}") for digit in range(10)},
}
_SIGNS = {
    "`": "Backquote",
    "-": "Minus",
    "=": "Equal",
    "[": "BracketLeft",
    "]": "BracketRight",
    "\\": "Backslash",
    ";": "Semicolon",
    "'": "Quote",
    ",": "Comma",
    ".": "Period",
    "/": "Slash",
    "?": "Slash",
}


def is_function_key(key: str) -> bool:
    """Tell whether it is one of the keys F1 to F12; a terminal has its own actions on them."""
    return key[:1] == "f" and key[1:].isdigit()


def page_key(key: str) -> Tuple[str, str]:
    """Return what a browser calls a key: its place (KeyboardEvent.code), and what a US key shows.

    Parameters
    ----------
    key
        As it is typed on a US keyboard, or a name such as ``pageup``.

    Raises
    ------
    ValueError
        When a page cannot have the key.
    """
    if key in _NAMED:
        return _NAMED[key]
    if key in _SIGNS:
        return _SIGNS[key], key
    if len(key) == 1 and key.isascii() and (key.islower() or key.isdigit()):
        return ("Digit" if key.isdigit() else "Key") + key.upper(), key.upper()
    raise ValueError(key)
