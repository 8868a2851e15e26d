"""A viewer of the front camera, for benchmarks."""

from __future__ import annotations

import threading
import urllib.request

_TOPIC = "/telex/cameras/front/image_raw"


class StreamReader:
    """Reads the front camera's MJPEG stream, as an operator's browser does, and counts frames."""

    def __init__(self, url: str) -> None:
        self.frames = 0
        self._ended = False
        self._answer = urllib.request.urlopen(f"{url}/stream?topic={_TOPIC}", timeout=30.0)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while not self._ended:
            line = self._answer.readline()
            if not line:
                return
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
                while self._answer.readline().strip():
                    pass
                self._answer.read(length)
                self.frames += 1

    def close(self) -> None:
        """Stop reading."""
        self._ended = True
