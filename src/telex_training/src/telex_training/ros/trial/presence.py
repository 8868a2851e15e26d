"""Who has control of the robots of a trial, and for how long nobody has had it."""

from __future__ import annotations

import time
from typing import Any, Collection, Dict, NamedTuple, Optional

SILENT = 5.0
"""Wall time without a word of a bridge, which speaks every second, after which it is gone (s)."""


class _Word(NamedTuple):
    """What a bridge has said last, and when (s of wall time)."""

    holder: str
    name: str
    at: float


class Presence:
    """Hears the bridge of each robot; the first robot's namespace is empty."""

    def __init__(self) -> None:
        self._words: Dict[str, _Word] = {}
        self._had_holder = False
        self._away_since: Optional[float] = None

    def hear(self, robot: str, message: Any) -> None:
        """Hear telex_msgs/BridgeClients of a robot's bridge."""
        names = (each.name for each in message.clients if each.id == message.holder)
        self._words[robot] = _Word(message.holder, next(names, ""), time.monotonic())

    def name(self, robot: str = "") -> str:
        """Name of who has control of a robot; empty: nobody, or he has given none."""
        return "" if self.silent([robot]) else self._words[robot].name

    def silent(self, robots: Collection[str]) -> bool:
        """Whether the bridge of one of the robots is gone."""
        now = time.monotonic()
        words = [self._words.get(each) for each in robots]
        return any(word is None or now - word.at > SILENT for word in words)

    def _held(self, robots: Collection[str]) -> bool:
        return any(not self.silent([each]) and self._words[each].holder for each in robots)

    def stay(self, robots: Collection[str]) -> None:
        """Count from now on: somebody has just done something in the trial of these robots."""
        self._away_since = None
        self._had_holder = self._held(robots)

    def rest(self) -> None:
        """Count no more: no trial is under way."""
        self._away_since = None

    def left(self, robots: Collection[str], now: float, away: float) -> bool:
        """Whether nobody has had control of any of the robots for long; it then counts anew.

        Where nobody has had control so far, he has not left.

        Parameters
        ----------
        now, away : float
            Sim time, and for how much of it nobody may have control (s).
        """
        held = self._held(robots)
        self._had_holder = self._had_holder or held
        if held or not self._had_holder:
            self._away_since = None
        elif self._away_since is None:
            self._away_since = now
        elif now - self._away_since > away:
            self._away_since = None
            return True
        return False
