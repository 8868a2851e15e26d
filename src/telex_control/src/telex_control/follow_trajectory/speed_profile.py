"""Speed along a path: from rest to rest, with limited speed and acceleration."""

from __future__ import annotations

import math
from typing import List, Sequence

import numpy as np

from . import FollowTrajectoryError

LONGEST = 3600.0
"""Time (s) within which a path has to be run along: its references are all worked out before."""


class SpeedProfile:
    """The length of a path that is behind at each time.

    Between two stops it speeds up, runs and slows down at constant rates; where the way is too
    short for the whole speed, it slows down as soon as it must.

    Parameters
    ----------
    length : float
        Of the path (m).
    stops : sequence of float
        Lengths within it at which it comes to rest (m).
    speed, acceleration : float
        Limits, above 0 (m/s, m/s^2).

    Attributes
    ----------
    duration : float
        s.

    Raises
    ------
    FollowTrajectoryError
        A limit is not above 0, or so low that it takes longer than `LONGEST`.
    """

    def __init__(
        self, length: float, stops: Sequence[float], speed: float, acceleration: float
    ) -> None:
        for name, value in (("speed", speed), ("acceleration", acceleration)):
            if not (math.isfinite(value) and value > 0.0):
                raise FollowTrajectoryError(f"{name} is {value}; it must be above 0")
        # Without stops it takes at least so long; of tinier limits the peaks below could be 0.
        self._require_time(length, speed, acceleration, length / speed)
        self._require_time(length, speed, acceleration, 2.0 * math.sqrt(length / acceleration))
        ends = [0.0, *stops, length]
        times, lengths, rates = [0.0], [0.0], [0.0]
        for begin, end in zip(ends, ends[1:]):
            way = end - begin
            peak = min(speed, math.sqrt(acceleration * way))
            ramp = peak / acceleration
            steady = way / peak - ramp
            self._add(times, [ramp, steady, ramp])
            lengths += [begin + 0.5 * peak * ramp, end - 0.5 * peak * ramp, end]
            rates += [peak, peak, 0.0]
        self._times = np.array(times)
        self._lengths = np.array(lengths)
        self._rates = np.array(rates)
        self.duration = times[-1]
        self._require_time(length, speed, acceleration, self.duration)

    @staticmethod
    def _require_time(length: float, speed: float, acceleration: float, duration: float) -> None:
        if duration > LONGEST:
            raise FollowTrajectoryError(
                f"speed is {speed:g} and acceleration is {acceleration:g}: the path of "
                f"{length:.2f} m takes {duration:.3g} s; at most {LONGEST:g} s are possible"
            )

    @staticmethod
    def _add(times: List[float], durations: Sequence[float]) -> None:
        for duration in durations:
            times.append(times[-1] + max(duration, 0.0))

    def length(self, time: np.ndarray) -> np.ndarray:
        """Length that is behind at some times (m); before the start 0, after the end all of it."""
        time = np.clip(np.asarray(time, dtype=float), 0.0, self.duration)
        part = np.clip(
            np.searchsorted(self._times, time, side="right") - 1, 0, len(self._times) - 2
        )
        since = time - self._times[part]
        span = np.maximum(self._times[part + 1] - self._times[part], 1e-12)
        change = (self._rates[part + 1] - self._rates[part]) / span
        return self._lengths[part] + (self._rates[part] + 0.5 * change * since) * since
