"""Held keys, on terminals that report releases and on terminals that do not.

With the kitty protocol presses and releases are exact. Other terminals only type: once when a key
goes down, again after the repeat delay, then at the repeat rate, and nothing when it goes up. There
a first character is a nudge of `tap_time`, and a key that repeats is held until `key_timeout` after
its last character.
"""

from __future__ import annotations

from typing import Dict, List, Set

from telex_teleop.keyboard.decoding import KeyEvent, KeyKind


class HeldKeys:
    """Keys that are held now, by name.

    Parameters
    ----------
    tap_time
        How long (s) a key counts as held after a first character.
    key_timeout
        How long (s) it does after a repeated one.
    """

    def __init__(self, tap_time: float, key_timeout: float) -> None:
        self._tap_time = tap_time
        self._key_timeout = key_timeout
        self._pressed: Dict[str, str] = {}  # key to name, exact
        self._typed: Dict[str, float] = {}  # name to the time until which it is held
        self._ignored: Set[str] = set()  # exact keys that were held when all was released
        self._ignored_until: Dict[str, float] = {}  # the same for typed ones

    def take(self, event: KeyEvent, now: float) -> bool:
        """Take an event at `now` (monotonic time, s).

        Returns
        -------
        bool
            Whether the key went down: it is what starts a command that is not held.
        """
        if event.kind is KeyKind.TYPED:
            return self._type(event.name, now)
        if event.kind is KeyKind.RELEASED:
            self._pressed.pop(event.key, None)
            self._ignored.discard(event.key)
            return False
        if event.kind is KeyKind.REPEATED:
            return False
        self._ignored.discard(event.key)
        self._pressed[event.key] = event.name
        return True

    @property
    def exact(self) -> bool:
        """Whether a key is held of which only its release will tell the end."""
        return any(key not in self._ignored for key in self._pressed)

    def names(self, now: float) -> List[str]:
        """Return the keys that are held at `now`, in the order of their presses."""
        for name in [name for name, until in self._typed.items() if now >= until]:
            del self._typed[name]
        exact = [name for key, name in self._pressed.items() if key not in self._ignored]
        return exact + [name for name in self._typed if name not in exact]

    def release_all(self, now: float) -> None:
        """Let all keys go; those still held count again only after a new press."""
        self._ignored.update(self._pressed)
        for name in self.names(now):
            if name in self._typed:
                self._ignored_until[name] = now + self._key_timeout
        self._typed.clear()

    def _type(self, name: str, now: float) -> bool:
        if now < self._ignored_until.get(name, now):
            # still the repetition of the press that was let go
            self._ignored_until[name] = now + self._key_timeout
            return False
        self._ignored_until.pop(name, None)
        repeated = now < self._typed.get(name, now)
        self._typed[name] = now + (self._key_timeout if repeated else self._tap_time)
        return not repeated
