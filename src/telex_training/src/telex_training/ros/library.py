"""Trials that have been recorded: their files and their sheets."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple

from ..recording.station_keys import known_keys
from ..recording.trial_file import SUFFIX, read_sheet, read_workload, signature_of, trials
from ..recording.writer import RecordingError


class Library:
    """The recordings of a folder; a sheet is read again only where its file has changed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()
        self._known: Dict[Path, Tuple[int, Optional[Dict[str, Any]]]] = {}

    def path(self, trial: str) -> Optional[Path]:
        """Path of a trial's recording; None: there is none."""
        path = self._folder / f"{trial}{SUFFIX}"
        try:
            return path if trial and path.parent == self._folder and path.is_file() else None
        except OSError:  # the name is too long
            return None

    def sheet(self, trial: str) -> Optional[Dict[str, Any]]:
        """Sheet of a trial; None: it has none (yet)."""
        path = self.path(trial)
        return None if path is None else self._read(path)

    def workload(self, trial: str) -> Optional[Dict[str, Any]]:
        """Ratings of a trial's workload by its operator; None: there are none."""
        path = self.path(trial)
        return None if path is None else read_workload(path)

    def signature(self, trial: str) -> Optional[str]:
        """Say what the signature of an exam is worth; None: there is no such trial."""
        path = self.path(trial)
        if path is None:
            return None
        try:
            return str(signature_of(path, known_keys()))
        except RecordingError as error:
            return str(error)

    def sheets(self, operator: Optional[str] = None) -> List[Dict[str, Any]]:
        """All sheets, or an operator's, the newest first."""
        found = [self._read(path) for path in reversed(trials(self._folder))]
        return [
            sheet
            for sheet in found
            if sheet is not None and (operator is None or sheet.get("operator") == operator)
        ]

    def best(self, operator: str) -> Dict[str, float]:
        """An operator's best completed repetition by exercise (s, with its penalties)."""
        best: Dict[str, float] = {}
        for name, _, seconds in self._completed(operator):
            best[name] = min(seconds, best.get(name, seconds))
        return best

    def best_in(self, operator: str, exercise: str, setting: str) -> Optional[float]:
        """An operator's best completed repetition of an exercise in a setting (s); None: none."""
        times = [
            seconds
            for name, of, seconds in self._completed(operator)
            if (name, of) == (exercise, setting)
        ]
        return min(times, default=None)

    def _completed(self, operator: str) -> Iterator[Tuple[str, str, float]]:
        """Exercise, setting and time (s, with penalties) of each repetition that was completed."""
        for sheet in self.sheets(operator) if operator else []:
            of = sheet["exercise"]
            for repetition in sheet["repetitions"]:
                if repetition["completed"]:
                    yield of["name"], of["setting"], repetition["seconds"] + repetition["penalty"]

    def forget(self) -> None:
        """Look at every file again."""
        with self._lock:
            self._known.clear()

    def _read(self, path: Path) -> Optional[Dict[str, Any]]:
        try:
            changed = path.stat().st_mtime_ns
        except OSError:
            return None
        with self._lock:
            known = self._known.get(path)
        if known is not None and known[0] == changed:
            return known[1]
        sheet = read_sheet(path)
        with self._lock:
            self._known[path] = (changed, sheet)
        return sheet
