"""Validity of a trial: nothing is lost, nobody interferes, the simulation keeps up."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

from ..exercises.model import LINK_FIELDS
from .entries import Entry, decode
from .truth import Sample

SLOW = 0.8
"""Sim time per wall time, below which a stretch is slow."""
LONGEST_SLOW = 1.0
"""Wall time that this may last (s)."""
MOST_SLOW = 0.02
"""Share of an exam's time that may be slow."""
_PIECE = 0.1
_MOST_PIECES = 600
_MOST_SETTINGS = 100


class Continuity:
    """Numbers of entries and samples: tells what is lost, and what began anew."""

    def __init__(self) -> None:
        self.samples = self.gaps = 0
        self._number: Optional[int] = None
        self._sample: Optional[Sample] = None

    def entry(self, number: int) -> Optional[str]:
        """Hear the number of an entry; returns what is wrong with it."""
        before, self._number = self._number, number
        if before is None or number == before + 1:
            return None
        return f"entry {number} follows on entry {before}"

    def sample(self, sample: Sample) -> List[str]:
        """Hear a sample; returns what is wrong with its numbers."""
        before, self._sample = self._sample, sample
        self.samples += 1
        if before is None:
            return []
        wrong = []
        lost = sample.sequence - before.sequence - 1
        if lost > 0:
            self.gaps += lost
            wrong.append("samples of the truth are missing")
        if lost < 0 or sample.time < before.time:
            wrong.append("the simulator began anew")
        return wrong

    def resets(self, sample: Sample) -> bool:
        """Whether the simulator was reset since the sample before; ask before `sample`."""
        return self._sample is not None and sample.resets != self._sample.resets


class Pace:
    """Sim time against wall time, pauses left out.

    At every moment counts the mean over the `LONGEST_SLOW` of wall time around it: simulations stop
    and go.

    Attributes
    ----------
    stretches : list of list of float
        Begin and end of those that were slow (sim time, s).
    worst : float, optional
        Lowest such mean.
    """

    def __init__(self) -> None:
        self.stretches: List[List[float]] = []
        self.worst: Optional[float] = None
        self._window: Deque[Tuple[float, float]] = deque()
        self._middle: Optional[float] = None
        self._is_slow = False
        self._sim = self._wall = self._slow = 0.0
        self._was_paused = self._is_paused = False

    def cut(self) -> None:
        """Leave out the time until the next sample."""
        self._was_paused = True

    def pause(self, paused: bool) -> None:
        """Hear whether the simulation is paused: the wall time meanwhile does not count."""
        self._is_paused = paused
        self._was_paused = self._was_paused or paused

    def sample(self, sim: float, wall: float) -> bool:
        """Take the times of a sample (s); tells whether a slow stretch begins with it."""
        last = self._window[-1] if self._window else None
        if self._was_paused or last is None or wall < last[0] or sim < last[1]:
            self._was_paused = self._is_paused
            self._window.clear()
            self._window.append((wall, sim))
            self._middle, self._is_slow = None, False
            return False
        begins = False
        # Where the simulation stood, the time in between counts like any other.
        pieces = min(_MOST_PIECES, max(1, math.ceil((wall - last[0]) / _PIECE)))
        for i in range(1, pieces + 1):
            share = i / pieces
            begins |= self._advance(
                last[0] + share * (wall - last[0]), last[1] + share * (sim - last[1])
            )
        self._wall += wall - last[0]
        self._sim += sim - last[1]
        return begins

    def _advance(self, wall: float, sim: float) -> bool:
        window = self._window
        window.append((wall, sim))
        while wall - window[1][0] >= LONGEST_SLOW - 1e-6:
            window.popleft()
        begin_wall, begin_sim = window[0]
        span = wall - begin_wall
        if span < LONGEST_SLOW - 1e-6:
            return False
        pace = (sim - begin_sim) / span
        self.worst = pace if self.worst is None else min(self.worst, pace)
        before, self._middle = self._middle, 0.5 * (begin_wall + wall)
        was_slow, self._is_slow = self._is_slow, pace < SLOW
        if not self._is_slow:
            return False
        at = 0.5 * (begin_sim + sim)
        if not was_slow:
            self.stretches.append([at, at])
            return True
        if before is not None:
            self._slow += self._middle - before
        self.stretches[-1][1] = at
        return False

    @property
    def slow_share(self) -> float:
        """Share of the wall time that was slow."""
        return min(1.0, self._slow / self._wall) if self._wall > 0.0 else 0.0

    def figures(self) -> Dict[str, Any]:
        """Mean and worst of sim time per wall time; None where nothing is known."""
        mean = self._sim / self._wall if self._wall > 0.0 else None
        return {"mean": mean, "worst": self.worst if self.worst is not None else mean}


class LightRecord:
    """The light that an instructor has set, through whichever robot's page."""

    def __init__(self) -> None:
        self._known: Optional[Tuple[float, float]] = None

    def take(self, entry: Entry) -> bool:
        """Hear the light; tells whether it is another one than before.

        Raises
        ------
        BadEntryError
        """
        message = decode(entry, "telex_msgs/SceneLight")
        before, self._known = self._known, (float(message.daylight), float(message.lamps))
        return before not in (None, self._known)


class LinkRecord:
    """What the line to the operator was, from its first word that it is impaired.

    Attributes
    ----------
    settings : list of dict
        Times (s), profiles and figures of what it was set to.
    """

    def __init__(self) -> None:
        self.settings: List[Dict[str, Any]] = []
        self._known: Optional[Tuple[str, float]] = None
        self._out = False

    def take(self, entry: Entry) -> Tuple[Optional[Dict[str, Any]], Optional[bool]]:
        """Hear the line's state.

        Returns
        -------
        setting : dict, optional
            What it has been set to, if that was told for the first time.
        outage : bool, optional
            Whether an outage has begun or ended, if one has.

        Raises
        ------
        BadEntryError
        """
        message = decode(entry, "telex_msgs/LinkState")
        key = (str(message.profile), message.since.to_sec())
        setting = None
        if key != self._known and (self.settings or not message.perfect):
            figures = {name: float(getattr(message, name)) for name in LINK_FIELDS}
            told = {name: value for name, value in figures.items() if value}
            setting = {"time": entry.time, "profile": key[0], **told}
            if len(self.settings) < _MOST_SETTINGS:
                self.settings.append(setting)
        self._known = key
        before, self._out = self._out, bool(message.outage)
        return setting, None if before == self._out else self._out
