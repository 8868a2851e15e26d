"""Tells when a robot is about to tip over, has tipped over, or is stuck. Knows no PyBullet."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Deque, Iterable, List, NamedTuple, Optional, Sequence, Tuple

from telex_control.common.stateful import Stateful

from .force_angle import StabilityConfig
from .tipping import TippingAngle

Vector = Tuple[float, float, float]


class TipOverWarning(Stateful):
    """Warns before a robot tips over, and not of impacts or of rocking from edge to edge.

    A robot that climbs rocks over its nose and rear, and comes to rest within half a second; over
    its sides it does not rock. So a small angle counts sideways at once, ahead when it lasts; and
    sideways what would be left in a while counts, if the robot went on turning as it does.

    Attributes
    ----------
    direction : float
        Where the robot would tip, in its x-y plane (rad): of the last warning.
    margin : float
        Force-angle measure, smoothed: its mean, with weights that decay with `smoothing_time`.
    """

    SAVED = ("direction", "margin", "warned")
    SAVED_TIMES = ("_clear", "_last")

    def __init__(self, config: StabilityConfig) -> None:
        self._config = config
        self._last: Optional[float] = None
        self._since: List[Optional[float]] = [None, None]
        self._clear: Optional[float] = None
        self.warned = False
        self.direction = 0.0
        self.margin = 0.0

    def update(
        self,
        time: float,
        tipping: Optional[TippingAngle],
        margin: float,
        turning: Tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Take the state at `time` (s), later than the last.

        Parameters
        ----------
        tipping : TippingAngle, optional
            None where nothing carries the robot.
        turning : tuple of 2 floats
            Of the robot about its x and y axis (rad/s).
        """
        config = self._config
        gap = math.inf if self._last is None else time - self._last
        if gap <= 0.0:
            return
        self._last = time
        if gap > _FORGOTTEN:
            # Nobody has looked for a while: what was then says nothing of now.
            self._since, self._clear, self.warned, self.margin = [None, None], None, False, margin
        share = 1.0 - math.exp(-gap / config.smoothing_time) if config.smoothing_time else 1.0
        self.margin += share * (margin - self.margin)
        ahead, sideways, *directions = tipping or _IN_THE_AIR
        about_x, about_y = turning
        rate = about_y * math.cos(directions[1]) - about_x * math.sin(directions[1])
        left = sideways - max(0.0, rate) * config.warning_sideways_foresight
        lasting = [
            self._lasts(0, time, ahead < config.warning_ahead, config.warning_ahead_time),
            self._lasts(1, time, left < config.warning_sideways, config.warning_sideways_time),
        ]
        if any(lasting):
            self.warned, self._clear = True, None
            if tipping is not None:
                aside = lasting[1] and (sideways < ahead or not lasting[0])
                self.direction = directions[int(aside)]
        elif self.warned and self._since == [None, None]:
            self._clear = time if self._clear is None else self._clear
            self.warned = time - self._clear < config.warning_hold
        else:
            self._clear = None

    def save_state(self) -> Any:
        """Return the present state; see `Stateful.save_state`."""
        return super().save_state(), list(self._since)

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        state, since = saved
        super().restore_state(state, elapsed)
        self._since = [None if time is None else time + elapsed for time in since]

    def _lasts(self, side: int, time: float, little: bool, patience: float) -> bool:
        """Whether little has been left on a side for so long."""
        since = self._since[side]
        self._since[side] = since = (time if since is None else since) if little else None
        return since is not None and time - since >= patience - _ROUNDING


_IN_THE_AIR = TippingAngle(-math.inf, math.inf, 0.0, 0.0)
_FORGOTTEN = 0.5
"""Time (s) without a look after which a warning begins anew."""
_ROUNDING = 1e-6


class TipOverDetector(Stateful):
    """Tells that a robot lies on its side or back: it is tilted far, and stays so."""

    SAVED = ("tipped",)
    SAVED_TIMES = ("_since",)

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
    """Where the robot was (m, rad), and how far each belt had been told to run (m, signed)."""

    time: float
    place: Vector
    turned: float
    ways: Tuple[float, ...]


class StuckDetector(Stateful):
    """Tells that the belts of a robot are told to run, but do not get it away.

    It compares ranges: the longest stretch of way that a belt is told to run over, with the room
    that the robot takes up while it moves and turns. So an operator who goes to and fro is told to
    be stuck only if the robot does not follow.

    Parameters
    ----------
    half_gauge : float
        Half the distance of the belts (m): a turn moves them along by so much for a radian.
    """

    SAVED = ("_heading", "_samples", "_turned", "stuck")

    def __init__(self, config: StabilityConfig, half_gauge: float) -> None:
        self._config = config
        self._half_gauge = half_gauge
        self._samples: Deque[_Sample] = deque()
        self._turned = 0.0
        self._heading: Optional[float] = None
        self.stuck = False

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        super().restore_state(saved, elapsed)
        self._samples = deque(each._replace(time=each.time + elapsed) for each in self._samples)

    def update(self, time: float, place: Vector, heading: float, speeds: Sequence[float]) -> None:
        """Take the robot's state at `time` (s).

        Parameters
        ----------
        place : Vector
            Of the robot (m).
        heading : float
            (rad)
        speeds : sequence of float
            That each belt is told to run at (m/s, signed), always in the same order; 0 while its
            brake holds.
        """
        samples, config = self._samples, self._config
        if self._heading is not None:
            self._turned += math.remainder(heading - self._heading, 2.0 * math.pi)
        self._heading = heading
        if all(abs(speed) < config.stuck_speed for speed in speeds):
            samples.clear()
            self.stuck = False
            return
        ways = tuple(0.0 for _ in speeds)
        if samples:
            last = samples[-1]
            ways = tuple(way + speed * (time - last.time) for way, speed in zip(last.ways, speeds))
        samples.append(_Sample(time, place, self._turned, ways))
        # The oldest sample is the youngest of those that are old enough.
        while len(samples) > 1 and time - samples[1].time >= config.stuck_time:
            samples.popleft()
        if time - samples[0].time < config.stuck_time:
            self.stuck = False
            return
        told = max(_range(ways) for ways in zip(*(sample.ways for sample in samples)))
        moved = math.hypot(*(_range(axis) for axis in zip(*(sample.place for sample in samples))))
        moved += self._half_gauge * _range([sample.turned for sample in samples])
        self.stuck = moved < config.stuck_ratio * told


def _range(values: Iterable[float]) -> float:
    values = tuple(values)
    return max(values) - min(values)
