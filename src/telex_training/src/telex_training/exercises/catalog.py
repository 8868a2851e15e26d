"""Catalogue of exercises: the shipped ones, and the folders of ``TELEX_EXERCISE_PATH``."""

from __future__ import annotations

import difflib
import os
from pathlib import Path
from typing import Dict, List

import rospkg

from .exercise_file import SUFFIX, ExerciseError

PATH_VARIABLE = "TELEX_EXERCISE_PATH"
"""Environment variable with further folders, separated by colons; they come first."""


def exercise_folders() -> List[Path]:
    """Folders in which exercises are looked up by name, first come, first served."""
    given = [Path(part) for part in os.environ.get(PATH_VARIABLE, "").split(os.pathsep) if part]
    shipped = Path(rospkg.RosPack().get_path("telex_training"), "exercises")
    return [*given, shipped]


def exercises() -> Dict[str, Path]:
    """All exercises that have a name, and their files."""
    found: Dict[str, Path] = {}
    for folder in exercise_folders():
        for path in sorted(folder.glob(f"*{SUFFIX}")):
            found.setdefault(path.stem, path)
    return found


def find_exercise(name: str) -> Path:
    """Find the file of an exercise.

    Parameters
    ----------
    name : str
        Its name, or a path: what has a slash or ends in ``.yaml``.

    Raises
    ------
    ExerciseError
        There is none; the message says which there are.
    """
    if "/" in name or name.endswith(SUFFIX):
        path = Path(name).expanduser()
        if not path.is_file():
            start = "" if path.is_absolute() else f" (a relative path starts from {Path.cwd()})"
            raise ExerciseError(f"{path}: there is no such file{start}")
        return path
    known = exercises()
    if name not in known:
        near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
        names = near + [other for other in known if other not in near]
        raise ExerciseError(
            f"there is no exercise '{name}'; there are: {', '.join(names)}; or give a file's path"
        )
    return known[name]
