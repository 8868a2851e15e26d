"""Checks of a curriculum against the exercises that there are, and of the order of its modules."""

from __future__ import annotations

import difflib
from typing import Dict, Iterator, List, Set

from ..exercises.catalog import exercises, find_exercise
from ..exercises.exercise_file import ExerciseError, ExerciseFile, load_exercise
from ..exercises.findings import Finding
from ..exercises.model import EXAM
from .curriculum_file import Curriculum, ExamPart, Module


def check_curriculum(curriculum: Curriculum) -> List[Finding]:
    """Say what is wrong with a curriculum, the names of exercises and settings included."""
    return [*_order(curriculum), *_Exercises().findings(curriculum)]


class _Exercises:
    """The exercises that a curriculum names; each file is read once."""

    def __init__(self) -> None:
        self._read: Dict[str, ExerciseFile] = {}

    def findings(self, curriculum: Curriculum) -> Iterator[Finding]:
        for i, module in enumerate(curriculum.modules):
            yield from self._look_up(
                f"modules[{i}] ({module.name})", module.exercise, module.setting
            )
        for i, part in enumerate(curriculum.exam):
            yield from self._exam(f"exam[{i}] ({part.exercise})", part)
        if curriculum.currency is not None:
            yield from self._look_up(
                "currency", curriculum.currency.exercise, curriculum.currency.setting
            )

    def _look_up(self, where: str, exercise: str, setting: str) -> Iterator[Finding]:
        if "/" in exercise or exercise.endswith(".yaml"):
            yield Finding(
                f"{where}/exercise",
                f"it is '{exercise}'; the name of an exercise is needed, as trials have it "
                "(exercise list; TELEX_EXERCISE_PATH names further folders)",
            )
            return
        try:
            if exercise not in self._read:
                self._read[exercise] = load_exercise(find_exercise(exercise))
        except ExerciseError as error:
            if exercise in exercises():
                yield Finding(f"{where}/exercise", f"it is '{exercise}', which is wrong: {error}")
            else:
                yield Finding(f"{where}/exercise", _unknown(exercise, list(exercises())))
            return
        file = self._read[exercise]
        if file.first.name != exercise:
            yield Finding(
                f"{where}/exercise",
                f"it is '{exercise}', whose file gives it the name '{file.first.name}'; trials "
                "bear that name, so name and file must agree",
            )
        if setting and setting not in file.settings:
            yield Finding(f"{where}/setting", _unknown(setting, list(file.settings)))

    def _exam(self, where: str, part: ExamPart) -> Iterator[Finding]:
        found = list(self._look_up(where, part.exercise, part.setting))
        yield from found
        if found:
            return
        exercise = self._read[part.exercise].setting(part.setting)
        if EXAM not in exercise.modes:
            yield Finding(
                f"{where}/exercise",
                f"it is '{part.exercise}', which has no mode {EXAM}; it has: "
                f"{', '.join(exercise.modes)}",
            )
        most = exercise.repetitions.most
        if most and part.repetitions > most:
            yield Finding(
                f"{where}/repetitions",
                f"it is {part.repetitions}; a trial of this exercise ends after {most}, so at most "
                f"{most} is possible",
            )
        elif most and part.repetitions < most:
            yield Finding(
                f"{where}/repetitions",
                f"it is {part.repetitions}; a trial of this exercise goes on to {most}, unless its "
                "time ends it, and all of them count",
                wrong=False,
            )


def _unknown(name: str, known: List[str]) -> str:
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    names = near + [other for other in known if other not in near]
    return f"it is '{name}'; there are: {', '.join(names)}"


def _order(curriculum: Curriculum) -> Iterator[Finding]:
    """Names of needs, circles among them, and what stands behind either."""
    modules = {module.name: module for module in curriculum.modules}
    places = {name: f"modules[{i}] ({name})" for i, name in enumerate(modules)}
    bad: Set[str] = set()
    for name, module in modules.items():
        for need in module.needs:
            if need not in modules:
                yield Finding(f"{places[name]}/needs", _unknown(need, list(modules)))
                bad.add(name)
    for circle in _circles(modules):
        yield Finding(
            f"{places[circle[0]]}/needs",
            f"they go round in a circle, {' -> '.join([*circle, circle[0]])}; one of these needs "
            "has to go",
        )
        bad.update(circle)
    for name in modules:
        behind = sorted(_all_needs(name, modules) & bad)
        if name not in bad and behind:
            yield Finding(
                places[name],
                f"it cannot be reached: it needs {', '.join(behind)}, which cannot be reached",
            )


def _all_needs(name: str, modules: Dict[str, Module]) -> Set[str]:
    found: Set[str] = set()
    waiting = [name]
    while waiting:
        for need in modules[waiting.pop()].needs:
            if need in modules and need not in found:
                found.add(need)
                waiting.append(need)
    return found


def _circles(modules: Dict[str, Module]) -> List[List[str]]:
    """Each circle of needs once, from its first module in the file on."""
    found: List[List[str]] = []
    seen: Set[str] = set()
    for start in modules:
        if start in seen or start not in _all_needs(start, modules):
            continue
        circle = _way_back(start, modules)
        seen.update(circle)
        found.append(circle)
    return found


def _way_back(start: str, modules: Dict[str, Module]) -> List[str]:
    """Shortest way from a module over needs back to itself."""
    ways = [[start]]
    for way in ways:
        for need in modules[way[-1]].needs:
            if need == start:
                return way
            if need in modules and all(need not in other for other in ways):
                ways.append([*way, need])
    raise AssertionError(f"{start} is in no circle")
