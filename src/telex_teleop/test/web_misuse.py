"""Clients that mean it ill: web_misuse.py PORT TOPIC SECONDS.

A process of its own, so that it does not share the interpreter with the server that it attacks.
"""

from __future__ import annotations

import contextlib
import random
import socket
import sys
import time


def misbehave(port, topic, seconds):
    """Up to two hundred connections at a time that send nonsense, stall, or vanish."""
    dice = random.Random(7)
    open_ones, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        for _ in range(20):
            client = socket.create_connection(("127.0.0.1", port))
            client.setblocking(False)
            with contextlib.suppress(OSError):
                client.send(dice.choice(NONSENSE)(dice, topic))
            open_ones.append(client)
        while len(open_ones) > 200:
            open_ones.pop(dice.randrange(len(open_ones))).close()
        time.sleep(0.1)
    for client in open_ones:
        client.close()


def request(target):
    return f"GET /{target} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()


NONSENSE = [
    lambda dice, topic: b"",
    lambda dice, topic: b"GET /str",
    lambda dice, topic: bytes(dice.randrange(256) for _ in range(300)),
    lambda dice, topic: b"GET " + b"/" * 60000 + b" HTTP/1.1\r\n\r\n",
    lambda dice, topic: b"GET / HTTP/1.1\r\nX: " + b"x" * 60000,
    lambda dice, topic: b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 9000,
    lambda dice, topic: b"GET / HTTP/9.9\r\n\r\n",
    lambda dice, topic: b"PUT /stream HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\nx",
    lambda dice, topic: b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzzz\r\n",
    lambda dice, topic: request(f"stream?topic={dice.random()}"),
    lambda dice, topic: request("stream?topic=%00%ff&width=1e9"),
    lambda dice, topic: request("../../etc/passwd") * 50,
    lambda dice, topic: request(f"stream?topic={topic}&quality={dice.randrange(150)}"),
    lambda dice, topic: request(f"snapshot?topic={topic}&width={dice.randrange(900)}"),
    lambda dice, topic: b"GET /video HTTP/1.1\r\nUpgrade: websocket\r\nConnection: upgrade\r\n\r\n",
    lambda dice, topic: WEBSOCKET,
    lambda dice, topic: WEBSOCKET + bytes(dice.randrange(256) for _ in range(300)),
]
WEBSOCKET = (
    b"GET /video HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
)


if __name__ == "__main__":
    misbehave(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]))
