"""Runs that can be drawn beside a trial, and who may see them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

from ...recording.trial_file import expert_path, read_sheet
from ...replay.ghost import Ghost
from ...replay.replay import Replay
from ..library import Library
from .shelf import NotHereError, Shelf

EXPERT = "expert"
"""Name of the expert's run; others have their trials'."""
_MOST = 100


class Ghosts:
    """Finds other runs of a trial's exercise and setting, and aligns them with it.

    An expert's run anybody sees; for others holds what holds for their replays.

    Parameters
    ----------
    folder : Path
        Of the recordings.
    """

    def __init__(self, library: Library, shelf: Shelf, folder: Path) -> None:
        self._library, self._shelf, self._folder = library, shelf, folder
        self._made: Optional[Tuple[Replay, Replay, Ghost]] = None

    def _expert(self, trial: Replay) -> Path:
        exercise = trial.exercise
        return expert_path(self._folder, exercise.name, exercise.setting)

    def offered(self, trial: Replay, name: str, instructor: bool) -> List[Dict[str, Any]]:
        """List runs for whoever asks: the expert's, then the newest; as plain data.

        Each has its name as ``ghost``, the ``operator``, the ``seconds`` of the fastest
        repetition, and whether things stood in the ``same_places``.
        """
        found = [(EXPERT, read_sheet(self._expert(trial)))]
        found += [
            (sheet["trial"], sheet)
            for sheet in self._library.sheets(None if instructor else name)
            if sheet["trial"] != trial.trial.trial
        ]
        made = [_row(trial, key, sheet) for key, sheet in found if sheet is not None]
        return [row for row in made if row is not None][:_MOST]

    def open(self, trial: Replay, ghost: str, name: str, instructor: bool) -> Ghost:
        """Open a run beside a trial.

        Raises
        ------
        NotHereError
        GhostError
        RecordingError
        """
        if ghost == EXPERT:
            path = self._expert(trial)
            if not path.is_file():
                raise NotHereError(EXPERT)
            other = self._shelf.open_file(path).replay
        else:
            other = self._shelf.permitted(ghost, name, instructor).replay
        made = self._made
        if made is None or made[0] is not trial or made[1] is not other:
            made = self._made = (trial, other, Ghost(trial, other))
        return made[2]


def _row(trial: Replay, key: str, sheet: Dict[str, Any]) -> Optional[Dict[str, Any]]:
    """Row of a run; None where it is of another exercise, or was not completed."""
    exercise, of = sheet["exercise"], trial.exercise
    seconds = [each["seconds"] for each in sheet["repetitions"] if each["completed"]]
    if (exercise["name"], exercise["setting"]) != (of.name, of.setting) or not seconds:
        return None
    return {
        "ghost": key,
        "operator": sheet["operator"],
        "seconds": min(seconds),
        "same_places": exercise["seed"] == trial.trial.seed,
    }
