"""A viewer of the front camera, for benchmarks."""

from __future__ import annotations

import threading
import time
import urllib.request
from http.client import HTTPResponse
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


class StreamReader:
    """Reads a camera's MJPEG stream, as an operator's browser does, and counts frames."""

    def __init__(self, url: str, topic: str = _TOPIC) -> None:
        self.frames = 0
        self._ended = False
        self._answer = open_stream(url, topic)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while not self._ended:
            line = self._answer.readline()
            if not line:
                break
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
                while self._answer.readline().strip():
                    pass
                self._answer.read(length)
                self.frames += 1
        self._answer.close()

    def close(self) -> None:
        """Stop reading."""
        self._ended = True
