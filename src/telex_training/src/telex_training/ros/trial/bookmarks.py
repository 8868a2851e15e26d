"""Bookmarks of one trial: their names, and which of them makes room for the next."""

from __future__ import annotations

import threading
from typing import Collection, Dict, List, NamedTuple

MOST_OF_KIND = 3
"""Bookmarks of steps, and of the operator without a name, that a trial keeps of each: of the
simulator's ten at least four are left to those with names.
"""
LONGEST_NAME = 60
_STEP, _MARK, _NAMED = "step", "mark", "named"


class Wanted(NamedTuple):
    """A bookmark that is to be set.

    Attributes
    ----------
    replaces : str
        Name of the one that goes for it; empty: none does.
    """

    name: str
    replaces: str
    kind: str


class TrialBookmarks:
    """Bookmarks of a trial that can be gone back to; from any thread."""

    def __init__(self) -> None:
        self._kinds: Dict[str, str] = {}  # by their names, oldest first
        self._marks = 0
        self._lock = threading.Lock()

    def names(self) -> List[str]:
        """Their names, oldest first."""
        with self._lock:
            return list(self._kinds)

    def of_step(self, step: str, repetition: int) -> Wanted:
        """Name the bookmark of a step that is done in a repetition."""
        return self._wanted(f"{step}, repetition {repetition}", _STEP)

    def of_operator(self, name: str, repetition: int) -> Wanted:
        """Name a bookmark that somebody asks for, in a repetition.

        Raises
        ------
        ValueError
            The name is too long, or cannot be printed.
        """
        name = name.strip()
        if len(name) > LONGEST_NAME or not name.isprintable():
            raise ValueError(
                f"name is {name[:LONGEST_NAME]!r}; at most {LONGEST_NAME} characters that can be "
                "printed are possible"
            )
        if name:
            return Wanted(name, "", _NAMED)
        with self._lock:
            self._marks += 1
            number = self._marks
        return self._wanted(f"mark {number}, repetition {repetition}", _MARK)

    def _wanted(self, name: str, kind: str) -> Wanted:
        with self._lock:
            same = [each for each, of in self._kinds.items() if of == kind and each != name]
        return Wanted(name, same[0] if len(same) >= MOST_OF_KIND else "", kind)

    def add(self, wanted: Wanted, there: Collection[str]) -> None:
        """Note one that was set, and those that the simulator has with it."""
        with self._lock:
            self._kinds.pop(wanted.name, None)
            self._kinds[wanted.name] = wanted.kind
        self.keep(there)

    def keep(self, there: Collection[str]) -> None:
        """Forget those that the simulator has no more."""
        with self._lock:
            self._kinds = {name: kind for name, kind in self._kinds.items() if name in there}

    def newest(self, name: str = "") -> str:
        """Return a name if there is one of it, or else that of the newest.

        Raises
        ------
        ValueError
            There is none.
        """
        names = self.names()
        if not names:
            raise ValueError("there is no bookmark of this trial; training/bookmark sets one")
        if name and name not in names:
            there = ", ".join(f"'{each}'" for each in names)
            raise ValueError(f"name is '{name[:80]}'; bookmarks of this trial: {there}")
        return name or names[-1]
