"""Clients of a picture topic: those who watch a stream, and those who want one picture."""

from __future__ import annotations

import asyncio
import time
from typing import Hashable, Optional, Protocol

from aiohttp import web

from ..freshness import Backlog
from ..tokens import is_loopback
from .mjpeg import STREAM_HEAD
from .pictures import EncodedPicture


def client_of(request: web.Request, connection: Hashable = None) -> Hashable:
    """Return whose share of the encoder's time a request takes.

    That is the address from which it comes. The addresses of this machine tell less, for tunnels
    end there, too: there each connection that is named counts by itself, and all other requests of
    an address together.
    """
    address = request.remote or ""
    return (address, connection) if is_loopback(address) else address


class Viewer(Protocol):
    """Somebody to whom a hub offers every new picture; all calls come on the loop's thread."""

    @property
    def client(self) -> Hashable:
        """Whose share of the encoder's time its pictures take; see `client_of`."""

    def wants(self) -> bool:
        """Tell whether a picture would be taken now; one that nobody takes is not encoded."""

    def offer(self, picture: EncodedPicture) -> None:
        """Take or skip a new picture."""

    def check(self, now: float) -> None:
        """Called about once a second with the monotonic time (s)."""

    def close(self) -> None:
        """End: no more pictures will come."""


class StreamViewer:
    """Client of an MJPEG stream, who gets the newest picture or nothing.

    A picture goes out only when the ones before it have arrived, so that a slow client skips
    pictures instead of falling behind. One that has taken nothing for `stall_timeout` is dropped.

    Parameters
    ----------
    transport
        Connection to the client; its HTTP request has been read.
    client
        Whose share of the encoder's time its pictures take.
    send_buffer
        Size of the kernel's send buffer (bytes).
    max_in_flight
        Bytes that may still be under way when the next picture goes out; above 0 it trades
        freshness for frame rate on links with a long round trip.
    stall_timeout
        Time (s) without progress after which the client counts as gone.
    """

    def __init__(
        self,
        transport: asyncio.Transport,
        client: Hashable,
        *,
        send_buffer: int,
        max_in_flight: int,
        stall_timeout: float,
    ) -> None:
        self.client = client
        self._transport = transport
        self._backlog = Backlog(transport, send_buffer)
        self._max_in_flight = max_in_flight
        self._stall_timeout = stall_timeout
        self._newest: Optional[EncodedPicture] = None
        self._sent: Optional[float] = None

    def start(self) -> None:
        """Send the head of the reply."""
        self._transport.write(STREAM_HEAD)

    def wants(self) -> bool:
        """Tell whether a picture would arrive without delay."""
        if self._transport.is_closing():
            return False
        # The head may still be unacknowledged when the first picture comes; that must not cost
        # the picture.
        return self._sent is None or self._backlog.clear(self._max_in_flight)

    def offer(self, picture: EncodedPicture) -> None:
        """Send the picture if it would arrive without delay."""
        self._newest = picture
        if self.wants():
            self._send(picture)

    def repeat(self, period: float) -> None:
        """Send the last picture again if nothing has been sent for a period (s)."""
        idle = self._sent is None or time.monotonic() - self._sent >= period
        if self._newest is not None and idle and self.wants():
            self._send(self._newest)

    def _send(self, picture: EncodedPicture) -> None:
        self._sent = time.monotonic()
        self._transport.write(picture.part)

    def check(self, now: float) -> None:
        """Drop the client if it has stopped reading."""
        if self._backlog.stalled_for(now) > self._stall_timeout:
            self.close()

    def close(self) -> None:
        """Cut the connection at once, with whatever is still in its buffers."""
        self._transport.abort()


class SnapshotViewer:
    """Client who wants the next picture only.

    Parameters
    ----------
    client
        Whose share of the encoder's time it takes.
    """

    def __init__(self, client: Hashable) -> None:
        self.client = client
        self.picture: asyncio.Future[EncodedPicture] = asyncio.get_running_loop().create_future()

    def wants(self) -> bool:
        """Tell whether the picture has not come yet."""
        return not self.picture.done()

    def offer(self, picture: EncodedPicture) -> None:
        """Take the first picture that comes."""
        if not self.picture.done():
            self.picture.set_result(picture)

    def check(self, now: float) -> None:
        """Nothing to do: whoever waits has a time limit."""

    def close(self) -> None:
        """Tell whoever waits that no picture will come."""
        if not self.picture.done():
            self.picture.cancel()
