"""An exercise that is to be opened on several stations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict

from telex_control.common.params import require, require_choice, require_text
from telex_teleop.web.tokens import MAX_NAME

from ..exercises.model import MODES


@dataclass(frozen=True)
class Order:
    """What is to be opened, and for whom.

    Attributes
    ----------
    stations : dict of str to str
        Trainee of each station, by its name.
    start : bool
        Whether its trial begins at once; otherwise the trainee reads the brief first.
    """

    stations: Dict[str, str]
    exercise: str
    setting: str = ""
    mode: str = MODES[0]
    start: bool = False

    def __post_init__(self) -> None:
        require_text(self, "exercise")
        require_choice(self, "mode", MODES)
        require(bool(self.stations), "stations is {}; one station at least is needed")
        for station, name in self.stations.items():
            require(
                0 < len(name.strip()) <= MAX_NAME and name.isprintable(),
                f"stations/{station[:60]} is {name[:60]!r}; the trainee's name is needed: 1 to "
                f"{MAX_NAME} printable characters",
            )

    @property
    def words(self) -> str:
        """The order, for people."""
        return ", ".join(part for part in (self.exercise, self.setting, self.mode) if part)

    def content(self, station: str) -> Dict[str, Any]:
        """What a station is sent."""
        return {
            "exercise": self.exercise,
            "setting": self.setting,
            "mode": self.mode,
            "operator": self.stations[station].strip(),
            "start": self.start,
        }
