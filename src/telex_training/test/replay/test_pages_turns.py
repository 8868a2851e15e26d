"""Pictures of replays are drawn one at a time, and for nobody who has gone."""

from __future__ import annotations

import socket
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from waiting import wait_until

from telex_training.ros.replay.pages import ReplayPages

REPLAY = SimpleNamespace(
    camera_names=[], timeline=SimpleNamespace(moment=lambda time: SimpleNamespace(time=time))
)
LEFT = 40
"""Clients that go: more than a process has threads for work aside."""
HUNG = 60.0  # s


class Drawing:
    """Draws nothing, and waits to be let on."""

    def __init__(self):
        self.begun = []
        self.goes_on = threading.Event()

    def picture(self, replay, drawn, name, view, spacing, ghost):
        self.begun.append(drawn.time)
        assert self.goes_on.wait(HUNG)
        return b"\xff\xd8"


@pytest.fixture
def pages():
    shelf = SimpleNamespace(
        given="", permitted=lambda *who: SimpleNamespace(replay=REPLAY, problems=[])
    )
    drawing = Drawing()
    made = ReplayPages(shelf, None, drawing, Path(), 0, lambda: False, 0.0)
    made.start()
    yield made._address, drawing
    drawing.goes_on.set()
    made.close()


def asked(address, when):
    """A connection that has asked for a picture."""
    there = urlsplit(address)
    connection = socket.create_connection((there.hostname, there.port), HUNG)
    connection.sendall(
        f"GET /replay/api/picture/t?time={when} HTTP/1.1\r\nHost: x\r\n\r\n".encode()
    )
    return connection


def test_who_has_gone_is_not_drawn_for(pages):
    address, drawing = pages
    first = asked(address, 1)
    wait_until(lambda: drawing.begun, timeout=HUNG)
    gone = [asked(address, 2) for _ in range(LEFT)]
    time.sleep(0.3)
    for connection in gone:
        connection.close()
    # What takes no turn is answered meanwhile.
    with pytest.raises(OSError, match="404"):
        urlopen(f"{address}/replay/", timeout=HUNG)
    drawing.goes_on.set()
    assert b"200 OK" in first.recv(4096)
    with asked(address, 3) as last:
        assert b"200 OK" in last.recv(4096)
    assert drawing.begun == [1.0, 3.0]
    first.close()
