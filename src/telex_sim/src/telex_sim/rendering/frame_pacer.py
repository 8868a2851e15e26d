"""When a camera's next picture is due."""

from __future__ import annotations

import math
from typing import Optional


class FramePacer:
    """Paces one camera in wall time, without ever building up a backlog.

    Time is cut into slots of 1/rate, the same for all cameras of one rate, so that they share
    poses and shadows. A slot gets at most one picture, of the first poses that are seen in it:
    those are fresh, and what was missed is never made up for. Poses that have had their picture
    get another one only when nothing newer comes (the simulation is paused): then, at a low rate,
    so that somebody who looks in sees something.

    Parameters
    ----------
    rate
        Pictures per second of wall time.
    repeat_rate
        Pictures per second while the poses stand still.
    """

    def __init__(self, rate: float, repeat_rate: float) -> None:
        self._rate = rate
        self._repeat_period = 1.0 / min(repeat_rate, rate)
        self._slot: Optional[int] = None
        self._stamp: Optional[int] = None
        self._sent = -math.inf

    def is_due(self, now: float, stamp: int) -> bool:
        """Whether to take a picture now.

        Parameters
        ----------
        now
            Monotonic wall time (s).
        stamp
            Sim time of the newest poses (ns); may jump back when the simulation restarts.
        """
        if math.floor(now * self._rate) == self._slot:
            return False
        return stamp != self._stamp or now - self._sent >= self._repeat_period

    def sent(self, now: float, stamp: int) -> None:
        """Note that a picture of the poses of ``stamp`` was taken at ``now``."""
        self._slot = math.floor(now * self._rate)
        self._stamp = stamp
        self._sent = now
