"""Order in which cameras are served, and the time of each one's next picture."""

from __future__ import annotations

import math
from typing import Optional, Protocol, Sequence, Tuple, TypeVar

OLDEST = 0.6
"""Time since its last picture (s) from which a camera comes before all that have waited less."""


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
        self._repeat_rate = repeat_rate
        self._slot: Optional[int] = None
        self._stamp: Optional[int] = None
        self._sent = -math.inf
        self.rate = rate

    @property
    def rate(self) -> float:
        """Pictures per second of wall time."""
        return self._rate

    @rate.setter
    def rate(self, rate: float) -> None:
        self._rate = rate
        self._repeat_period = 1.0 / min(self._repeat_rate, rate)
        # Slots of another length have other numbers.
        self._slot = None if math.isinf(self._sent) else math.floor(self._sent * rate)

    @property
    def stamp(self) -> Optional[int]:
        """Sim time (ns) of the last picture, None before the first."""
        return self._stamp

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

    def waited(self, now: float) -> float:
        """Time since the last picture (s); infinite before the first."""
        return now - self._sent

    def sent(self, now: float, stamp: int) -> None:
        """Note that a picture of the poses of ``stamp`` was taken at ``now``."""
        self._slot = math.floor(now * self._rate)
        self._stamp = stamp
        self._sent = now


class Paced(Protocol):
    """A camera as far as its turn matters."""

    @property
    def pacer(self) -> FramePacer:
        """Says when its pictures are due."""

    @property
    def weight(self) -> float:
        """By which its rate counts, when there is too little time for all."""


Camera = TypeVar("Camera", bound=Paced)


def next_due(cameras: Sequence[Camera], now: float, stamp: int) -> Optional[Camera]:
    """Choose the camera whose picture comes next, or None when none is due.

    When there is not enough time for all, each gets pictures in the proportion of its rate times
    its weight: those with less weight give way first, and evenly. But none is left to grow old.

    Parameters
    ----------
    cameras
        That somebody looks through.
    now, stamp
        As for `FramePacer.is_due`.
    """

    def urgency(camera: Camera) -> Tuple[float, float]:
        pacer = camera.pacer
        waited = pacer.waited(now)
        return (waited if waited > OLDEST else 0.0, waited * pacer.rate * camera.weight)

    due = [camera for camera in cameras if camera.pacer.is_due(now, stamp)]
    return max(due, key=urgency) if due else None
