"""Catalogue of exercises: the shipped ones, and the folders of ``TELEX_EXERCISE_PATH``."""

from __future__ import annotations

from telex_control.common.file_catalog import FileCatalog

from .exercise_file import SUFFIX, ExerciseError

PATH_VARIABLE = "TELEX_EXERCISE_PATH"
"""Environment variable with further folders, separated by colons; they come first."""

_CATALOG = FileCatalog(
    "exercise", PATH_VARIABLE, "telex_training", "exercises", SUFFIX, ExerciseError
)
exercise_folders = _CATALOG.folders
exercises = _CATALOG.files
find_exercise = _CATALOG.find
"""Raises an `ExerciseError`."""
known_exercise = _CATALOG.find_by_name
"""Raises an `ExerciseError`."""
