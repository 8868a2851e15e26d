"""Messages that wait for one client; what does not fit any more is dropped, oldest first."""

from __future__ import annotations

import asyncio
import collections
from typing import Deque, Dict, Optional

from ..protocol.compression import Encoded


class OutboxFullError(Exception):
    """The client takes no replies; nothing can be dropped, so it has to go."""


class _Entry:
    """One message; `text` becomes None when it is dropped, and its place is then skipped."""

    __slots__ = ("text", "topic")

    def __init__(self, topic: Optional[str], text: Encoded) -> None:
        self.topic = topic
        self.text: Optional[Encoded] = text


class Outbox:
    """Queue of outgoing messages of one client, on the loop's thread.

    Messages of a topic wait in bounded number, and the newest win. Replies are never dropped. All
    together is bounded, too.

    Parameters
    ----------
    max_bytes
        Bound of all that waits (characters, which are bytes as JSON is sent here).
    max_replies
        Bound of replies that wait.
    """

    def __init__(self, max_bytes: int, max_replies: int = 1000) -> None:
        self._max_bytes = max_bytes
        self._max_replies = max_replies
        self._queue: Deque[_Entry] = collections.deque()
        self._topics: Dict[str, Deque[_Entry]] = {}
        self._bytes = 0
        self._replies = 0
        self._filled = asyncio.Event()
        self._emptier = asyncio.Event()

    def __len__(self) -> int:
        return self._replies + sum(len(entries) for entries in self._topics.values())

    def put_message(self, topic: str, text: Encoded, depth: int) -> None:
        """Queue a message of a topic, of which at most `depth` may wait."""
        entry = self._append(topic, text)
        waiting = self._topics.setdefault(topic, collections.deque())
        waiting.append(entry)
        while len(waiting) > depth:
            self._drop(waiting)
        self._make_room()

    def put_reply(self, text: str) -> None:
        """Queue a reply, which is not dropped.

        Raises
        ------
        OutboxFullError
            The client has not taken its earlier replies.
        """
        self._append(None, text)
        self._replies += 1
        self._make_room()
        too_large = self._bytes > self._max_bytes and self._replies > 1
        if self._replies > self._max_replies or too_large:
            raise OutboxFullError(f"{self._replies} replies wait to be taken")

    async def get(self) -> Encoded:
        """Wait for the next message and return it."""
        while True:
            while self._queue:
                entry = self._queue.popleft()
                if entry.text is not None:
                    self._forget(entry)
                    return entry.text
            self._filled.clear()
            await self._filled.wait()

    async def room(self) -> None:
        """Wait until less than half of the replies wait that may."""
        while 2 * self._replies >= self._max_replies:
            self._emptier.clear()
            await self._emptier.wait()

    def _append(self, topic: Optional[str], text: Encoded) -> _Entry:
        entry = _Entry(topic, text)
        self._queue.append(entry)
        self._bytes += len(text)
        self._filled.set()
        return entry

    def _forget(self, entry: _Entry) -> None:
        """Take an entry that leaves the queue out of the books."""
        self._bytes -= len(entry.text or "")
        if entry.topic is None:
            self._replies -= 1
            self._emptier.set()
            return
        waiting = self._topics[entry.topic]
        waiting.popleft()
        if not waiting:
            del self._topics[entry.topic]

    def _drop(self, waiting: Deque[_Entry]) -> None:
        """Drop the oldest message of a topic."""
        entry = waiting.popleft()
        self._bytes -= len(entry.text or "")
        entry.text = None

    def _make_room(self) -> None:
        """Drop messages, oldest first, until the bound is kept; a message alone may exceed it."""
        kept: Deque[_Entry] = collections.deque()
        while self._bytes > self._max_bytes and len(self._queue) > 1:
            entry = self._queue.popleft()
            if entry.topic is None and entry.text is not None:
                kept.append(entry)
            elif entry.text is not None:
                self._forget(entry)
        self._queue.extendleft(reversed(kept))
