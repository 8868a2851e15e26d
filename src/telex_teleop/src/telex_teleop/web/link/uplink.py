"""Messages of one client, under way to a server."""

from __future__ import annotations

import asyncio
from typing import Callable, Optional

from ..line.line import Line
from ..line.line_queue import LineQueue
from .waits import LinePump

MOST_BYTES = 4 * 2**20
"""Messages under way (bytes) above which no more of the client's are read."""


class Sent:
    """One message under way, or the client's end.

    Parameters
    ----------
    arrive
        Called when it has passed the line.
    lost
        Called with the reason instead if it is called back; None: it is not, whatever happens.
    releases
        Whether it releases the emergency stop.
    """

    __slots__ = ("arrive", "lost", "releases")

    def __init__(
        self,
        arrive: Callable[[], None],
        lost: Optional[Callable[[str], None]] = None,
        releases: bool = False,
    ) -> None:
        self.arrive = arrive
        self.lost = lost
        self.releases = releases


class Uplink:
    """First in, first out, stops and the client's end included; on the loop's thread.

    A stop that overtook the commands before it would leave the robot moving for longer.

    Parameters
    ----------
    line
        What it passes; None: nothing, as for instructors.
    clock
        Sim time (s).
    """

    def __init__(self, line: Optional[Line], clock: Callable[[], float]) -> None:
        self._line = line
        self._clock = clock
        self._emptier = asyncio.Event()
        if line is not None:
            self._queue: LineQueue[Sent] = LineQueue(line)
            self._pump = LinePump(clock, self._release)

    @property
    def passes(self) -> bool:
        """Whether messages arrive at once, so that they need not be sent by this."""
        return self._line is None or self._queue.passes

    def send(self, sent: Sent, size: int, *, may_be_lost: bool = False) -> bool:
        """Send a message of a size (bytes); False: it got lost, as far as it may be."""
        now = self._clock()
        if may_be_lost:
            kept = self._queue.send_or_lose(sent, size, now)
        else:
            self._queue.send(sent, size, now)
            kept = True
        self._pump.run()
        return kept

    def call_back(self, reason: str, releases: bool) -> None:
        """Lose the commands under way; what else the client has sent goes on.

        Parameters
        ----------
        releases
            Whether releases of the emergency stop are lost as well.
        """
        if self._line is None:
            return
        for sent in self._queue.drop(
            lambda each: each.lost is not None and (releases or not each.releases)
        ):
            assert sent.lost is not None
            sent.lost(reason)
        self._emptier.set()

    async def room(self) -> None:
        """Wait until less is under way than may be."""
        while self._line is not None and self._queue.bytes > MOST_BYTES:
            self._emptier.clear()
            await self._emptier.wait()

    def close(self) -> None:
        """Forget all that is under way."""
        if self._line is not None:
            self._queue.drop(lambda _: True)
            self._pump.close()
            self._emptier.set()

    def _release(self, now: float) -> Optional[float]:
        while True:
            sent = self._queue.take(now)
            if sent is None:
                return self._queue.next_due(now)
            self._emptier.set()
            sent.arrive()
