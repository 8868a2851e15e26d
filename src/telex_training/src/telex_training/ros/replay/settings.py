"""Parameters of the replay node; config/replay.yaml has their defaults."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import Declared, number, parameter


@dataclass(frozen=True)
class ReplaySettings(Declared):
    """What the node is told."""

    folder: str = parameter(
        "~/.ros/telex_training", "Of the recordings; ``~`` is the home of the station's user."
    )
    file: str = parameter(
        "",
        "One recording that is opened at the start, and that whoever gets into the "
        "video server may see; empty: none, and trials are their operators' and the "
        "instructors'.",
    )
    niceness: int = number(19, "By how much what draws steps back for others, 0 to 19.", 0, 19)
    busy_period: float = number(
        0.5, "Time between two pictures while a trial runs on the machine (s).", 0.0, 60.0
    )
    idle: float = number(
        120.0, "Time (s) after which what draws is ended when nobody looks.", 1.0, 86400.0
    )
    port: int = number(0, "Of the pages' handler, on 127.0.0.1; 0: any free one.", 0, 65535)
    video_server: str = parameter(
        "video_server", "Node at which the pages are mounted; empty: nowhere."
    )
