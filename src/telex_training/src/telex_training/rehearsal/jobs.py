"""Rehearsed trials as jobs: plain data in, plain data out, the same on any machine."""

from __future__ import annotations

import hashlib
import importlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple
from xml.etree import ElementTree

from telex_control.common.file_catalog import package_path
from telex_sim.scene.robot_in_scene import robot_description

from ..exercises.exercise_file import ExerciseFile, parse_exercise
from ..exercises.seeds import scene_text
from ..operators.experts.brief import Expert
from ..operators.experts.catalog import EXPERTS
from .figures import spread
from .trial import RehearsedTrial, rehearse_to_end

SCRIPTED = "scripted"
"""Name of the operator that is the exercise's own expert."""
_SOURCES = (".py", ".yaml", ".xacro", ".urdf", ".obj", ".stl", ".msg", ".srv")
_PACKAGES = ("telex_control", "telex_description", "telex_sim", "telex_teleop", "telex_training")


class OperatorError(ValueError):
    """There is no such operator; the message says why, and what there is."""


@dataclass(frozen=True)
class Job:
    """One trial to rehearse.

    Attributes
    ----------
    path : str
        Of the exercise's file, for messages.
    text : str
        Of the exercise's file: machines that help need not have it.
    operator : str
        `SCRIPTED`, or ``MODULE:FUNCTION``.
    line : str
        Profile of the line to the robot; empty: what the exercise asks for.
    """

    path: str
    text: str
    setting: str
    seed: int
    operator: str = SCRIPTED
    line: str = ""


@dataclass(frozen=True)
class Rehearsed:
    """What a job comes to.

    Attributes
    ----------
    sheet : str
        Text of the score sheet, which holds nothing of the wall clock.
    gave_up : str
        Why the operator gave up; empty: he did not.
    """

    sheet: str
    gave_up: str = ""


def run(job: Job) -> Rehearsed:
    """Rehearse a trial, and return what it comes to."""
    trial, problem = rehearse_job(job)
    return Rehearsed(trial.judge.text(), problem)


def rehearse_job(job: Job) -> Tuple[RehearsedTrial, str]:
    """Rehearse a trial; see `rehearse_to_end`."""
    file = parse_exercise(job.text, Path(job.path))
    exercise = spread(file.setting(job.setting))
    operator = find_operator(job.operator, exercise.name)
    return rehearse_to_end(exercise, operator, job.seed, job.line)


def find_operator(name: str, exercise: str) -> Expert:
    """Find the operator of an exercise.

    Parameters
    ----------
    name : str
        `SCRIPTED`, or ``MODULE:FUNCTION`` of a function that takes a `Hand` and a `Brief`.
    exercise : str
        Name.

    Raises
    ------
    OperatorError
    """
    if name == SCRIPTED:
        if exercise not in EXPERTS:
            raise OperatorError(
                f"{exercise} has no scripted operator; these have: {', '.join(sorted(EXPERTS))}; "
                "or give --operator MODULE:FUNCTION"
            )
        return EXPERTS[exercise]
    module, _, function = name.partition(":")
    if not module or not function:
        raise OperatorError(f"operator is '{name}'; {SCRIPTED} or MODULE:FUNCTION is needed")
    try:
        found = getattr(importlib.import_module(module), function)
    except Exception as error:  # whatever a user's module does when it is imported
        raise OperatorError(f"operator '{name}': {type(error).__name__}: {error}") from error
    if not callable(found):
        raise OperatorError(f"operator '{name}': it is no function")
    return found


def exercise_digest(file: ExerciseFile) -> str:
    """SHA-256 over an exercise's file, and the scenes and robots of its settings.

    Raises
    ------
    ExerciseError, ConfigError
        There is no such scene or robot.
    """
    digest = hashlib.sha256(file.text.encode())
    for setting in file.settings:
        exercise = file.setting(setting)
        # A seed moves what the file says; any one shows what the scene's own file has.
        digest.update(scene_text(exercise, 0).encode())
        for variant in (exercise.variant, *(each.variant for each in exercise.robots)):
            # Its comments say where the checkout stands.
            model = ElementTree.canonicalize(robot_description(variant)) if variant else ""
            digest.update(model.encode())
    return digest.hexdigest()


def software_digest(operator: str = SCRIPTED) -> str:
    """SHA-256 over the sources that a trial's outcome depends on.

    They are those of this checkout, and the module of an operator that can be found.
    """
    digest = hashlib.sha256()
    if operator != SCRIPTED:
        source = importlib.import_module(operator.partition(":")[0]).__file__
        digest.update(Path(source).read_bytes() if source else b"")
    for package in _PACKAGES:
        root = Path(package_path(package))
        for path in _sources(root):
            digest.update(f"{package}/{path.relative_to(root).as_posix()}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _sources(root: Path) -> Tuple[Path, ...]:
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(
            set(folders) - {"test", "node_modules", "__pycache__", "pages", "exercises"}
        )
        found += [Path(folder, name) for name in sorted(names) if name.endswith(_SOURCES)]
    return tuple(found)
