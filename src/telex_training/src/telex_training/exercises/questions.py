"""Right answers of what is to be read in an exercise's scene."""

from __future__ import annotations

from typing import Any, Dict, Tuple

import yaml

from telex_control.common.params import ConfigError
from telex_sim.scene.answers import answers

from .exercise_file import ExerciseError
from .model import Exercise, Question


def read_objects(exercise: Exercise) -> Tuple[str, ...]:
    """Objects on which an answer is to be read: each repetition wants them drawn anew."""
    return tuple(dict.fromkeys(question.of for question in exercise.questions if question.of))


def named_entries(text: str) -> Dict[str, Any]:
    """Return the entries of a scene's objects that have a name, by it.

    Parameters
    ----------
    text : str
        Of the scene, as `seeds.scene_text` makes it.
    """
    entries = yaml.safe_load(text)["objects"]
    return {
        entry["name"]: entry
        for entry in entries
        if isinstance(entry, dict) and isinstance(entry.get("name"), str)
    }


def right_answers(exercise: Exercise, text: str) -> Dict[str, str]:
    """Right answers by question, where the scene has them.

    Parameters
    ----------
    text : str
        Of the scene, as `seeds.scene_text` makes it; a sealed entry needs this machine's key.

    Returns
    -------
    dict of str to str
        Directions as `telex_sim.scene.answers` has them; several are joined by commas.

    Raises
    ------
    ExerciseError
        Something cannot be read, or there is no such row or place.
    """
    entries = named_entries(text)
    found = {}
    for question in exercise.questions:
        if not question.of:
            continue
        try:
            rows = answers(entries.get(question.of, {}))
            found[question.name] = ", ".join(_part(question, rows))
        except ConfigError as error:
            raise ExerciseError(
                f"{exercise.path}: questions ({question.name})/of: {error}"
            ) from error
    return found


def _part(question: Question, rows: Tuple[Tuple[str, ...], ...]) -> Tuple[str, ...]:
    if question.row > len(rows):
        raise ConfigError(f"row is {question.row}; '{question.of}' has {len(rows)}")
    chosen = rows[question.row - 1] if question.row else tuple(x for row in rows for x in row)
    if question.place > len(chosen):
        raise ConfigError(f"place is {question.place}; there are {len(chosen)}")
    return (chosen[question.place - 1],) if question.place else chosen
