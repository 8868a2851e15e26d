"""Tells when a robot has tipped over, and when it is stuck. Knows nothing of PyBullet."""

from __future__ import annotations

import math
from collections import deque
from typing import Deque, NamedTuple, Optional, Tuple

from .stability import StabilityConfig

Vector = Tuple[float, float, float]


class TipOverDetector:
    """Tells that a robot lies on its side or back: it is tilted far, and stays so.

    Attributes
    ----------
    tipped : bool
    """

    def __init__(self, config: StabilityConfig) -> None:
        self._config = config
        self._since: Optional[float] = None
        self.tipped = False

    def update(self, time: float, tilt: float) -> None:
        """Take the angle (rad) between the robot's z axis and the vertical at `time` (s)."""
        if tilt <= self._config.tipped_angle:
            self._since = None
            self.tipped = False
            return
        if self._since is None:
            self._since = time
        self.tipped = time - self._since >= self._config.tipped_time


class _Sample(NamedTuple):
    """Where the robot was (m, rad) and how far its belts had been told to run (m)."""

    time: float
    place: Vector
    turned: float
    way: float


class StuckDetector:
    """Tells that the belts of a robot are told to run, but do not get it away.

    It compares the way that the belts are told to run with what the robot does: how far it gets,
    or how far it turns.

    Parameters
    ----------
    config : StabilityConfig
    half_gauge : float
        Half the distance of the belts (m): a turn moves them along by so much for a radian.

    Attributes
    ----------
    stuck : bool
    """

    def __init__(self, config: StabilityConfig, half_gauge: float) -> None:
        self._config = config
        self._half_gauge = half_gauge
        self._samples: Deque[_Sample] = deque()
        self._turned = 0.0
        self._heading: Optional[float] = None
        self.stuck = False

    def update(self, time: float, place: Vector, heading: float, speed: float) -> None:
        """Take the robot's state at `time` (s).

        Parameters
        ----------
        place : Vector
            Of the robot (m).
        heading : float
            (rad)
        speed : float
            That its fastest belt is told to run at (m/s), whatever its sign; 0 while brakes hold.
        """
        samples, config = self._samples, self._config
        if self._heading is not None:
            self._turned += math.remainder(heading - self._heading, 2.0 * math.pi)
        self._heading = heading
        if speed < config.stuck_speed:
            samples.clear()
            self.stuck = False
            return
        way = 0.0
        if samples:
            last = samples[-1]
            way = last.way + speed * (time - last.time)
        samples.append(_Sample(time, place, self._turned, way))
        # The oldest sample is the youngest of those that are old enough.
        while len(samples) > 1 and time - samples[1].time >= config.stuck_time:
            samples.popleft()
        first = samples[0]
        if time - first.time < config.stuck_time:
            self.stuck = False
            return
        moved = math.dist(place, first.place)
        moved += self._half_gauge * abs(self._turned - first.turned)
        self.stuck = moved < config.stuck_ratio * (way - first.way)
