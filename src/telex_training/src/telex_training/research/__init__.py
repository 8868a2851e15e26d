"""Exercises as environments of Gymnasium, and people's recordings as data sets.

Importing it registers each exercise of the catalogue: ``telex/Slalom-v0``, ``telex/CubeToBin-v0``.
"""

from __future__ import annotations

import warnings
from contextlib import suppress

from ..exercises.catalog import exercises

ENTRY_POINT = f"{__name__}.environment:ExerciseEnv"


def environment_id(exercise: str) -> str:
    """Return the id of an exercise's environment."""
    words = "".join(word[:1].upper() + word[1:] for word in exercise.split("_"))
    return f"telex/{words}-v0"


def register() -> None:
    """Register all exercises that are there now."""
    import gymnasium  # optional: requirements-research.txt

    for name in exercises():
        identifier = environment_id(name)
        if identifier in gymnasium.registry:
            continue
        try:
            gymnasium.register(identifier, ENTRY_POINT, kwargs={"exercise": name})
        except gymnasium.error.Error as error:
            warnings.warn(f"exercise '{name}' is no environment: {error}", stacklevel=2)


with suppress(ImportError):
    register()
