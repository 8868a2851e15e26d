"""Messages under way on the line, in the order in which they were sent."""

from __future__ import annotations

import collections
import math
from typing import Callable, Deque, Generic, List, Optional, TypeVar

from .line import Line

Item = TypeVar("Item")

BACKWARDS = 1.0
"""Time (s) by which a clock must jump back for what is under way to be counted by its new time."""


class _UnderWay(Generic[Item]):
    __slots__ = ("due", "item", "leaves", "size", "waits")

    def __init__(self, item: Item, size: int, leaves: float, due: float, waits: bool) -> None:
        self.item = item
        self.size = size
        self.leaves = leaves
        self.due = due
        self.waits = waits


class LineQueue(Generic[Item]):
    """One direction of one connection: first in, first out.

    What may be lost is lost or comes in time; what must arrive comes late instead, and all that was
    sent after it comes later still.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._version = line.version
        self._items: Deque[_UnderWay[Item]] = collections.deque()
        self._free = -math.inf
        self._latest = -math.inf
        self.bytes = 0

    def __len__(self) -> int:
        return len(self._items)

    @property
    def passes(self) -> bool:
        """Whether a message would arrive at once; it need not be sent by this queue then."""
        return self._line.is_perfect and not self._items

    def send(self, item: Item, size: int, now: float) -> None:
        """Send a message that must arrive.

        Parameters
        ----------
        size
            Its size (bytes).
        now
            The time (s).
        """
        self._follow(now)
        line = self._line
        opens = line.reopens(now)
        self._append(item, size, opens, line.draw_retransmissions(), waits=opens > now)

    def send_or_lose(self, item: Item, size: int, now: float) -> bool:
        """Send a message that may be lost; False: it was. The rest is as with `send`."""
        self._follow(now)
        if self._line.loses(now):
            return False
        self._append(item, size, now, 0.0, waits=False)
        return True

    def _append(self, item: Item, size: int, start: float, late: float, *, waits: bool) -> None:
        leaves = self._pass_cap(size, start)
        due = leaves + self._line.draw_delay() + late
        if self._items:
            due = max(due, self._items[-1].due)
        self._items.append(_UnderWay(item, size, leaves, due, waits))
        self.bytes += size

    def _pass_cap(self, size: int, start: float) -> float:
        """Return when (s) a message that can be sent from a time on (s) is past the cap."""
        bandwidth = self._line.fields.bandwidth
        if not bandwidth:
            return start
        self._free = max(start, self._free) + 8.0 * size / bandwidth
        return self._free

    def next_due(self, now: float) -> Optional[float]:
        """Return when (s) the next message arrives; None: nothing is under way."""
        self._follow(now)
        return self._items[0].due if self._items else None

    def take(self, now: float) -> Optional[Item]:
        """Return the next message if it has arrived by a time (s)."""
        due = self.next_due(now)
        if due is None or due > now:
            return None
        first = self._items.popleft()
        self.bytes -= first.size
        return first.item

    def drop(self, unwanted: Callable[[Item], bool]) -> List[Item]:
        """Forget messages under way; return them in order."""
        dropped = [each.item for each in self._items if unwanted(each.item)]
        if dropped:
            self._items = collections.deque(each for each in self._items if not unwanted(each.item))
            self.bytes = sum(each.size for each in self._items)
        return dropped

    def _follow(self, now: float) -> None:
        """Let what is under way follow changes of the line, and of the clock."""
        if now < self._latest - BACKWARDS:
            back = self._latest - now
            for each in self._items:
                each.leaves -= back
                each.due -= back
            self._free -= back
        self._latest = now
        if self._version != self._line.version:
            self._version = self._line.version
            self._retime(now)

    def _retime(self, now: float) -> None:
        """Let what waited for the end of an outage, or for the cap, go by the line's new figures.

        What has left already arrives as it would have, and nothing that waited for the cap later
        than by the old figures: where they change time and again, it would never arrive.
        """
        self._free = min(self._free, now)
        opens = self._line.reopens(now)
        last = -math.inf
        for each in self._items:
            if each.waits or each.due == math.inf:
                each.waits = opens > now
                each.leaves = opens
                each.due = max(last, opens + self._line.draw_delay())
            elif each.leaves > now:
                self._free = each.leaves = min(each.leaves, self._pass_cap(each.size, opens))
                each.due = min(each.due, each.leaves + self._line.draw_delay())
            each.due = last = max(last, each.due)
