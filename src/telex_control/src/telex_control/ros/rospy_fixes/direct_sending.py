"""Lets rospy's publishers send at once what can be sent at once.

A publisher of rospy with a queue hands each message to a thread of each listener. A clock of 100 Hz
with a dozen listeners wakes a thread more than a thousand times a second, each of which takes the
interpreter away from the loop. A socket nearly always has room for a message, though: then it is
written there and then, without waiting. Only what finds no room is left to the thread.
"""

from __future__ import annotations

import socket
from typing import Any, List, Optional

import rospy.topics
from rospy.impl.tcpros_pubsub import QueuedConnection


def send_directly() -> None:
    """Let publishers send directly whose connections are made in this process from now on."""
    rospy.topics.QueuedConnection = DirectConnection


class DirectConnection(QueuedConnection):
    """A connection to one listener that neither holds its publisher up nor breaks a message off.

    Parameters
    ----------
    queue_size : int
        So many messages wait at most; then the oldest is dropped. 0: all are kept.
    """

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._queue: List[bytes] = []
        self._error: Optional[Exception] = None
        self._thread_sends = False
        self._rest = b""  # of a message whose beginning has been sent
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Send a message, or leave it to the thread where that would have to wait."""
        with self._lock:
            if self._error:
                error, self._error = self._error, None
                raise error
            if not (self._thread_sends or self._queue or self._rest):
                sent = self._send_at_once(data)
                if sent == len(data):
                    return True
                if sent:
                    self._rest = data[sent:]
                    self._cond_data_available.notify()
                    return True
            if 0 < self._queue_size <= len(self._queue):
                del self._queue[0]
            self._queue.append(data)
            self._cond_data_available.notify()
        return True

    def _send_at_once(self, data: bytes) -> int:
        """Return how many bytes were sent; the thread will meet an error, too, and tell of it."""
        transport = self._connection
        try:
            sent = transport.socket.send(data, socket.MSG_DONTWAIT)
        except (OSError, AttributeError):  # closed: no socket any more
            return 0
        transport.stat_bytes += sent
        transport.stat_num_msg += sent == len(data)
        return sent

    def _run(self) -> None:
        while not self._connection.done:
            for data in self._take():
                try:
                    self._connection.write_data(data)
                except Exception as error:  # the publisher's next message raises it
                    with self._lock:
                        self._error = error

    def _take(self) -> List[bytes]:
        """Wait for what is to be sent, and return it."""
        with self._lock:
            self._thread_sends = False
            while not (self._rest or self._queue or self._connection.done):
                self._cond_data_available.wait()
            taken = [*filter(None, [self._rest]), *self._queue]
            self._rest, self._queue = b"", []
            self._thread_sends = True
        return taken
