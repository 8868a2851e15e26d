"""Recordings that are open, and who may see them."""

from __future__ import annotations

import threading
from collections import OrderedDict
from pathlib import Path
from typing import Any, List, Mapping, NamedTuple, Tuple

from ...recording.writer import RecordingError
from ...replay.replay import Replay
from ..library import Library
from ..robot_files import mesh_digests, software_version

_MOST_OPEN = 3


class NotHereError(Exception):
    """There is no such recording for whoever asks."""


class Open(NamedTuple):
    """A recording that is open.

    Attributes
    ----------
    replay : Replay
    problems : list of str
        What is not as it was when it was made.
    """

    replay: Replay
    problems: List[str]


class Shelf:
    """Opens recordings by their trials' names; the last few stay open.

    Parameters
    ----------
    library : Library
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
        try:
            changed = path.stat().st_mtime_ns
        except OSError as error:
            raise RecordingError(f"{path}: {error.strerror}") from error
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

    def permitted(self, trial: str, name: str, instructor: bool) -> Open:
        """Open a recording for whoever may see it: its operator, and instructors.

        Raises
        ------
        NotHereError
            It is not there, or somebody else's: who may not see it must not learn that.
        RecordingError
        """
        if not (instructor or trial == self.given):
            sheet = self._library.sheet(trial)
            if sheet is not None and sheet.get("operator") != name:
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
