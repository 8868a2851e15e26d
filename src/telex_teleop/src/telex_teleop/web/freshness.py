"""Data that was sent to a client and has not arrived yet.

A server that only watches its own buffer still feeds a slow client with old data, because the
kernel's send buffer holds seconds of video. Linux tells how many bytes of a socket are not
acknowledged (TIOCOUTQ); whoever sends nothing new until that is small keeps the client at most a
round trip behind.
"""

from __future__ import annotations

import asyncio
import fcntl
import socket
import struct
import termios
from typing import Optional


def unacknowledged_bytes(sock: socket.socket) -> int:
    """Return the bytes in the kernel's send buffer that the peer has not acknowledged.

    Zero where the system cannot tell (no Linux, closed socket).
    """
    try:
        answer = fcntl.ioctl(sock.fileno(), termios.TIOCOUTQ, b"\0" * 4)
    except (OSError, ValueError):
        return 0
    return int(struct.unpack("i", answer)[0])


class Backlog:
    """The bytes under way to one client, and whether they move.

    Parameters
    ----------
    send_buffer
        Size asked for the kernel's send buffer (bytes).
    """

    def __init__(self, transport: asyncio.Transport, send_buffer: int) -> None:
        self._transport = transport
        self._socket: Optional[socket.socket] = transport.get_extra_info("socket")
        self._last_bytes = 0
        self._last_progress: Optional[float] = None
        if self._socket is not None:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, send_buffer)

    def buffered(self) -> int:
        """Return the bytes that wait in this process."""
        return self._transport.get_write_buffer_size()

    def in_flight(self) -> int:
        """Return the bytes that the kernel holds for the client."""
        return unacknowledged_bytes(self._socket) if self._socket is not None else 0

    def clear(self, max_in_flight: int) -> bool:
        """Tell whether new data would reach the client without waiting behind old data."""
        return self.buffered() == 0 and self.in_flight() <= max_in_flight

    def stalled_for(self, now: float) -> float:
        """Return for how long (s) bytes have been waiting without any progress.

        Parameters
        ----------
        now
            Monotonic time (s); call this regularly, since progress is seen from one call to the
            next.
        """
        waiting = self.buffered() + self.in_flight()
        if waiting == 0 or waiting != self._last_bytes or self._last_progress is None:
            self._last_progress = now
        self._last_bytes = waiting
        return now - self._last_progress
