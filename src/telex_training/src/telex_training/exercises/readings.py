"""Charts and pipes of an exercise, drawn anew for each repetition; the judge alone is told."""

from __future__ import annotations

from typing import Dict, NamedTuple

import yaml

from telex_sim.scene.sealed import new_token

from .model import Exercise
from .questions import named_entries, read_objects, right_answers
from .seeds import scene_text


class Drawn(NamedTuple):
    """A scene in which everything that is to be read is drawn anew.

    Attributes
    ----------
    scene : str
        Its text.
    entries : dict of str to str
        What is to be read, as entries for ``sim/spawn`` (YAML), by their names.
    answers : dict of str to str
        The right ones, by question.
    """

    scene: str
    entries: Dict[str, str]
    answers: Dict[str, str]


def draw(exercise: Exercise, seed: int) -> Drawn:
    """Draw what the objects of an exercise's questions show.

    The seed decides where things stand, and nothing of what is to be read.

    Raises
    ------
    ExerciseError
        An object is not in the scene, or there is nothing on it to read.
    """
    wanted = read_objects(exercise)
    scene = scene_text(exercise, seed, sealed={name: new_token() for name in wanted})
    entries = {}
    if wanted:
        for name, entry in named_entries(scene).items():
            if name in wanted:
                entries[name] = str(yaml.safe_dump(entry, default_flow_style=True))
    return Drawn(scene, entries, right_answers(exercise, scene))
