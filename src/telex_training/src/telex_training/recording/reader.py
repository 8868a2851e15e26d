"""Reads recordings, whole ones and those that were cut off."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Dict, Iterator, List

from mcap.records import Attachment as AttachmentRecord
from mcap.records import Channel, Chunk, Footer, Header, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from ..judging.entries import Entry
from .writer import PROFILE, Attachment, RecordingError, RecordingWriter

MOST_BYTES = 4 * 2**30
"""Size of a recording that is read; four days of training are shorter."""
MOST_UNPACKED = 4 * 2**30
"""Bytes of all entries of a recording, once they are unpacked."""
BEING_WRITTEN = 60.0
"""A file that is not closed, and changed within this time, is a trial that runs (s)."""
_TIMES_END = 2**63
"""Of the times of entries (ns): those beyond it are no times, and no float has each of them."""
_MOST_RECORD = 64 * 2**20
"""Bytes of a record, and of a chunk once it is unpacked."""


@dataclass(frozen=True)
class Recording:
    """A recording as it was read.

    Attributes
    ----------
    entries : list of Entry
        In the order of their arrival.
    walls : list of int
        Wall time of each arrival (ns since the epoch).
    whole : bool
        Whether it was closed; otherwise it was cut off, and what is here is what is left.
    repeated : list of str
        Attachments of which there are several, the last of which is here; no writer makes these.
    """

    path: Path
    entries: List[Entry] = field(default_factory=list)
    walls: List[int] = field(default_factory=list)
    attachments: Dict[str, Attachment] = field(default_factory=dict)
    whole: bool = False
    repeated: List[str] = field(default_factory=list)


def read_recording(path: Path) -> Recording:
    """Read a recording, as far as it can be read.

    Raises
    ------
    RecordingError
        It is no recording, or too large, or cannot be read at all.
    """
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise RecordingError(f"{path}: it has {size} bytes; at most {MOST_BYTES} are read")
        with path.open("rb") as file:
            return _read(path, file)
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error


def _read(path: Path, file: BinaryIO) -> Recording:
    kinds: Dict[int, str] = {}
    channels: Dict[int, Channel] = {}
    entries: List[Entry] = []
    walls: List[int] = []
    attachments: Dict[str, Attachment] = {}
    repeated: List[str] = []
    began = whole = False
    unpacked = 0
    records = _records(file)
    while True:
        try:
            record = next(records)
        except StopIteration:
            break
        except Exception as error:
            # Bytes that are damaged, or end too early, raise whatever they lead the reader to.
            if not began:
                raise RecordingError(f"{path}: it is no recording ({error})") from error
            break
        if isinstance(record, Header):
            if record.profile != PROFILE:
                raise RecordingError(
                    f"{path}: its profile is '{record.profile}'; '{PROFILE}' is needed"
                )
            began = True
        elif isinstance(record, Schema):
            kinds[record.id] = record.name
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            channel = channels.get(record.channel_id)
            if channel is None or channel.schema_id not in kinds or record.log_time >= _TIMES_END:
                break
            kind = kinds[channel.schema_id]
            unpacked += len(record.data)
            if unpacked > MOST_UNPACKED:
                raise RecordingError(
                    f"{path}: its entries have more than the {MOST_UNPACKED} bytes that are read"
                )
            at = record.log_time / 1e9
            entries.append(Entry(record.sequence, at, channel.topic, kind, record.data))
            walls.append(record.publish_time)
        elif isinstance(record, AttachmentRecord):
            if record.name in attachments:
                repeated.append(record.name)
            attachments[record.name] = Attachment(record.media_type, record.data)
        elif isinstance(record, Footer):
            whole = True
    return Recording(path, entries, walls, attachments, whole, repeated)


def _records(file: BinaryIO) -> Iterator[object]:
    """All records of a file, those in chunks as well."""
    for record in StreamReader(file, emit_chunks=True, record_size_limit=_MOST_RECORD).records:
        if not isinstance(record, Chunk):
            yield record
            continue
        if record.uncompressed_size > _MOST_RECORD:
            raise ValueError(f"a chunk has {record.uncompressed_size} bytes")
        yield from breakup_chunk(record, validate_crc=True)


def is_being_written(path: Path) -> bool:
    """Whether a file is the recording of a trial that runs, see `BEING_WRITTEN`.

    Raises
    ------
    RecordingError
        It cannot be read.
    """
    try:
        changed = path.stat().st_mtime
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    return time.time() - changed < BEING_WRITTEN and not read_recording(path).whole


def repair(path: Path) -> Recording:
    """Complete a recording that was cut off, in its place; a whole one is left alone.

    What is left of it is written to a new file first, which then takes its name.

    Raises
    ------
    RecordingError
    """
    recording = read_recording(path)
    if recording.whole:
        return recording
    draft = path.with_name(f".{path.name}.repaired")
    with suppress(OSError):
        draft.unlink()
    writer = RecordingWriter(draft, recording.attachments)
    for entry, wall in zip(recording.entries, recording.walls):
        writer.put(entry, wall)
    writer.close({})
    try:
        draft.replace(path)
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    return read_recording(path)
