"""State of one station, as its answers come and stay away; without a clock or a network."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Dict, Optional

from .answers import StationState
from .stations_file import ClassStation

PERIOD = 1.0
"""Between two questions for the state (s)."""
LONGEST_PERIOD = 5.0
"""Between two attempts to reach a station that is gone (s)."""
PICTURE_PERIOD = 2.0
"""Between two pictures (s)."""
DRAWN_PERIOD = 10.0
"""Between two pictures that are drawn for the page alone (s). Until the station's renderer hears
that nobody looks any more it draws a few of them, and no more than 0.5 a second shall be caused."""
ENDED = "ended"

CONNECTING, HERE, GONE = "connecting", "here", "gone"
"""Of a station: not heard of yet; it answers; it does not, or not any more."""


@dataclass(frozen=True)
class StationPicture:
    """A station's last picture.

    Attributes
    ----------
    number : int
        Counts up.
    kind : str
        Its media type.
    """

    number: int
    kind: str
    data: bytes


class StationWatch:
    """A station as the page shows it. Times are monotonic (s).

    Attributes
    ----------
    order : dict or None
        What was asked of it last, and what came of it: ``what``, ``done``, ``ok``, ``text``.
    """

    def __init__(self, station: ClassStation, now: float) -> None:
        self.station = station
        self.phase = CONNECTING
        self.state: Optional[StationState] = None
        self.picture: Optional[StationPicture] = None
        self.order: Optional[Dict[str, Any]] = None
        self._since = self._heard = now
        self._failures = 0
        self._reason = ""
        self._last: Optional[Dict[str, Any]] = None
        self._pictured = 0.0
        self._drawn = -DRAWN_PERIOD

    def answered(self, now: float, state: StationState) -> None:
        """Take a state."""
        if self.phase != HERE:
            self.phase, self._since = HERE, now
        self.state, self._heard, self._failures, self._reason = state, now, 0, ""
        if state.phase == ENDED:
            keys = ("trial", "title", "setting", "mode", "operator", "valid", "verdict", "results")
            self._last = {key: getattr(state, key) for key in keys}

    def failed(self, now: float, reason: str) -> None:
        """Note that no answer came, or none that makes sense."""
        if self.phase != GONE:
            # It may have gone at any time since it was heard last.
            self.phase, self._since = GONE, self._heard
        self._failures += 1
        self._reason = reason

    def pause(self) -> float:
        """Time until the next question (s): the longer, the longer nobody has answered."""
        return min(PERIOD * 2.0 ** max(self._failures - 1, 0), LONGEST_PERIOD)

    def camera(self, main_camera: str) -> str:
        """Camera whose pictures are shown: what the trainee looks at, if that is known."""
        return (self.state.view if self.state is not None else "") or main_camera

    def may_have_drawn(self, now: float) -> bool:
        """Whether a picture may be drawn for the page, and count it if so."""
        if now - self._drawn < DRAWN_PERIOD:
            return False
        self._drawn = now
        return True

    def pictured(self, now: float, kind: str, data: bytes) -> None:
        """Take a picture."""
        number = 1 if self.picture is None else self.picture.number + 1
        self.picture, self._pictured = StationPicture(number, kind, data), now

    def shown(self, now: float) -> Dict[str, Any]:
        """What the page is told; nothing of the token. Times are so many seconds ago."""
        picture = self.picture
        return {
            "name": self.station.name,
            "phase": self.phase,
            "since": round(now - self._since, 1),
            "age": round(now - self._heard, 1),
            "reason": self._reason,
            "state": None if self.state is None else asdict(self.state),
            "last": self._last,
            "picture": None if picture is None else picture.number,
            "picture_age": None if picture is None else round(now - self._pictured, 1),
            "order": self.order,
        }
