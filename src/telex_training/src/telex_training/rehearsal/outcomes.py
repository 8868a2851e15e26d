"""Summary of a campaign, and what has changed from another one."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

from ..judging.sheet import PASSED, why_not_passed
from ..judging.stats import CONFIDENCE, median, percentile, reliability_bound
from ..progress.inference import Difference, difference_of_medians, fisher
from .jobs import Rehearsed

Key = Tuple[str, str]
"""Setting and line."""


@dataclass(frozen=True)
class Run:
    """A trial of a campaign.

    Attributes
    ----------
    seconds : float or None
        With penalties, of the repetition if it was completed.
    metrics : dict of str to float or None
        Of the repetition, by name.
    why : str
        Why it did not pass.
    """

    seed: int
    passed: bool
    completed: bool
    seconds: Optional[float]
    metrics: Dict[str, Optional[float]]
    why: str


@dataclass(frozen=True)
class Spread:
    """Median and outer shares of a figure over the trials that have it."""

    count: int
    low: float
    middle: float
    high: float


def run_of(seed: int, outcome: Rehearsed) -> Run:
    """Read an outcome."""
    sheet = json.loads(outcome.sheet)
    repetitions = sheet["repetitions"]
    done = [each for each in repetitions if each["completed"]]
    return Run(
        seed=seed,
        passed=sheet["verdict"] == PASSED,
        completed=bool(done),
        seconds=done[0]["seconds"] + done[0]["penalty"] if done else None,
        metrics={each["name"]: each["value"] for each in sheet["metrics"] if each["over"]},
        why=_why(sheet, outcome.gave_up),
    )


def _why(sheet: Dict[str, Any], gave_up: str) -> str:
    if sheet["verdict"] == PASSED:
        return ""
    return f"gave up: {gave_up}" if gave_up else why_not_passed(sheet)


def spread_of(runs: Sequence[Run], metric: str) -> Optional[Spread]:
    """10 %, 50 % and 90 % of a metric over the trials that have it; None: none has."""
    values = [run.metrics.get(metric) for run in runs]
    found = [value for value in values if value is not None]
    if not found:
        return None
    return Spread(len(found), percentile(found, 0.1), median(found), percentile(found, 0.9))


def worst(runs: Sequence[Run], count: int) -> List[Run]:
    """Trials to look at: those that did not pass, then the slowest."""
    return sorted(runs, key=lambda run: (run.passed, run.completed, -(run.seconds or 0.0)))[:count]


def summarised(key: Key, runs: Sequence[Run]) -> Dict[str, Any]:
    """Return the figures of one setting on one line, as plain data."""
    passed = sum(run.passed for run in runs)
    names = list(dict.fromkeys(name for run in runs for name in run.metrics))
    spreads = {name: spread_of(runs, name) for name in names}
    return {
        "setting": key[0],
        "line": key[1],
        "trials": len(runs),
        "passed": passed,
        "at_least": reliability_bound(len(runs), len(runs) - passed),
        "at_most": _upper(len(runs), passed),
        "confidence": CONFIDENCE,
        "metrics": {
            name: None if each is None else [each.count, each.low, each.middle, each.high]
            for name, each in spreads.items()
        },
        "not_passed": {str(run.seed): run.why for run in runs if not run.passed},
    }


def _upper(count: int, passed: int) -> Optional[float]:
    bound = reliability_bound(count, passed)
    return None if bound is None else 1.0 - bound


def provisional(metrics: Dict[str, Any], factor: float) -> Dict[str, float]:
    """Pass values that the figures of a scripted operator suggest for people.

    Parameters
    ----------
    metrics : mapping
        Of `summarised`.
    factor : float
        How much more time than the script people are given.

    Returns
    -------
    dict
        ``time``: the 90 % value times the factor, in whole seconds. Other metrics are not scaled:
        a fault is one for everybody.
    """
    found = metrics.get("time")
    return {} if found is None else {"time": float(round(found[3] * factor))}


@dataclass(frozen=True)
class Change:
    """One setting on one line in two campaigns.

    Attributes
    ----------
    passed, trials : tuple of int
        Before and after.
    chance : float
        Of Fisher's exact test on the passes.
    seconds : Difference or None
        Of the median times, after less before.
    differing : tuple of int
        Seeds with another verdict.
    sheets : int
        Seeds whose sheets differ in anything.
    """

    setting: str
    line: str
    passed: Tuple[int, int]
    trials: Tuple[int, int]
    chance: float
    seconds: Optional[Difference]
    differing: Tuple[int, ...]
    sheets: int


def change(key: Key, before: Dict[int, Rehearsed], after: Dict[int, Rehearsed]) -> Change:
    """Compare the outcomes of two campaigns by their seeds."""
    runs = [[run_of(seed, each[seed]) for seed in sorted(each)] for each in (before, after)]
    passed = [sum(run.passed for run in each) for each in runs]
    times = [[run.seconds for run in each if run.seconds is not None] for each in runs]
    both = sorted(set(before) & set(after))
    verdicts = [{run.seed: run.passed for run in each} for each in runs]
    return Change(
        *key,
        (passed[0], passed[1]),
        (len(runs[0]), len(runs[1])),
        fisher((passed[0], passed[1]), (len(runs[0]) - passed[0], len(runs[1]) - passed[1])),
        difference_of_medians(times[0], times[1]),
        tuple(seed for seed in both if verdicts[0][seed] != verdicts[1][seed]),
        sum(_content(before[seed]) != _content(after[seed]) for seed in both),
    )


def _content(outcome: Rehearsed) -> Any:
    sheet = json.loads(outcome.sheet)
    # Digests of exercise and log say no more than the rest does.
    sheet.pop("log", None)
    sheet.get("exercise", {}).pop("sha256", None)
    return sheet, outcome.gave_up
