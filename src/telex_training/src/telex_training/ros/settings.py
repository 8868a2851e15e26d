"""Parameters of the training node; config/training.yaml has their defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from telex_control.common.params import Declared, choice, number, parameter, word

from ..exercises.model import MODES
from ..recording.trial_file import FOLDER


@dataclass(frozen=True)
class TrainingSettings(Declared):
    """What the node is told."""

    folder: str = parameter(FOLDER, "For the recordings; ``~`` is the home of the station's user.")
    exercise: str = parameter("", "Opened at the start; empty: none is.")
    setting: str = parameter("", "Of this exercise.")
    mode: str = choice("practice", MODES, "In which it is opened.")
    operator: str = parameter("", "For whom it is opened.")
    state_rate: float = number(
        5.0, "How often the state is told while a trial runs (1/s of sim time).", 0.1, 50.0
    )
    away: float = number(
        30.0,
        "Sim time for which nobody may have control before the trial counts as "
        "abandoned (s); 0: for ever.",
        0.0,
        3600.0,
    )
    recorded: Tuple[str, ...] = parameter(
        (), "Topics that are recorded beside commands, states and truth."
    )
    others: Tuple[str, ...] = parameter(
        (), "Further robots of the station, by name, in the order of its launch arguments."
    )
    port: int = number(0, "Of the pages' handler, on 127.0.0.1; 0: any free one.", 0, 65535)
    bridge: str = word("rosbridge", "Node that holds an exam's list.")
    video_server: str = parameter(
        "video_server", "Node at which the pages are mounted; empty: nowhere."
    )
    retention: float = number(
        0.0, "Days after which recordings and exports are removed; 0: never.", 0.0, 36500.0
    )
