"""Kinds of metrics: their units, which way is better, and how repetitions make one figure.

docs/instructor/exercises.md gives the formulae; `telex_training.judging` measures them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Tuple

MEDIAN, MEAN, WORST = "median", "mean", "worst"
OVERS: Tuple[str, ...] = (MEDIAN, MEAN, WORST)
"""How the figures of several repetitions make one."""

DIGITS = 4
"""Of figures, behind the point; of what a machine computes a little differently nothing is left."""
SURVEYED = ("missed_points", "speed_error", "map_error")
"""Kinds that look at the exercise's survey."""


OF_ALL = ("time", "penalties", "answers", *SURVEYED)
"""Kinds measured in a repetition, and not for each of several robots."""


@dataclass(frozen=True)
class MetricKind:
    """A kind of metric.

    Attributes
    ----------
    unit : str
        Empty: a plain number.
    text : str
        For people.
    over : str
        How repetitions make one figure where the exercise does not say: worst for what is a matter
        of safety.
    of_trial : bool
        Measured over the whole trial, not in each repetition.
    of_object : bool
        It can be asked of one object alone.
    needs_length : bool
        It is a ratio to the length of the expert's path.
    """

    unit: str
    text: str
    more_is_better: bool = False
    over: str = MEDIAN
    of_trial: bool = False
    of_object: bool = False
    needs_length: bool = False


KINDS: Dict[str, MetricKind] = {
    "time": MetricKind("s", "time of a repetition with its penalties"),
    "penalties": MetricKind("", "penalties", over=WORST),
    "answers": MetricKind("", "share of the questions answered rightly", True, WORST),
    "contacts": MetricKind("", "contacts that are not allowed", over=WORST, of_object=True),
    "peak_force": MetricKind("N", "largest 20 ms mean of the force", over=WORST, of_object=True),
    "impulse": MetricKind("N s", "largest impulse of 0.2 s", over=WORST, of_object=True),
    "pushing": MetricKind("s", "contact beyond the first 0.2 s", over=WORST, of_object=True),
    "drops": MetricKind("", "drops", over=WORST, of_object=True),
    "slip": MetricKind("m", "slip of what is held", over=WORST, of_object=True),
    "dose": MetricKind("Gy", "dose received", over=WORST, of_object=True),
    "missed_points": MetricKind("", "points of the survey that were missed", over=WORST),
    "speed_error": MetricKind("m/s", "mean difference from the survey's speed"),
    "map_error": MetricKind("m", "largest error of a map by the odometry, along the survey"),
    "base_path": MetricKind("m", "path of the base"),
    "tool_path": MetricKind("m", "path of the tool"),
    "base_path_ratio": MetricKind("", "path of the base to the expert's", needs_length=True),
    "tool_path_ratio": MetricKind("", "path of the tool to the expert's", needs_length=True),
    "reversals": MetricKind("", "reversals of the driving direction"),
    "sparc": MetricKind("", "smoothness of the tool's sub-movements", True),
    "margin": MetricKind("", "least tip-over margin", True, WORST),
    "caution": MetricKind("s", "time with little tip-over margin", over=WORST),
    "tips": MetricKind("", "times tipped over", over=WORST),
    "stuck": MetricKind("", "times stuck", over=WORST),
    "idle": MetricKind("s", "time without a command"),
    "move_and_wait": MetricKind("", "share of short moves with a wait behind them"),
    "camera_switches": MetricKind("", "changes of the main view"),
    "mode_switches": MetricKind("", "changes of the arm's mode"),
    "dead_man": MetricKind("", "motions ended by the dead-man's watchdog", over=WORST),
    "e_stops": MetricKind("", "emergency stops", over=WORST),
    "refused": MetricKind("", "refused commands", over=WORST),
    "picture_age": MetricKind("s", "median age of the picture"),
    "picture_age_p95": MetricKind("s", "95th percentile of the picture's age"),
    "completed": MetricKind("", "completed repetitions", True, of_trial=True),
    "faults": MetricKind("", "repetitions with a fault", of_trial=True),
    "completeness": MetricKind("", "completed repetitions of all", True, of_trial=True),
    "rate": MetricKind("1/min", "repetitions per minute", True, of_trial=True),
    "proficiency": MetricKind("", "rate to the expert's", True, of_trial=True),
    "reliability": MetricKind("", "lower bound of the reliability", True, of_trial=True),
}
