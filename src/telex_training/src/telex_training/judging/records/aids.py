"""Aids that the operator's page drew, as it told by its telemetry: which, and for how long."""

from __future__ import annotations

import re
from typing import Any, Dict, List

from ..entries import BadEntryError

FIELD = "aids"
"""Of the telemetry: a struct of names, true for a training aid."""
LASER_DOTS = "laser dots"
"""An aid that is light."""
LASERS = ("lamps/laser_left/level", "lamps/laser_left/command")
"""Channels of the lamp that is switched with the other one; old recordings have the second."""
LASER_LINK = "left_laser_link"
"""From where that one shines; on a robot without it, nothing does."""
WORDS = {
    "aim line": "aim line of the tool",
    "compass": "compass",
    "contact marks": "marks of contact and slip",
    "finger gap": "gap of the fingers at the object",
    "guide lines": "guide lines of the tracks",
    "horizon": "horizon",
    LASER_DOTS: "laser dots on the gripper",
    "plan": "plan of where the robot was",
    "proximity": "distances to what is near the arm",
    "proximity guard": "guard that stops the arm before what is near",
    "range": "range to what the tool points at",
    "sound": "sound",
    "zoom factor": "zoom factor",
}
"""What aids are called on the sheet; another one by its own name."""
_NAME = re.compile(r"[a-z][a-z0-9_ ]{0,39}")
_MOST = 40


class AidRecord:
    """Sums for how long each aid was on while something was judged."""

    def __init__(self) -> None:
        self._on: Dict[str, bool] = {}
        self._told = False
        self._seconds: Dict[str, Dict[bool, float]] = {}

    def hear(self, content: Dict[str, Any]) -> None:
        """Hear the telemetry of a page; one that says nothing of aids changes nothing.

        Raises
        ------
        BadEntryError
        """
        if FIELD not in content:
            return
        aids = content[FIELD]
        if not isinstance(aids, dict) or len(aids) > _MOST:
            raise BadEntryError(
                f"{FIELD} is {str(aids)[:40]!r}; a struct of at most {_MOST} names is needed"
            )
        for name, training in aids.items():
            if not _NAME.fullmatch(name) or not isinstance(training, bool):
                raise BadEntryError(
                    f"{FIELD}/{name[:40]} is {str(training)[:40]!r}; a name of small letters, "
                    "digits and spaces, and true for a training aid or false, is needed"
                )
        self._told = True
        lit = {name: kind for name, kind in self._on.items() if name == LASER_DOTS}
        self._on = {**lit, **aids}

    def switch_lasers(self, level: float) -> None:
        """Hear that the lasers of the gripper were switched."""
        self._on.pop(LASER_DOTS, None)
        if level > 0.0:
            self._told = True
            self._on[LASER_DOTS] = False

    def pass_time(self, span: float) -> None:
        """Let time pass (s) that counts."""
        for name, training in self._on.items():
            known = self._seconds.setdefault(name, {})
            known[training] = known.get(training, 0.0) + span

    def sheet(self, robot: str = "") -> Dict[str, List[Dict[str, Any]]]:
        """Return what the sheet says of it; nothing where no page told of aids.

        Parameters
        ----------
        robot : str
            Of a team's further robot, its name, which the sheet says as well.
        """
        if not self._told:
            return {}
        whose = {"robot": robot} if robot else {}
        return {
            FIELD: [
                {
                    **whose,
                    "name": name,
                    "text": WORDS.get(name, name),
                    "training": training,
                    "seconds": seconds,
                }
                for name, kinds in sorted(self._seconds.items())
                for training, seconds in sorted(kinds.items())
                if seconds > 0.0
            ]
        }
