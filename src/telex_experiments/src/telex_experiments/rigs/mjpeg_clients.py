"""Many viewers of an MJPEG stream in one loop, each of which notes when every picture came."""

from __future__ import annotations

import asyncio
import re
import socket
import time
from typing import List, Optional, Tuple
from urllib.parse import urlsplit

_STAMP = re.compile(rb"X-Timestamp: ([0-9.]+)")
_LENGTH = re.compile(rb"Content-Length: ([0-9]+)")


class MjpegClient(asyncio.BufferedProtocol):
    """One viewer; as lean as can be, for a dozen of them share the machine with the server.

    Parameters
    ----------
    url : str
        Of the stream.
    receive_buffer : int, optional
        Bytes of the kernel's receive buffer; without it, the kernel lets it grow.

    Attributes
    ----------
    arrivals : list of (float, float)
        Wall time at which each picture was complete, and its X-Timestamp (s).
    """

    def __init__(self, url: str, receive_buffer: Optional[int] = None) -> None:
        self._url = urlsplit(url)
        self._receive_buffer = receive_buffer
        self._bytes = bytearray(2**19)
        self._filled = 0
        self._wanted = 0
        self._stamp: Optional[float] = None
        self._transport: Optional[asyncio.Transport] = None
        self.arrivals: List[Tuple[float, float]] = []

    async def connect(self) -> None:
        """Ask for the stream."""
        own = socket.socket()
        if self._receive_buffer is not None:
            own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, self._receive_buffer)
        own.setblocking(False)
        loop = asyncio.get_running_loop()
        await loop.sock_connect(own, (self._url.hostname, self._url.port))
        self._transport, _ = await loop.create_connection(lambda: self, sock=own)
        self._transport.write(f"GET {self._url.path}?{self._url.query} HTTP/1.0\r\n\r\n".encode())

    def stop_reading(self) -> None:
        """Leave everything that comes to the kernel."""
        self._transport.pause_reading()

    def read_on(self) -> None:
        """Read again; what has come before counts no more."""
        self.arrivals.clear()
        self._transport.resume_reading()

    def close(self) -> None:
        """Go away."""
        self._transport.abort()

    def get_buffer(self, sizehint: int) -> memoryview:
        """Return where the next bytes go."""
        return memoryview(self._bytes)[self._filled :]

    def buffer_updated(self, nbytes: int) -> None:
        """Take note of the pictures that are complete now."""
        self._filled += nbytes
        while self._wanted <= self._filled and self._next_part():
            pass

    def _next_part(self) -> bool:
        """Pass the picture that is complete, and read the head of the next one, if it is there."""
        if self._stamp is not None:
            self.arrivals.append((time.time(), self._stamp))
            rest = self._filled - self._wanted
            self._bytes[:rest] = self._bytes[self._wanted : self._filled]
            self._filled, self._wanted, self._stamp = rest, 0, None
        end = self._bytes.find(b"\r\n\r\n", self._wanted, self._filled)
        if end < 0:
            return False
        head = bytes(self._bytes[:end])
        length = _LENGTH.search(head)
        if length is None:  # the head of the whole reply
            self._wanted = end + 4
            return True
        self._stamp = float(_STAMP.search(head)[1])
        self._wanted = end + 4 + int(length[1])
        return True


def latencies(clients: List[MjpegClient], since: float) -> List[float]:
    """Return the time (s) from stamp to client of all pictures since a wall time, sorted."""
    return sorted(
        arrival - stamp for each in clients for arrival, stamp in each.arrivals if arrival >= since
    )
