"""Writes a recording as it is made, in a thread of its own.

Whoever records waits for no disk: what arrives is queued, and the thread writes it, and has the
system write it to the disk once a second. A process that is killed, or a file that is cut off where
it was last on the disk, loses the last chunk at most.
"""

from __future__ import annotations

import contextlib
import os
import queue
import threading
import time
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional

import genpy.message
from mcap.writer import CompressionType, IndexType, Writer

from ..judging.entries import Entry
from .digest import EntriesDigest

PROFILE = "ros1"
CHUNK = 16 * 1024
"""Bytes of a chunk before compression: what a cut-off file loses at most, and a second of truth."""
SYNC_PERIOD = 1.0
"""Wall time between two times that all is on the disk (s)."""
LEAST_FREE = 200 * 2**20
"""Bytes that have to be free before a recording begins: some hours of it."""
_CLOSING = 30.0


class RecordingError(RuntimeError):
    """A recording cannot be written or read; the message names the file and says why."""


class Attachment(NamedTuple):
    """A file inside a recording."""

    media_type: str
    data: bytes


Seal = Callable[[Mapping[str, Any], Mapping[str, Attachment]], Mapping[str, Attachment]]
"""Makes further attachments, such as a signature, of what `EntriesDigest` says of all entries and
of all attachments before them; called in the recording's thread."""


class _Queued(NamedTuple):
    entry: Entry
    wall_ns: int


def check_room(folder: Path, least: int = LEAST_FREE) -> None:
    """Refuse to begin a recording where there is no room for it.

    Raises
    ------
    RecordingError
        The folder cannot be made or written, or has less than `least` bytes free.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        status = os.statvfs(folder)
    except OSError as error:
        raise RecordingError(f"{folder}: {error.strerror}") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RecordingError(f"{folder}: it cannot be written; see its owner and rights")
    free = status.f_bavail * status.f_frsize
    if free < least:
        raise RecordingError(
            f"{folder}: {free / 2**20:.0f} MB are free; at least {least / 2**20:.0f} MB are needed"
        )


class RecordingWriter:
    """Writes one recording.

    Parameters
    ----------
    path : Path
        A new file.
    attachments : mapping of str to Attachment
        By their names: what the recording is of. They come first, so that a file that is cut off
        has them.
    sync_period : float
        See `SYNC_PERIOD`.

    Raises
    ------
    RecordingError
        The file cannot be made.
    """

    def __init__(
        self, path: Path, attachments: Mapping[str, Attachment], sync_period: float = SYNC_PERIOD
    ) -> None:
        self.path = path
        self._sync_period = sync_period
        self._problem = ""
        self._ended = False
        self._beginning = dict(attachments)
        self._ending: Dict[str, Attachment] = {}
        self._seal: Optional[Seal] = None
        self._digest = EntriesDigest()
        self._queue: queue.SimpleQueue[Optional[_Queued]] = queue.SimpleQueue()
        self._channels: Dict[str, int] = {}
        self._schemas: Dict[str, int] = {}
        try:
            self._file = path.open("xb")
        except OSError as error:
            raise RecordingError(f"{path}: {error.strerror}") from error
        try:
            self._writer = Writer(
                self._file,
                chunk_size=CHUNK,
                compression=CompressionType.ZSTD,
                # An index of each message would be a fifth of the file; chunks are small.
                index_types=IndexType.ALL & ~IndexType.MESSAGE,
            )
            self._writer.start(PROFILE, "telex_training")
            self._attach(attachments)
            self._sync()
        except OSError as error:
            with contextlib.suppress(OSError):
                self._file.close()
            path.unlink()
            raise RecordingError(f"{path}: {error.strerror}") from error
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    @property
    def problem(self) -> str:
        """Why nothing more is written, such as a full disk; empty: all is well."""
        return self._problem

    @property
    def waiting(self) -> int:
        """Entries that are not written yet."""
        return self._queue.qsize()

    def put(self, entry: Entry, wall_ns: int) -> None:
        """Have an entry written, at the wall time of its arrival (ns); never waits."""
        self._queue.put(_Queued(entry, wall_ns))

    def close(self, attachments: Mapping[str, Attachment], seal: Optional[Seal] = None) -> None:
        """Write what waits, then these attachments, and complete the file.

        Parameters
        ----------
        seal : callable, optional
            Makes the last ones.

        Raises
        ------
        RecordingError
            It could not be written to its end.
        """
        self._ending, self._seal = dict(attachments), seal
        self._queue.put(None)
        self._thread.join(_CLOSING)
        if self._thread.is_alive():
            raise RecordingError(f"{self.path}: the disk has not answered for {_CLOSING:.0f} s")
        if self._problem:
            raise RecordingError(f"{self.path}: {self._problem}")

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._write_all()
            self._attach(self._ending)
            if self._seal is not None:
                attached = {**self._beginning, **self._ending}
                self._attach(self._seal(self._digest.state(), attached))
            self._writer.finish()
            self._sync()
        except Exception as error:  # whatever ends it has to be told
            self._problem = _reason(error)
            # What still comes is taken from the queue, so that it does not grow for ever.
            while not self._ended:
                self._ended = self._queue.get() is None
        finally:
            try:
                self._file.close()
            except OSError as error:
                self._problem = self._problem or _reason(error)

    def _write_all(self) -> None:
        sync_at = time.monotonic() + self._sync_period
        while True:
            try:
                queued = self._queue.get(timeout=max(0.0, sync_at - time.monotonic()))
            except queue.Empty:
                queued = None
                ended = False
            else:
                ended = queued is None
            if queued is not None:
                self._write(queued)
                if self._queue.empty():
                    # To the system: what it has, the end of this process does not lose.
                    self._file.flush()
            if ended:
                self._ended = True
                return
            if time.monotonic() >= sync_at:
                self._sync()
                sync_at = time.monotonic() + self._sync_period

    def _write(self, queued: _Queued) -> None:
        entry = queued.entry
        self._writer.add_message(
            self._channel(entry),
            log_time=round(entry.time * 1e9),
            data=entry.data,
            publish_time=queued.wall_ns,
            sequence=entry.number,
        )
        self._digest.add(entry, queued.wall_ns)

    def _channel(self, entry: Entry) -> int:
        known = self._channels.get(entry.channel)
        if known is None:
            known = self._writer.register_channel(entry.channel, "ros1", self._schema(entry.kind))
            self._channels[entry.channel] = known
        return known

    def _schema(self, kind: str) -> int:
        known = self._schemas.get(kind)
        if known is None:
            found = genpy.message.get_message_class(kind)
            text = found._full_text if found is not None else ""
            known = self._writer.register_schema(kind, "ros1msg", text.encode())
            self._schemas[kind] = known
        return known

    def _attach(self, attachments: Mapping[str, Attachment]) -> None:
        now = time.time_ns()
        for name, attachment in attachments.items():
            self._writer.add_attachment(now, now, name, attachment.media_type, attachment.data)

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())


def _reason(error: Exception) -> str:
    """Why something failed, in words."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
