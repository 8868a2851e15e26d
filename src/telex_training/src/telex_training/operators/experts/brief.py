"""Brief of a scripted expert: what he is told of an exercise beforehand."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Mapping

from ..handling import Hand


@dataclass(frozen=True)
class Brief:
    """An exercise as one knows it who has built it up.

    Attributes
    ----------
    entries : mapping of str to mapping
        Of the scene's file, by the objects' names.
    answers : mapping of str to str
        Right ones, by question.
    robot : str
        Which of the exercise's robots is his, where there are several; empty: the first.
    """

    setting: str
    entries: Mapping[str, Mapping[str, Any]]
    answers: Mapping[str, str] = field(default_factory=dict)
    robot: str = ""


Expert = Callable[[Hand, Brief], None]
"""Does one repetition from the start; raises `NotManagedError` where it gives up."""
