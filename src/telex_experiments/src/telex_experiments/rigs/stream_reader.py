"""A viewer of the front camera, for benchmarks."""

from __future__ import annotations

import threading
import time
import urllib.request
from http.client import HTTPResponse
from typing import Iterator, List, Tuple
from urllib.error import HTTPError

_TOPIC = "/telex/cameras/front/image_raw"
_PATIENCE = 120.0
"""Longest wait (s) for the cameras to advertise, on a machine that is busy with something else."""


def open_stream(url: str, topic: str = _TOPIC) -> HTTPResponse:
    """Ask the video server for an MJPEG stream, again and again until the server knows of it."""
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            answer: HTTPResponse = urllib.request.urlopen(
                f"{url}/stream?topic={topic}", timeout=_PATIENCE
            )
            return answer
        except HTTPError as error:
            error.close()
            if error.code != 404 or time.monotonic() > end:
                raise
        time.sleep(0.1)


def pictures(answer: HTTPResponse) -> Iterator[Tuple[float, bytes]]:
    """Yield stamp (s) and JPEG of each picture of an MJPEG stream, until it ends."""
    stamp, length = 0.0, 0
    for line in iter(answer.readline, b""):
        name, _, value = line.lower().partition(b":")
        if name == b"x-timestamp":
            stamp = float(value)
        elif name == b"content-length":
            length = int(value)
        elif length and not line.strip():
            yield stamp, answer.read(length)
            length = 0


class StreamReader:
    """Reads a camera's MJPEG stream, as an operator's browser does.

    Attributes
    ----------
    arrivals : list of (float, float)
        Stamp of each picture, and the monotonic time at which it came (s).
    """

    def __init__(self, url: str, topic: str = _TOPIC) -> None:
        self.arrivals: List[Tuple[float, float]] = []
        self._ended = False
        self._answer = open_stream(url, topic)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for stamp, _ in pictures(self._answer):
            self.arrivals.append((stamp, time.monotonic()))
            if self._ended:
                break
        self._answer.close()

    @property
    def frames(self) -> int:
        """How many pictures have come."""
        return len(self.arrivals)

    def close(self) -> None:
        """Stop reading."""
        self._ended = True
