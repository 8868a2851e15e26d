"""Messages to one client, under way from the bridge."""

from __future__ import annotations

import asyncio
from typing import Callable, Optional

from ...line.line import Line
from ...line.line_queue import LineQueue
from ...link.waits import DueWait
from ..clients.outbox import Outbox
from ..protocol.compression import Encoded

MOST_BYTES = 8 * 2**20
"""Messages under way (bytes) above which no more is taken out of the outbox, where the newest win.
"""

MOST_QUEUED = 2.0
"""Time (s) of a capped line that may be filled with messages before the others wait in the outbox.
"""


class Downlink:
    """Gives an outbox's messages when they have passed the line; on the loop's thread.

    Parameters
    ----------
    line
        What they pass; None: nothing, as for instructors.
    clock
        Sim time (s).
    """

    def __init__(self, outbox: Outbox, line: Optional[Line], clock: Callable[[], float]) -> None:
        self._outbox = outbox
        self._line = line
        self._clock = clock
        self._wait = DueWait(clock)
        self._taking: Optional[asyncio.Future[Encoded]] = None
        if line is not None:
            self._queue: LineQueue[Encoded] = LineQueue(line)

    async def get(self) -> Encoded:
        """Wait for the next message that has passed, and return it."""
        if self._line is None:
            return await self._outbox.get()
        while True:
            message = await self._take(self._line)
            if message is None:
                arrived = self._queue.take(self._clock())
                if arrived is not None:
                    return arrived
            elif self._queue.passes:
                return message
            else:
                self._queue.send(message, len(message), self._clock())

    async def _take(self, line: Line) -> Optional[Encoded]:
        """Return a message that is to be sent, None when one may have arrived before that."""
        if self._queue.passes and self._taking is None:
            return await self._outbox.get()
        due = self._queue.next_due(self._clock())
        timeout = None if due is None else self._wait.time_until(due)
        if self._taking is None and self._queue.bytes < self._most_bytes(line):
            self._taking = asyncio.ensure_future(self._outbox.get())
        if self._taking is None:
            await asyncio.sleep(timeout or 0.0)
            return None
        await asyncio.wait({self._taking}, timeout=timeout)
        if not self._taking.done():
            return None
        message, self._taking = self._taking.result(), None
        return message

    def _most_bytes(self, line: Line) -> float:
        bandwidth = line.fields.bandwidth
        fits = bandwidth * (MOST_QUEUED + line.fields.delay) / 8.0 if bandwidth else MOST_BYTES
        return min(fits, MOST_BYTES)

    def close(self) -> None:
        """Take nothing more out of the outbox."""
        if self._taking is not None:
            self._taking.cancel()
