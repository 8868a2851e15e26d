"""An expert's run of an exercise as a recording, to be looked at beside people's."""

from __future__ import annotations

from pathlib import Path

from ..exercises.exercise_file import ExerciseFile
from ..exercises.model import PRACTICE
from ..judging.judge import Judge
from ..operators.experts.brief import Expert
from ..operators.port import NotManagedError
from ..recording.trial_file import EXPERTS, Trial, expert_path
from ..recording.writer import check_room
from .figures import FiguresError
from .recorded import record
from .trial import practice_seed, rehearsed

_OPERATOR = "expert"


def demonstrate(
    file: ExerciseFile, setting: str, expert: Expert, folder: Path, software: str
) -> Path:
    """Let an expert do one repetition, with the seed of practice, and record it.

    Parameters
    ----------
    expert : callable
    folder : Path
        Of people's recordings; experts' have one of their own in it.
    software : str
        As in `Trial`.

    Returns
    -------
    Path
        Of the recording; it takes the place of an earlier one.

    Raises
    ------
    FiguresError
        The expert did not complete it.
    RecordingError
    """
    exercise = file.setting(setting)
    seed = practice_seed(exercise)
    where = f"{exercise.name}, setting {exercise.setting!r}"
    check_room(folder / EXPERTS)
    try:
        trial = rehearsed(exercise, expert, seed)
    except NotManagedError as error:
        raise FiguresError(f"{where}: the expert gave up: {error}") from error
    path = expert_path(folder, exercise.name, exercise.setting)
    # He did one repetition of an exercise that may ask for more: the sheet is that of the file.
    judge = Judge(exercise, trial.scene, trial.urdf, trial.urdfs)
    for entry in trial.entries:
        judge.feed(entry)
    if not any(each["completed"] for each in judge.sheet()["repetitions"]):
        raise FiguresError(f"{where}: the expert did not complete a repetition")
    about = Trial(path.stem, str(file.path), exercise.setting, PRACTICE, _OPERATOR, software, seed)
    return record(path, about, file.text, trial, judge.text())
