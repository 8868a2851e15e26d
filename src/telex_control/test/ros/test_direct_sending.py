"""What a publisher sends directly arrives whole and in order, and never holds it up."""

from __future__ import annotations

import socket
import threading
from types import SimpleNamespace

import pytest

from telex_control.ros.rospy_fixes.direct_sending import DirectConnection

SMALL = b"small message "
LARGE = bytes(range(256)) * 40_000  # more than both sockets' buffers hold


class Transport:
    """What the class needs of rospy's TCPROSTransport."""

    def __init__(self, own):
        self.socket = own
        self.done = False
        self.stat_bytes = self.stat_num_msg = 0
        self.threads = []

    def set_cleanup_callback(self, callback):
        self.close = lambda: (setattr(self, "done", True), callback(self))

    def write_data(self, data):
        self.threads.append(threading.current_thread())
        self.socket.sendall(data)


@pytest.fixture
def ends():
    own, other = socket.socketpair()
    own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 65536)
    other.settimeout(60.0)
    transport = Transport(own)
    made = SimpleNamespace(transport=transport, other=other, connections=[])

    def connect(queue_size):
        made.connections.append(DirectConnection(transport, queue_size))
        return made.connections[-1]

    made.connect = connect
    yield made
    transport.close()
    other.close()
    own.close()
    for connection in made.connections:
        connection._thread.join(60.0)
        assert not connection._thread.is_alive()


def read(other, size):
    parts = []
    while size:
        parts.append(other.recv(min(size, 1 << 20)))
        assert parts[-1], "closed"
        size -= len(parts[-1])
    return b"".join(parts)


def test_a_message_that_finds_room_is_sent_by_its_publisher(ends):
    connection = ends.connect(queue_size=1)
    for _ in range(3):
        assert connection.write_data(SMALL)
    assert read(ends.other, 3 * len(SMALL)) == 3 * SMALL
    assert not ends.transport.threads
    assert ends.transport.stat_num_msg == 3


def test_what_finds_no_room_waits_without_its_publisher(ends):
    connection = ends.connect(queue_size=0)
    for message in (LARGE, SMALL, LARGE, SMALL):
        connection.write_data(message)  # nobody reads: this would never come back if it waited
    assert read(ends.other, 2 * len(LARGE + SMALL)) == 2 * (LARGE + SMALL)


def test_the_oldest_message_is_dropped_but_never_a_part_of_one(ends):
    connection = ends.connect(queue_size=1)
    connection.write_data(LARGE)
    for number in range(100):
        connection.write_data(b"%014d" % number)
    assert read(ends.other, len(LARGE)) == LARGE
    numbers = [int(read(ends.other, 14))]
    while numbers[-1] != 99:
        numbers.append(int(read(ends.other, 14)))
    assert numbers == sorted(numbers)
    assert len(numbers) <= 3  # the thread may have taken one before, and the next one waits


def test_an_error_is_told_to_the_publisher(ends):
    connection = ends.connect(queue_size=1)
    ends.other.close()
    with pytest.raises(OSError):  # noqa: PT012
        while True:
            connection.write_data(SMALL)
