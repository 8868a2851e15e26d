"""Adds to a recording that is closed: marks, notes, ratings."""

from __future__ import annotations

import contextlib
import fcntl
import os
from pathlib import Path
from typing import Any, Iterator, Mapping, Sequence

from ..judging.entries import Entry
from ..judging.moments import INPUT as MOMENT
from ..judging.workload import INPUT as TLX
from .reader import Recording, repair
from .signature import SIGNATURE, sealing_again
from .trial_file import SHEET, attached_text, input_entry, judged, sheet_attachment
from .writer import RecordingError, RecordingWriter

_ASIDE = (TLX, MOMENT)
"""Inputs that leave the sheet as it is."""


def amend(path: Path, inputs: Sequence[Mapping[str, Any]], wall_ns: int) -> str:
    """Add inputs to a recording that is closed, such as a mark or a note, and judge it anew.

    The file is replaced as a whole, so that a reader finds the old or the new one; who else amends
    a recording of its folder, in any process, waits. Ratings of the workload and notes at moments
    leave its sheet as it is. A valid signature is made anew, any other is left out.

    Parameters
    ----------
    wall_ns : int
        Wall time of them (ns).

    Returns
    -------
    str
        The new score sheet.

    Raises
    ------
    RecordingError
    """
    with alone(path.parent):
        return amend_alone(path, inputs, wall_ns)


def amend_alone(path: Path, inputs: Sequence[Mapping[str, Any]], wall_ns: int) -> str:
    """Do the same in a folder that the caller has `alone`."""
    recording = repair(path)
    entries, walls = list(recording.entries), list(recording.walls)
    last = entries[-1] if entries else Entry(-1, 0.0, "", "", b"")
    for number, content in enumerate(inputs, last.number + 1):
        entries.append(input_entry(number, round(last.time * 1e9), content))
        walls.append(wall_ns)
    shown = recording.attachments.get(SHEET)
    if shown is not None and all(content["input"] in _ASIDE for content in inputs):
        text = attached_text(recording, SHEET)
    else:
        text = judged(Recording(path, entries, walls, recording.attachments)).text()
    gone = (SHEET, SIGNATURE)
    kept = {name: found for name, found in recording.attachments.items() if name not in gone}
    draft = path.with_name(f".{path.name}.amended")
    draft.unlink(missing_ok=True)
    writer = RecordingWriter(draft, kept)
    for entry, wall in zip(entries, walls):
        writer.put(entry, wall)
    writer.close({SHEET: sheet_attachment(text)}, sealing_again(recording))
    try:
        draft.replace(path)
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    return text


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Wait for whoever replaces recordings of a folder, and have others wait.

    Raises
    ------
    RecordingError
    """
    try:
        number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise RecordingError(f"{folder}: {error.strerror}") from error
    try:
        fcntl.flock(number, fcntl.LOCK_EX)
        yield
    finally:
        os.close(number)
