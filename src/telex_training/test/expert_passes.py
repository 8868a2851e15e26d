"""A scripted expert does its exercise in rehearsal, and is judged."""

from __future__ import annotations

from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.operators.experts.catalog import EXPERTS
from telex_training.rehearsal.trial import rehearse

SETTINGS = {
    "gap": "gap_40",
    "hurdle": "square_20",
    "stairs": "deg_35",
    "confinement": "narrow_60",
    "continuous_ramps": "one_ridge",
    "incline": "deg_25",
    "slalom": "cones_3",
}
"""In place of the first."""


def pass_exercise(name: str) -> None:
    """Assert that an exercise's expert passes it."""
    exercise = load_exercise(find_exercise(name)).setting(SETTINGS.get(name, ""))
    sheet = rehearse(exercise, EXPERTS[name])
    assert sheet["valid"], sheet["invalid_because"]
    (repetition,) = sheet["repetitions"]
    assert repetition["fault"] is None, repetition["fault"]
    assert repetition["completed"]
    assert None not in repetition["steps"]
    wrong = [metric["name"] for metric in sheet["metrics"] if metric["within"] is False]
    assert wrong == []
    assert sheet["verdict"] == "passed"
