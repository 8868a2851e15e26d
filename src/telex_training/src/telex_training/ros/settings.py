"""Parameters of the training node; config/training.yaml has their defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from telex_control.common.params import require_choice, require_range, require_text

from ..exercises.model import MODES
from ..recording.trial_file import FOLDER


@dataclass(frozen=True)
class TrainingSettings:
    """What the node is told.

    Attributes
    ----------
    folder : str
        For the recordings; ``~`` is the home of the station's user.
    exercise, setting, mode, operator : str
        Opened at the start; without an exercise, none is.
    state_rate : float
        How often the state is told while a trial runs (1/s of sim time).
    away : float
        Sim time for which nobody may have control before the trial counts as abandoned (s); 0:
        for ever.
    recorded : tuple of str
        Topics that are recorded beside commands, states and truth.
    port : int
        Of the pages' handler, on 127.0.0.1; 0: any free one.
    bridge : str
        Node that holds an exam's list.
    video_server : str
        Node at which the pages are mounted; empty: nowhere.
    retention : float
        Days after which recordings and exports are removed; 0: never.
    """

    folder: str = FOLDER
    exercise: str = ""
    setting: str = ""
    mode: str = "practice"
    operator: str = ""
    state_rate: float = 5.0
    away: float = 30.0
    recorded: Tuple[str, ...] = ()
    port: int = 0
    bridge: str = "rosbridge"
    video_server: str = "video_server"
    retention: float = 0.0

    def __post_init__(self) -> None:
        require_choice(self, "mode", MODES)
        require_range(self, "state_rate", 0.1, 50.0)
        require_range(self, "away", 0.0, 3600.0)
        require_text(self, "bridge")
        require_range(self, "port", 0, 65535)
        require_range(self, "retention", 0.0, 36500.0)
