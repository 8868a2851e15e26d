"""Pictures under way on the line, of all cameras that one client watches."""

from __future__ import annotations

import collections
import dataclasses
import math
from typing import Deque, Dict, Generic, Hashable, List, Optional, Tuple, TypeVar

from .line import Line
from .line_queue import BACKWARDS

Picture = TypeVar("Picture")

MOST_BYTES = 32 * 2**20
"""Pictures that may be under way to one client (bytes); the oldest are lost first."""

OLDEST, NEWEST = 2.0, 0.2
"""Time (s) by which a stamp may lie back, and ahead of a clock that is read late."""


@dataclasses.dataclass
class _UnderWay(Generic[Picture]):
    camera: Hashable
    picture: Picture
    size: int
    due: float


@dataclasses.dataclass
class _Waiting(Generic[Picture]):
    picture: Picture
    size: int
    stamp: float
    came: float


class PictureLine(Generic[Picture]):
    """Holds the pictures of one client back until they have passed the line.

    A picture arrives when its stamp is as old as the line's delay, not before. Under a cap of the
    bandwidth one is sent at a time; meanwhile the newest of each camera waits, and cameras take
    turns. In an outage all are lost but the newest ones, which are sent when it ends.
    """

    def __init__(self, line: Line, most_bytes: int = MOST_BYTES) -> None:
        self._line = line
        self._most_bytes = most_bytes
        self._version = line.version
        self._waiting: Dict[Hashable, _Waiting[Picture]] = {}
        self._under_way: Deque[_UnderWay[Picture]] = collections.deque()
        self._free = -math.inf
        self._opens = -math.inf
        self._latest = -math.inf
        self.bytes = 0

    @property
    def passes(self) -> bool:
        """Whether a picture would arrive at once; it need not be offered to this line then."""
        return self._line.is_perfect and not self._under_way and not self._waiting

    def offer(
        self, camera: Hashable, picture: Picture, size: int, stamp: float, now: float
    ) -> None:
        """Send a picture.

        Parameters
        ----------
        camera
            Whose it is.
        size
            Its size (bytes).
        stamp
            When it was taken (s).
        now
            The time (s).
        """
        self._follow(now)
        if self._line.reopens(now) <= now and self._line.loses_by_chance():
            return
        # A stamp of another clock, or of a picture that is sent again, tells nothing of its age.
        stamp = stamp if now - OLDEST <= stamp <= now + NEWEST else now
        # In the place of the one before, which has had to wait for longer.
        self._waiting[camera] = _Waiting(picture, size, stamp, now)
        self._transmit(now)

    def forget(self, camera: Hashable) -> None:
        """Let go of all pictures of a camera, which nobody watches any more."""
        self._waiting.pop(camera, None)
        self._under_way = collections.deque(
            each for each in self._under_way if each.camera != camera
        )
        self.bytes = sum(each.size for each in self._under_way)

    def take(self, now: float) -> List[Tuple[Hashable, Picture]]:
        """Return the pictures that have arrived by a time (s), with their cameras."""
        self._follow(now)
        self._transmit(now)
        arrived = []
        while self._under_way and self._under_way[0].due <= now:
            first = self._under_way.popleft()
            self.bytes -= first.size
            arrived.append((first.camera, first.picture))
        return arrived

    def next_due(self, now: float) -> Optional[float]:
        """Return when (s) `take` may return something, or has to be called; None: by no time."""
        times = [self._under_way[0].due] if self._under_way else []
        if self._waiting:
            times.append(max(self._free, self._line.reopens(now)))
        return min(times) if times else None

    def _transmit(self, now: float) -> None:
        """Send what waits, as far as the line takes it."""
        while self._waiting and self._free <= now:
            opens = self._line.reopens(now)
            if opens > now:
                self._opens = opens
                return
            camera = next(iter(self._waiting))
            waiting = self._waiting.pop(camera)
            sent = max(waiting.came, min(self._opens, now))
            bandwidth = self._line.fields.bandwidth
            if bandwidth:
                sent = self._free = max(self._free, sent) + 8.0 * waiting.size / bandwidth
            due = waiting.stamp + self._line.draw_delay() + sent - waiting.came
            if self._under_way:
                due = max(due, self._under_way[-1].due)
            self._under_way.append(_UnderWay(camera, waiting.picture, waiting.size, due))
            self.bytes += waiting.size
        if not self._waiting:
            self._opens = -math.inf
        while self.bytes > self._most_bytes and len(self._under_way) > 1:
            self.bytes -= self._under_way.popleft().size

    def _follow(self, now: float) -> None:
        if now < self._latest - BACKWARDS:
            self._under_way.clear()
            self._waiting.clear()
            self.bytes, self._free = 0, -math.inf
        self._latest = now
        if self._version != self._line.version:
            self._version = self._line.version
            self._free = min(self._free, now)
