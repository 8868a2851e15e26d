"""Fair queueing: whose turn it is of those who share the time of a thread."""

from __future__ import annotations

from typing import Dict, Hashable, Iterable

_NEWS = 0.1
"""Weight of the last call in what calls usually take."""


class FairShares:
    """How much time each of some sharers has used.

    The turn is of the one who will have used least after it: those whose calls take long get their
    share of the time, and make the others wait for no more than one call. Who begins, or has
    paused, starts level with the others: with what each of them would have used by now if all had
    got the same. That grows with every call, so that sharers who keep coming and going cannot hold
    back one that stays.
    """

    def __init__(self) -> None:
        self._used: Dict[Hashable, float] = {}  # s of the thread's time
        self._took: Dict[Hashable, float] = {}  # s, the last call
        self._level = 0.0  # s, where a sharer begins; it never falls
        self._usual = 0.0  # s, what calls took of late

    def __len__(self) -> int:
        return len(self._used)

    def enter(self, sharer: Hashable) -> None:
        """Let somebody take part who begins, or has paused."""
        self._used[sharer] = max(self._used.get(sharer, 0.0), self._level)

    def leave(self, sharer: Hashable) -> None:
        """Forget somebody."""
        self._used.pop(sharer, None)
        self._took.pop(sharer, None)

    def used(self, sharer: Hashable) -> float:
        """Return what somebody who takes part has used (s)."""
        return self._used[sharer]

    def next(self, waiting: Iterable[Hashable]) -> Hashable:
        """Return whose turn it is."""
        return min(waiting, key=self._rank)

    def advance(self, took: float, waiting: int) -> None:
        """Note that a call took some time (s) for which so many sharers waited."""
        self._level += took / waiting
        self._usual += (took - self._usual) * _NEWS

    def charge(self, sharer: Hashable, before: float, took: float) -> None:
        """Charge somebody, who had used `before` at its start, with the time of a call (s)."""
        if sharer in self._used:
            self._took[sharer] = took
            self._used[sharer] = max(before + took, self._level)

    def _rank(self, sharer: Hashable) -> float:
        """Return what somebody will have used after a call, if that takes as long as the last.

        Whose first it is is taken for one like the others.
        """
        return self._used[sharer] + self._took.get(sharer, self._usual)
