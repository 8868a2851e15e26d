"""Parameters of the replay node; config/replay.yaml has their defaults."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import require_range


@dataclass(frozen=True)
class ReplaySettings:
    """What the node is told.

    Attributes
    ----------
    folder : str
        Of the recordings; ``~`` is the home of the station's user.
    file : str
        One recording that is opened at the start, and that whoever gets into the video server may
        see; empty: none, and trials are their operators' and the instructors'.
    niceness : int
        By how much what draws steps back for others, 0 to 19.
    busy_period : float
        Time between two pictures while a trial runs on the machine (s).
    idle : float
        Time (s) after which what draws is ended when nobody looks.
    port : int
        Of the pages' handler, on 127.0.0.1; 0: any free one.
    video_server : str
        Node at which the pages are mounted; empty: nowhere.
    """

    folder: str = "~/.ros/telex_training"
    file: str = ""
    niceness: int = 19
    busy_period: float = 0.5
    idle: float = 120.0
    port: int = 0
    video_server: str = "video_server"

    def __post_init__(self) -> None:
        require_range(self, "niceness", 0, 19)
        require_range(self, "busy_period", 0.0, 60.0)
        require_range(self, "idle", 1.0, 86400.0)
        require_range(self, "port", 0, 65535)
