"""The score sheet: verdict, figures and their rounding."""

from __future__ import annotations

import json
import math
from typing import Any, Dict, List, Mapping, Optional, Sequence

from ..exercises.metric_kinds import DIGITS, KINDS, MEAN, WORST
from ..exercises.model import Exercise, Metric
from . import stats
from .stats import CONFIDENCE

FORMAT = 1
MOST_SECONDS = 1e6
"""Of a repetition, and of its penalties, in a sheet that is believed (s)."""
PASSED, FAILED = "passed", "failed"


_MISSING = object()
_NUMBER = (int, float)
_KEYS: Mapping[str, Any] = {
    "trial": str,
    "operator": str,
    "mode": str,
    "valid": bool,
    "verdict": str,
    "summary": dict,
    "exercise": dict,
    "repetitions": list,
}
_OF_EXERCISE: Mapping[str, Any] = {"name": str, "setting": str, "seed": (int, type(None))}
_OF_REPETITION: Mapping[str, Any] = {
    "began": _NUMBER,
    "seconds": _NUMBER,
    "penalty": _NUMBER,
    "completed": bool,
    "fault": (str, type(None)),
    "passed": bool,
    "metrics": dict,
}


def is_sheet(content: Any) -> bool:
    """Whether plain data is a sheet: it has all that lists and tables of sheets are made of."""
    return (
        _has(content, _KEYS)
        and content.get("format") == FORMAT
        and _has(content["exercise"], _OF_EXERCISE)
        and all(
            _has(each, _OF_REPETITION)
            and max(abs(each["seconds"]), abs(each["penalty"])) <= MOST_SECONDS
            for each in content["repetitions"]
        )
    )


def _has(content: Any, kinds: Mapping[str, Any]) -> bool:
    return isinstance(content, dict) and all(
        isinstance(content.get(key, _MISSING), kind) for key, kind in kinds.items()
    )


def rounded(value: Any) -> Any:
    """Copy plain data with its numbers rounded; what is not finite becomes null."""
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, float):
        # Adding 0 makes one zero of two.
        return round(value, DIGITS) + 0.0 if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return value


def sheet_text(sheet: Dict[str, Any]) -> str:
    """Write a sheet as JSON; equal sheets make equal texts."""
    return json.dumps(sheet, sort_keys=True, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def why_not_passed(sheet: Mapping[str, Any]) -> str:
    """Say of a sheet why its trial did not pass: faults, else what is beyond its bound."""
    reasons = [str(each["fault"]) for each in sheet["repetitions"] if each["fault"] is not None]
    reasons = reasons or [
        f"{each['name']} {each['value']} (pass {each['pass']})"
        for each in sheet["metrics"]
        if each["within"] is False and each["value"] is not None
    ]
    return "; ".join(reasons) or "not completed"


def summary(exercise: Exercise, repetitions: Sequence[Dict[str, Any]]) -> Dict[str, Any]:
    """Return the figures of a whole trial.

    Parameters
    ----------
    repetitions : sequence of dict
        Those that ended, as `Repetition.sheet` has them.
    """
    times = [rep["seconds"] + rep["penalty"] for rep in repetitions if rep["completed"]]
    faults = len(repetitions) - len(times)
    rate, expert = stats.rate(times), expert_rate(exercise)
    learned = stats.learning(times)
    return {
        "completed": len(times),
        "faults": faults,
        "completeness": stats.completeness(len(times), faults),
        "rate": rate,
        "proficiency": rate / expert if rate is not None and expert else None,
        "reliability": stats.reliability_bound(len(repetitions), faults),
        "confidence": CONFIDENCE,
        "learning": None
        if learned is None
        else {
            "first": learned.first,
            "slope": learned.slope,
            "predicted": learned.predicted,
        },
    }


def expert_rate(exercise: Exercise) -> Optional[float]:
    """The expert's repetitions per minute, by their mean time; None: there is no such time."""
    for metric in exercise.metrics:
        if metric.kind == "time" and metric.expert is not None and metric.expert[0] > 0.0:
            return 60.0 / metric.expert[0]
    return None


def results(
    exercise: Exercise, repetitions: Sequence[Dict[str, Any]], figures: Dict[str, Any]
) -> List[Dict[str, Any]]:
    """Return each metric of the exercise with its figure, and whether that is within its bound.

    A figure that could not be measured is no pass: null is not within any bound.
    """
    return [_result(metric, repetitions, figures) for metric in exercise.metrics]


def _result(
    metric: Metric, repetitions: Sequence[Dict[str, Any]], figures: Dict[str, Any]
) -> Dict[str, Any]:
    kind = KINDS[metric.kind]
    over = metric.over or kind.over
    if kind.of_trial:
        value = figures[metric.kind]
    else:
        values = [rep["metrics"][metric.name] for rep in repetitions if rep["completed"]]
        value = None if not values or None in values else _joined(values, over, kind.more_is_better)
    return {
        "name": metric.name,
        "kind": metric.kind,
        "unit": kind.unit,
        "text": metric.text,
        "more_is_better": kind.more_is_better,
        "over": None if kind.of_trial else over,
        "value": value,
        "pass": metric.bound,
        "expert": None if metric.expert is None else list(metric.expert),
        "within": within(metric, value),
    }


def within(metric: Metric, value: Optional[float]) -> Optional[bool]:
    """Whether a figure is within the metric's bound; None: it has none."""
    if metric.bound is None:
        return None
    if value is None:
        return False
    # As the sheet shows it, so that no one fails by a digit that is not shown.
    shown = round(value, DIGITS)
    return shown >= metric.bound if KINDS[metric.kind].more_is_better else shown <= metric.bound


def _joined(values: Sequence[float], over: str, more_is_better: bool) -> float:
    if over == WORST:
        return min(values) if more_is_better else max(values)
    if over == MEAN:
        return math.fsum(values) / len(values)
    return stats.median(values)


def passes(exercise: Exercise, repetition: Dict[str, Any]) -> bool:
    """Whether a repetition by itself is completed with every metric within its bound."""
    return bool(repetition["completed"]) and all(
        within(metric, repetition["metrics"][metric.name]) is not False
        for metric in exercise.metrics
        if not KINDS[metric.kind].of_trial
    )


def verdict(exercise: Exercise, completed: int, found: Sequence[Dict[str, Any]]) -> str:
    """Return the verdict: every metric within its bound, and as many repetitions as are asked."""
    enough = completed >= exercise.repetitions.least
    return PASSED if enough and all(item["within"] is not False for item in found) else FAILED
