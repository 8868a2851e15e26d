"""Takes in recordings from other machines: a trial is itself by its name, twice is once."""

from __future__ import annotations

import contextlib
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, List, Sequence, Tuple

from ..judging.entries import Entry
from ..recording.amending import alone
from ..recording.reader import read_recording
from ..recording.signature import VALID
from ..recording.station_keys import known_keys
from ..recording.trial_file import signature_of, trials
from ..recording.writer import RecordingError, check_room
from .index import ProgressIndex
from .trial_facts import TrialFacts, file_of, read_trial

NEW, KNOWN, NEWER, REFUSED = "new", "known", "newer", "refused"
"""Taken in; here already; took the place of one with fewer marks and notes; not taken in."""


@dataclass(frozen=True)
class Imported:
    """What became of a file.

    Attributes
    ----------
    what : str
        See `NEW`.
    reason : str
        Why it was refused.
    """

    path: Path
    what: str
    reason: str = ""


def import_files(
    index: ProgressIndex, given: Sequence[Path], verify: bool = False
) -> List[Imported]:
    """Copy recordings into the index's folder, each trial once, and take them into the index.

    Parameters
    ----------
    index : ProgressIndex
        It is to be up to date.
    given : sequence of Path
        Recordings, or folders of them.
    verify : bool
        Whether to judge each anew, too; see `read_trial`.

    Raises
    ------
    RecordingError
        The folder cannot be written.
    """
    check_room(index.folder)
    done = []
    for path in _files(given):
        try:
            what = _import(index, path, verify)
            done.append(Imported(path, what))
        except RecordingError as error:
            done.append(Imported(path, REFUSED, str(error)))
    index.refresh()
    return done


def _files(given: Sequence[Path]) -> Iterator[Path]:
    for path in given:
        if path.is_dir():
            yield from trials(path)
        else:
            yield path


def _import(index: ProgressIndex, path: Path, verify: bool) -> str:
    facts = read_trial(path, verify)
    with alone(index.folder):
        return _take_in(index, path, facts)


def _take_in(index: ProgressIndex, path: Path, facts: TrialFacts) -> str:
    own = index.file_of(facts.trial) or file_of(index.folder, facts.trial)
    if not own.exists():
        _copy(path, own)
        return NEW
    if own.samefile(path):
        return KNOWN
    try:
        known = read_trial(own)
    except RecordingError as error:
        raise RecordingError(f"{path}: {own.name} is here already, and is damaged: {error}") from (
            error
        )
    return _merge(path, facts, own, known)


def _merge(path: Path, facts: TrialFacts, own: Path, known: TrialFacts) -> str:
    """Decide between two recordings of one name: whatever was added later is kept."""
    # Ratings of the workload are entries of which the sheet's hash knows nothing.
    if facts.log == known.log and path.stat().st_size == own.stat().st_size:
        return KNOWN
    if (facts.began_ns, facts.seed) != (known.began_ns, known.seed):
        raise RecordingError(
            f"{path}: another trial is called {facts.trial} here ({own.name}); trials of two "
            "machines that began in one second under one name, or none, cannot be told apart"
        )
    theirs, ours = _content(path), _content(own)
    if theirs == ours[: len(theirs)]:
        return KNOWN
    if ours != theirs[: len(ours)]:
        raise RecordingError(
            f"{path}: trial {facts.trial} was marked, or made anonymous, in {own.name} otherwise "
            "than in this file; the one that is here is kept"
        )
    _require_as_valid(path, own)
    _copy(path, own)
    return NEWER


def _require_as_valid(path: Path, own: Path) -> None:
    """Refuse to put what nobody vouches for in the place of a signed exam.

    Raises
    ------
    RecordingError
    """
    keys = known_keys()
    theirs = signature_of(path, keys)
    if theirs.state != VALID and signature_of(own, keys).state == VALID:
        raise RecordingError(
            f"{path}: its signature is: {theirs}; that of {own.name} is valid, so the one that is "
            "here is kept"
        )


def _content(path: Path) -> List[Tuple[str, bytes]]:
    def content(entry: Entry) -> Tuple[str, bytes]:
        return entry.channel, entry.data

    return [content(entry) for entry in read_recording(path).entries]


def _copy(path: Path, target: Path) -> None:
    """Copy a file as a whole: a reader finds the old one, or the new one."""
    draft = target.with_name(f".{target.name}.imported")
    try:
        shutil.copyfile(path, draft)
        with draft.open("rb+") as file:
            os.fsync(file.fileno())
        draft.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            draft.unlink()
        raise RecordingError(f"{error.filename or target}: {error.strerror}") from error
