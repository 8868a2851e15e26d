"""Recordings of rehearsed trials, for the replay and for `score`."""

from __future__ import annotations

from pathlib import Path

from ..recording.trial_file import SUFFIX, Trial, attachments
from ..recording.writer import RecordingWriter
from .trial import RehearsedTrial


def record(folder: Path, about: Trial, exercise: str, trial: RehearsedTrial) -> Path:
    """Write a trial that has ended as a recording.

    The wall's time in it is sim time. It has no sheet: the rehearsed trial ended after one
    repetition, whatever the exercise asks for.

    Parameters
    ----------
    folder : Path
    about : Trial
    exercise : str
        Text of the exercise's file.
    trial : RehearsedTrial

    Returns
    -------
    Path
        Of the recording; one of the same name is replaced.

    Raises
    ------
    RecordingError
    """
    path = folder / f"{about.trial}{SUFFIX}"
    path.unlink(missing_ok=True)
    # No cameras: a replay draws with the shipped ones.
    writer = RecordingWriter(path, attachments(about, exercise, trial.scene, trial.urdf, {}, {}))
    for entry in trial.entries:
        writer.put(entry, round(1e9 * entry.time))
    writer.close({})
    return path
