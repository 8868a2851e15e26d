"""Figures of a step response: rise, overshoot, settling, error and effort."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np

SETTLING_BAND = 0.02
"""Share of the step within which a response counts as settled."""

REST_TIME = 0.5
"""The end of a recording (s) over which the error is averaged and oscillation is looked for."""


class StepRecordingError(ValueError):
    """A recording has no step, or too little of it; the message says what is missing."""


@dataclass(frozen=True)
class StepRecording:
    """What a joint did, from a little before its reference stepped.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Rising (s); 0 is when the reference stepped.
    positions : ndarray, shape (n,)
        Measured (rad, m).
    efforts : ndarray, shape (n,)
        Of the drive (Nm, N).
    start, target : float
        The reference before and after the step (rad, m).
    """

    times: np.ndarray
    positions: np.ndarray
    efforts: np.ndarray
    start: float
    target: float

    def __post_init__(self) -> None:
        count = len(self.times)
        if len(self.positions) != count or len(self.efforts) != count:
            raise StepRecordingError(
                f"{count} times, {len(self.positions)} positions and {len(self.efforts)} efforts; "
                "they must be equally many"
            )
        if self.start == self.target:
            raise StepRecordingError(f"the reference stays at {self.start}; there is no step")
        after = int(np.count_nonzero(self.times >= 0.0))
        if after < 2 or not self.times[-1] >= REST_TIME:
            raise StepRecordingError(
                f"{after} samples up to {self.times[-1] if count else 0.0:.3f} s after the step; "
                f"at least {REST_TIME} s are needed"
            )


@dataclass(frozen=True)
class StepFigures:
    """Figures of one step response.

    Attributes
    ----------
    rise_time : float
        From 10 % to 90 % of the step (s); NaN when 90 % is not reached.
    overshoot : float
        Beyond the target, in % of the step.
    settling_time : float
        After which the response stays within 2 % of the step about the target (s); NaN when it
        does not.
    steady_state_error : float
        Target minus response, mean over the last `REST_TIME` (rad, m).
    oscillation : float
        Half the distance from peak to peak, about a straight line, over the last `REST_TIME`
        (rad, m).
    peak_effort : float
        Largest amount (Nm, N).
    """

    rise_time: float
    overshoot: float
    settling_time: float
    steady_state_error: float
    oscillation: float
    peak_effort: float


def analyse(recording: StepRecording) -> StepFigures:
    """Take the figures of a recording."""
    step = recording.target - recording.start
    after = recording.times >= 0.0
    times = recording.times[after]
    response = (recording.positions[after] - recording.start) / step
    late = times >= times[-1] - REST_TIME
    rest = recording.positions[after][late]
    return StepFigures(
        rise_time=_first_passage(times, response, 0.9) - _first_passage(times, response, 0.1),
        overshoot=100.0 * max(0.0, float(response.max()) - 1.0),
        settling_time=_settling_time(times, response),
        steady_state_error=recording.target - float(rest.mean()),
        oscillation=_oscillation(times[late], rest),
        peak_effort=float(np.abs(recording.efforts[after]).max()),
    )


def _first_passage(times: np.ndarray, response: np.ndarray, level: float) -> float:
    """When the response first reaches a level; NaN when it does not."""
    above = np.flatnonzero(response >= level)
    if not len(above):
        return math.nan
    return _crossing(times, response, int(above[0]), level)


def _settling_time(times: np.ndarray, response: np.ndarray) -> float:
    outside = np.flatnonzero(np.abs(response - 1.0) > SETTLING_BAND)
    if not len(outside):
        return 0.0
    last = int(outside[-1])
    if last + 1 == len(times):
        return math.nan
    level = 1.0 + math.copysign(SETTLING_BAND, response[last] - 1.0)
    return _crossing(times, response, last + 1, level)


def _crossing(times: np.ndarray, response: np.ndarray, index: int, level: float) -> float:
    """When the response crosses a level between the samples before and at `index`."""
    if index == 0:
        return float(times[0])
    before, at = float(response[index - 1]), float(response[index])
    share = (level - before) / (at - before)
    return float(times[index - 1] + share * (times[index] - times[index - 1]))


def _oscillation(times: np.ndarray, positions: np.ndarray) -> float:
    """Half the peak-to-peak amount about the straight line that fits best.

    Slow settling, as an integral term's, is no oscillation.
    """
    line: Tuple[float, ...] = tuple(np.polyfit(times - times[0], positions, 1))
    deviation = positions - np.polyval(line, times - times[0])
    return 0.5 * float(np.ptp(deviation))
