"""Recordings of rehearsed trials, for the replay and for `score`."""

from __future__ import annotations

from pathlib import Path

from ..recording.trial_file import SHEET, Trial, attachments, sheet_attachment
from ..recording.writer import RecordingWriter
from .trial import RehearsedTrial


def record(path: Path, about: Trial, exercise: str, trial: RehearsedTrial, sheet: str = "") -> Path:
    """Write a trial that has ended as a recording; the wall's time in it is 0.

    Parameters
    ----------
    path : Path
        Of the recording; an earlier one is replaced once the new one is complete.
    exercise : str
        Text of the exercise's file.
    sheet : str
        Text of its score sheet; empty: it has none.

    Returns
    -------
    Path
        The same.

    Raises
    ------
    RecordingError
    """
    draft = path.with_name(f".{path.name}.new")
    draft.unlink(missing_ok=True)
    # No cameras: a replay draws with the shipped ones.
    made = attachments(about, exercise, trial.scene, trial.urdf, {}, {}, trial.urdfs)
    writer = RecordingWriter(draft, made)
    for entry in trial.entries:
        writer.put(entry, 0)
    writer.close({SHEET: sheet_attachment(sheet)} if sheet else {})
    draft.replace(path)
    return path
