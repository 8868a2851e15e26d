"""Keeps what is expensive to make from one version of the scene to the next."""

from __future__ import annotations

from typing import Callable, Dict, Generic, Hashable, TypeVar

Value = TypeVar("Value")


class RenewedCache(Generic[Value]):
    """A cache that forgets what the newest version no longer uses.

    For each version: `begin`, `get` for all that it needs, then `end`.

    Parameters
    ----------
    release
        Called with what is forgotten.
    """

    def __init__(self, release: Callable[[Value], object]) -> None:
        self._release = release
        self._old: Dict[Hashable, Value] = {}
        self._new: Dict[Hashable, Value] = {}

    def begin(self) -> None:
        """Start a version."""
        self._old, self._new = self._new, {}

    def get(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Find the value of a key in this version or the one before, or make it; never None."""
        # Keys may be long, and each look takes their hash.
        value = self._new.get(key)
        if value is None:
            value = self._old.get(key)
            self._new[key] = value = make() if value is None else value
        return value

    def end(self) -> None:
        """Forget what this version did not ask for."""
        for key, value in self._old.items():
            if key not in self._new:
                self._release(value)
        self._old = {}
