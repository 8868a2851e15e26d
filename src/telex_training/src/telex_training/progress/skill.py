"""One person's skill in one exercise: learning curve, failures, best, weakest metrics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

from ..judging import stats
from ..judging.stats import Cusum
from .inference import CurvePoint, curve
from .trial_facts import MetricFacts, RepetitionFacts, TrialFacts

RECENT = 20
"""Repetitions, the last ones, by which reliability, proficiency and weak metrics are judged: what
somebody did as a beginner is not what he can do."""
ACCEPTABLE, UNACCEPTABLE = 0.1, 0.3
"""Failure rates between which the CUSUM chart decides."""
WEAKEST = 2


@dataclass(frozen=True)
class Weakness:
    """A metric with a bound, and how it stands in the recent repetitions.

    Attributes
    ----------
    missed, count : int
        How often it was beyond its bound, of how many figures.
    shortfall : float
        Median distance from the bound as a share of it; above 0 is beyond the bound.
    """

    metric: MetricFacts
    missed: int
    count: int
    shortfall: float


@dataclass(frozen=True)
class Skill:
    """A person in an exercise's setting, by the valid trials.

    Attributes
    ----------
    trials, invalid : int
        Valid trials, and those that do not count.
    repetitions : tuple of RepetitionFacts
        The oldest first.
    verdicts : tuple of str
        Of the trials that have one.
    last : float
        Wall time of the last trial (s since the epoch).
    best : float or None
        Least time of a completed repetition, with its penalties (s).
    times : tuple of float
        Of the completed repetitions, likewise.
    cusum : Cusum
        Of repetitions that did not pass.
    recent, recent_faults : int
        The last repetitions, at most `RECENT`, and those of them that were not completed.
    reliability : float or None
        Lower bound of the share of completed repetitions, with the confidence `stats.CONFIDENCE`.
    expert : float or None
        The expert's mean time (s).
    proficiency : float or None
        Rate of the recent repetitions to the expert's.
    provisional : bool
        Whether the expert is a script.
    workloads : tuple of float
        Of the trials that the operator has rated, of 100; invalid ones, too.
    """

    operator: str
    exercise: str
    setting: str
    title: str
    trials: int
    invalid: int
    repetitions: Tuple[RepetitionFacts, ...]
    verdicts: Tuple[str, ...]
    last: float
    best: Optional[float]
    times: Tuple[float, ...]
    curve: Optional[Tuple[CurvePoint, ...]]
    cusum: Cusum
    recent: int
    recent_faults: int
    reliability: Optional[float]
    expert: Optional[float]
    proficiency: Optional[float]
    provisional: bool
    weakest: Tuple[Weakness, ...]
    workloads: Tuple[float, ...]

    @property
    def passed(self) -> int:
        """Repetitions that passed."""
        return sum(repetition.passed for repetition in self.repetitions)


def skills(trials: Sequence[TrialFacts]) -> List[Skill]:
    """Judge people by their trials: one skill for each person, exercise and setting.

    Parameters
    ----------
    trials : sequence of TrialFacts
        The oldest first.

    Returns
    -------
    list of Skill
        In the order in which they were begun.
    """
    found: Dict[Tuple[str, str, str], List[TrialFacts]] = {}
    for trial in trials:
        found.setdefault((trial.operator, trial.exercise, trial.setting), []).append(trial)
    return [_skill(each) for each in found.values()]


def _skill(trials: Sequence[TrialFacts]) -> Skill:
    valid = [trial for trial in trials if trial.valid]
    repetitions = [each for trial in valid for each in trial.repetitions]
    times = [each.time for each in repetitions if each.completed]
    recent = repetitions[-RECENT:]
    faults = sum(not each.completed for each in recent)
    newest = (valid or trials)[-1]
    expert = next((each.expert for each in newest.metrics if each.kind == "time"), None)
    expert = expert if expert is not None and expert > 0.0 else None
    rate = stats.rate([each.time for each in recent if each.completed])
    return Skill(
        operator=newest.operator,
        exercise=newest.exercise,
        setting=newest.setting,
        title=newest.title,
        trials=len(valid),
        invalid=len(trials) - len(valid),
        repetitions=tuple(repetitions),
        verdicts=tuple(trial.verdict for trial in valid if trial.verdict),
        last=trials[-1].began,
        best=min(times, default=None),
        times=tuple(times),
        curve=curve(times),
        cusum=stats.cusum([not each.passed for each in repetitions], ACCEPTABLE, UNACCEPTABLE),
        recent=len(recent),
        recent_faults=faults,
        reliability=stats.reliability_bound(len(recent), faults),
        expert=expert,
        proficiency=None if expert is None or rate is None else rate * expert / 60.0,
        provisional=newest.provisional,
        weakest=_weakest(valid, newest.metrics),
        workloads=tuple(trial.raw_workload for trial in trials if trial.raw_workload is not None),
    )


def _weakest(valid: Sequence[TrialFacts], metrics: Sequence[MetricFacts]) -> Tuple[Weakness, ...]:
    """Metrics that are most often beyond their bounds; among equals the nearest to them."""
    pairs = [(trial, each) for trial in valid for each in trial.repetitions][-RECENT:]
    trials = [trial for trial in valid if any(trial is other for other, _ in pairs)]
    found = []
    for metric in metrics:
        if metric.bound is None:
            continue
        if metric.of_trial:
            values = [
                other.value for trial in trials for other in trial.metrics if _same(other, metric)
            ]
        else:
            values = [each.metrics.get(metric.name) for _, each in pairs if each.completed]
        if values:
            found.append(_weakness(metric, metric.bound, values))
    found.sort(key=lambda each: (-each.missed / each.count, -each.shortfall))
    return tuple(found[:WEAKEST])


def _same(one: MetricFacts, other: MetricFacts) -> bool:
    return (one.name, one.kind) == (other.name, other.kind)


def _weakness(metric: MetricFacts, bound: float, values: Sequence[Optional[float]]) -> Weakness:
    sign = -1.0 if metric.more_is_better else 1.0
    beyond = [sign * (value - bound) for value in values if value is not None]
    # What could not be measured is no pass.
    missed = sum(each > 0.0 for each in beyond) + len(values) - len(beyond)
    scale = abs(bound) or 1.0
    return Weakness(metric, missed, len(values), stats.median(beyond) / scale if beyond else 0.0)


def decision(chart: Cusum) -> str:
    """Say what a CUSUM chart has decided last.

    Returns
    -------
    str
        ``acceptable``, ``unacceptable``, or empty: nothing yet.
    """
    found, start = "", 0.0
    for value in chart.sums:
        if abs(value - start) >= chart.limit:
            found = "unacceptable" if value > start else "acceptable"
            start = value
    return found
