"""The one ordered inbox: what arrives gets a number, is recorded, and is judged in that order."""

from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Optional

from ..judging.entries import Entry
from .writer import RecordingWriter

Judge = Callable[[Entry], None]
"""Takes entries in their order, in the inbox's thread."""


class Inbox:
    """Numbers what arrives, from any thread, and hands it on in that order.

    Parameters
    ----------
    writer : RecordingWriter, optional
        Records each entry, too.
    """

    def __init__(self, judge: Judge, writer: Optional[RecordingWriter] = None) -> None:
        self._judge = judge
        self._writer = writer
        self._lock = threading.Lock()
        self._number = 0
        self._closed = False
        self._entries: queue.SimpleQueue[Optional[Entry]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="inbox", daemon=True)
        self._thread.start()

    def put(self, channel: str, kind: str, data: bytes, time_ns: int) -> None:
        """Take a message in; never waits. After `close` it is dropped.

        Parameters
        ----------
        channel : str
            Name of its topic in the robot's namespace.
        kind : str
            Its type.
        data : bytes
            As it is serialised.
        time_ns : int
            Sim time of its arrival.
        """
        wall_ns = time.time_ns()
        # Number, record and judgement have one order, whoever comes from which thread.
        with self._lock:
            if self._closed:
                return
            # As it is read back from the recording's nanoseconds.
            entry = Entry(self._number, time_ns / 1e9, channel, kind, data)
            self._number += 1
            if self._writer is not None:
                self._writer.put(entry, wall_ns)
            self._entries.put(entry)

    def close(self) -> None:
        """Take nothing more in, and return once all is judged."""
        with self._lock:
            self._closed = True
            self._entries.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        while True:
            entry = self._entries.get()
            if entry is None:
                return
            self._judge(entry)
