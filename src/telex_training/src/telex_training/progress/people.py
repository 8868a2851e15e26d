"""Forgets people: removes their trials, or puts a pseudonym in their place; and what is too old."""

from __future__ import annotations

import contextlib
import secrets
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import List, Optional

from ..recording.pseudonym import operator_of, rename_person, spellings, traces
from ..recording.reader import is_being_written
from ..recording.trial_file import trials
from ..recording.writer import RecordingError
from .index import ProgressIndex

EXPORTS = "exports"
"""Folder in that of the recordings where exports go, so that they can be forgotten as well."""
DAY = 86400.0


class PeopleError(ValueError):
    """Somebody cannot be forgotten; the message says why and what would be right."""


@dataclass
class Forgotten:
    """What was done.

    Attributes
    ----------
    removed, renamed, mentioned : list of Path
        Recordings that are gone; own ones under a pseudonym; those of others that named the person.
    exports : list of Path
        Files made of recordings, which are gone.
    left : list of str
        Where the name still stands, and what could not be done.
    """

    removed: List[Path] = field(default_factory=list)
    renamed: List[Path] = field(default_factory=list)
    mentioned: List[Path] = field(default_factory=list)
    exports: List[Path] = field(default_factory=list)
    left: List[str] = field(default_factory=list)


def new_pseudonym() -> str:
    """Make a pseudonym that says nothing of whom it stands for."""
    return f"person-{secrets.token_hex(4)}"


def forget(index: ProgressIndex, name: str, pseudonym: str = "") -> Forgotten:
    """Forget a person in recordings, exports and index.

    In the recordings of others, where the person was at the bridge or wrote a note, a pseudonym
    takes the name's place in any case.

    Parameters
    ----------
    name : str
        Exactly as in the trials.
    pseudonym : str
        Empty: the person's own recordings are removed.

    Raises
    ------
    PeopleError
        There is no such person, or a trial runs, of whomever.
    """
    if not name.strip():
        raise PeopleError("name is ''; trials under no name belong to nobody")
    files = trials(index.folder)
    own = [path for path in files if operator_of(path) == name]
    for path in files:
        # Others', too: the name may stand in them, and what is written cannot be replaced.
        if _runs(path):
            raise PeopleError(
                f"{path}: this trial runs; it has to be ended first (training/call_off)"
            )
    done = Forgotten()
    shown = pseudonym or new_pseudonym()
    for path in files:
        if path in own and not pseudonym:
            _remove(path, done)
        else:
            _rename(path, name, shown, done)
    if not (own or done.mentioned):
        raise PeopleError(_unknown(index, name))
    _forget_exports(index.folder, name, done)
    # A new file: of rows that are only deleted, something may stay on the disk.
    index.rebuild()
    return done


def _unknown(index: ProgressIndex, name: str) -> str:
    index.refresh()
    known = [person.name for person in index.people() if person.name]
    near = [other for other in known if other.casefold() == name.casefold()]
    names = ", ".join(near or known) or "nobody"
    return f"name is '{name}'; in {index.folder} there are trials of: {names}"


def _runs(path: Path) -> bool:
    try:
        return is_being_written(path)
    except RecordingError:  # damaged, which is told when it cannot be searched
        return False


def _remove(path: Path, done: Forgotten) -> None:
    try:
        path.unlink()
        done.removed.append(path)
        _remove_traces(path, done)
    except OSError as error:
        done.left.append(f"{path}: {error.strerror}")


def _remove_traces(path: Path, done: Forgotten) -> None:
    for trace in traces(path.parent, path.stem):
        trace.unlink()
        done.exports.append(trace)


def _rename(path: Path, name: str, pseudonym: str, done: Forgotten) -> None:
    try:
        renamed = rename_person(path, name, pseudonym)
        if renamed is None:
            return
        (done.renamed if renamed.own else done.mentioned).append(renamed.path)
        done.left += [f"{renamed.path}: the name may still stand in {at}" for at in renamed.left]
        _remove_traces(path, done)
    except (RecordingError, OSError) as error:
        # Others' files that are damaged cannot be searched; whoever asked has to know.
        done.left.append(str(error))


def _forget_exports(folder: Path, name: str, done: Forgotten) -> None:
    """Remove exports that have the name in them; they can be made anew."""
    spelt = [each.encode() for each in spellings(name)]
    for path in sorted((folder / EXPORTS).glob("*")):
        try:
            content = path.read_bytes() if path.is_file() else b""
            if any(each in content for each in spelt):
                path.unlink()
                done.exports.append(path)
        except OSError as error:
            done.left.append(f"{path}: {error.strerror}")


def expire(index: ProgressIndex, days: float, now: Optional[float] = None) -> List[Path]:
    """Remove recordings and exports that are older than so many days; a trial that runs is not.

    A trial is as old as its beginning; what has none, a damaged file or an export, as its last
    change.

    Parameters
    ----------
    days : float
        Above 0.
    now : float, optional
        Wall time (s since the epoch).

    Returns
    -------
    list of Path
        What was removed.
    """
    oldest = (time.time() if now is None else now) - days * DAY
    index.refresh()
    began = {index.file_of(trial.trial): trial.began for trial in index.trials()}
    gone: List[Path] = []
    exports = [path for path in (index.folder / EXPORTS).glob("*") if path.is_file()]
    for path in [*trials(index.folder), *sorted(exports)]:
        with contextlib.suppress(OSError):  # somebody else took it away
            if began.get(path, path.stat().st_mtime) < oldest:
                for each in (path, *traces(path.parent, path.stem)):
                    each.unlink()
                    gone.append(each)
    if gone:
        index.rebuild()
    return gone
