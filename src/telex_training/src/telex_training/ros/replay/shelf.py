"""Recordings that are open, and who may see them."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from pathlib import Path
from typing import Any, List, Mapping, NamedTuple, Tuple

from ...judging.moments import MOST_NOTES, MomentNote
from ...recording.amending import alone, amend_alone
from ...recording.pseudonym import operator_of
from ...recording.writer import RecordingError
from ...replay.replay import Replay
from ..library import Library
from ..robot_files import mesh_digests, software_version

_MOST_OPEN = 4
"""Two trials, each with a ghost."""


class NotHereError(Exception):
    """There is no such recording for whoever asks."""


class Open(NamedTuple):
    """A recording that is open.

    Attributes
    ----------
    problems : list of str
        What is not as it was when it was made.
    """

    replay: Replay
    problems: List[str]


class Shelf:
    """Opens recordings by their trials' names; the last few stay open.

    Parameters
    ----------
    file : Path, optional
        A recording that everybody may see.
    cameras : mapping
        As for `Replay`.
    """

    def __init__(self, library: Library, file: str, cameras: Mapping[str, Any]) -> None:
        self._library = library
        self._file = Path(file).expanduser() if file else None
        self._cameras = cameras
        self._lock = threading.Lock()
        self._open: OrderedDict[Path, Tuple[int, Open]] = OrderedDict()

    @property
    def given(self) -> str:
        """Trial of the file that the node was given; empty: none."""
        return self._file.stem if self._file is not None else ""

    def open(self, trial: str) -> Open:
        """Open a trial's recording; it is read again only where it has changed.

        Raises
        ------
        NotHereError
        RecordingError
        """
        given = self._file is not None and trial in ("", self.given)
        path = self._file if given else self._library.path(trial)
        if path is None:
            raise NotHereError(trial)
        return self.open_file(path)

    def open_file(self, path: Path) -> Open:
        """Open a recording; see `open`.

        Raises
        ------
        RecordingError
        """
        changed = _changed(path)
        with self._lock:
            known = self._open.get(path)
            if known is not None and known[0] == changed:
                self._open.move_to_end(path)
                return known[1]
            replay = Replay.open(path, self._cameras)
            meshes = mesh_digests(replay.urdf)
            problems = [*replay.problems, *replay.compare(software_version(), meshes)]
            made = Open(replay, problems)
            self._open[path] = (changed, made)
            while len(self._open) > _MOST_OPEN:
                self._open.popitem(last=False)
            return made

    def note(self, replay: Replay, note: MomentNote) -> None:
        """Add a note to a recording; it stays open.

        Raises
        ------
        RecordingError
            Nothing can be added to it.
        """
        path = replay.path
        with self._lock:
            if not replay.closed:
                raise RecordingError(
                    f"{path}: it is not complete, for its trial goes on or was cut off; notes "
                    "are added to complete ones"
                )
            if len(replay.notes) >= MOST_NOTES:
                raise RecordingError(f"{path}: it has {MOST_NOTES} notes; more are not possible")
            with alone(path.parent):
                before = _changed(path)
                amend_alone(path, [note.content()], time.time_ns())
                after = _changed(path)
            replay.notes.append(note)
            known = self._open.get(path)
            if known is not None and known[0] == before and known[1].replay is replay:
                # What has changed is known: it needs not be read again.
                self._open[path] = (after, known[1])

    def permitted(self, trial: str, name: str, instructor: bool) -> Open:
        """Open a recording for whoever may see it: its operator, and instructors.

        Raises
        ------
        NotHereError
            It is not there, or somebody else's: who may not see it must not learn that.
        RecordingError
        """
        if not (instructor or trial == self.given):
            path = self._library.path(trial)
            # Before it is read, which takes long, and what others look at waits for it.
            if path is None or operator_of(path) != name:
                raise NotHereError(trial)
        try:
            found = self.open(trial)
        except RecordingError:
            if instructor or trial == self.given:
                raise
            raise NotHereError(trial) from None
        if instructor or trial == self.given or found.replay.trial.operator == name:
            return found
        raise NotHereError(trial)


def _changed(path: Path) -> int:
    """Time of a file's last change (ns).

    Raises
    ------
    RecordingError
    """
    try:
        return path.stat().st_mtime_ns
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
