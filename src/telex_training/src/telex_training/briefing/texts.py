"""Sentences and words of an exercise that people read, by which translations find them."""

from __future__ import annotations

from typing import Any, Dict, Iterable, Iterator, List, Mapping

from ..exercises.exercise_file import ExerciseFile
from ..exercises.findings import Finding
from ..exercises.model import Exercise
from .brief import exercise_brief


def exercise_texts(exercise: Exercise) -> Iterator[str]:
    """Yield what pages show of an exercise in a setting.

    What follows a bar tells apart what other languages say in other words, as in `words.Said`.
    """
    yield from (exercise.title, exercise.description, exercise.setting, exercise.expert.sees)
    yield from (step.name for step in exercise.steps)
    yield from (fault.name for fault in exercise.faults)
    yield from (penalty.name for penalty in exercise.penalties)
    yield from (hint.text for hint in exercise.hints)
    for question in exercise.questions:
        yield question.ask
        yield from (f"{choice}|choice" for choice in question.choices)
    for metric in exercise.metrics:
        yield from (f"{name}|name" for name in (metric.object, metric.robot) if name)
    brief = exercise_brief(exercise)
    yield from _parts(brief["begins"])
    for key, when in (("steps", "until"), ("faults", "when"), ("penalties", "when")):
        for each in brief[key]:
            yield from _parts(each[when])


def _parts(told: Dict[str, Any]) -> Iterator[str]:
    yield told["english"]
    for value in told["values"].values():
        if isinstance(value, dict):
            yield from _parts(value)
        elif isinstance(value, str):
            yield value


def merged_texts(all_texts: Iterable[Mapping[str, Mapping[str, str]]]) -> Dict[str, Dict[str, str]]:
    """What exercises say in other languages by their own files, as one table for each language."""
    merged: Dict[str, Dict[str, str]] = {}
    for texts in all_texts:
        for language, table in texts.items():
            merged.setdefault(language, {}).update(table)
    return merged


def unsaid(file: ExerciseFile) -> List[Finding]:
    """Find translations in an exercise's file of what it does not say."""
    said = {text for exercise in file.settings.values() for text in exercise_texts(exercise)}
    return [
        Finding(f"texts/{language}", f"'{text[:80]}' is nothing that the exercise says", True)
        for language, table in file.texts.items()
        for text in table
        if text not in said
    ]
