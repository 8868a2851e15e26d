"""Trials for other programs: tables (CSV), and statements of the Experience API (xAPI 1.0.3)."""

from __future__ import annotations

import csv
import io
import json
import uuid
from datetime import datetime, timezone
from typing import Any, Dict, Iterator, List, Sequence
from urllib.parse import quote

from ..judging.sheet import FAILED, PASSED
from ..judging.workload import RATINGS, SCALES
from .trial_facts import TrialFacts

BASE = "https://telex.example"
"""Stands for a site in the addresses of statements; ``.example`` belongs to nobody (RFC 2606)."""
_VERBS = {
    PASSED: ("http://adlnet.gov/expapi/verbs/passed", "passed"),
    FAILED: ("http://adlnet.gov/expapi/verbs/failed", "failed"),
    "": ("http://adlnet.gov/expapi/verbs/attempted", "attempted"),
}
_KIND = "http://adlnet.gov/expapi/activities/simulation"
_COMPLETE = ("complete", "time")
_NAMESPACE = uuid.UUID("5b0f63ac-2f4d-5f0f-9d5c-0f4bb8d0a6f7")


def trials_csv(trials: Sequence[TrialFacts]) -> str:
    """Write a row a trial."""
    rows: List[List[Any]] = [
        [
            trial.trial,
            _moment(trial.began),
            trial.operator,
            trial.exercise,
            trial.setting,
            trial.mode,
            trial.signature,
            trial.seed,
            trial.valid,
            trial.verdict,
            trial.ended,
            f"{trial.seconds:.3f}",
            len(trial.repetitions),
            trial.faults,
            sum(each.passed for each in trial.repetitions),
            trial.software,
            trial.log,
            *_mark(trial),
            "" if trial.raw_workload is None else f"{trial.raw_workload:.2f}",
            *(trial.workload or [""] * RATINGS),
        ]
        for trial in trials
    ]
    heads = "trial began operator exercise setting mode signature seed valid verdict ended".split()
    heads += ["seconds", "repetitions", "faults", "passed", "software", "log_sha256"]
    heads += ["mark", "mark_reason", "mark_by", "workload"]
    heads += [f"workload_{name}" for name in SCALES]
    return _table(heads, rows)


def _mark(trial: TrialFacts) -> Sequence[str]:
    """Verdict, reason and author of an instructor's last mark."""
    if not trial.marks:
        return "", "", ""
    last = trial.marks[-1]
    return last.verdict, last.reason, last.by


def repetitions_csv(trials: Sequence[TrialFacts]) -> str:
    """Write a row a repetition, with all of its metrics."""
    names = sorted(
        {name for trial in trials for each in trial.repetitions for name in each.metrics}
    )
    rows: List[List[Any]] = [
        [
            trial.trial,
            trial.operator,
            trial.exercise,
            trial.setting,
            trial.mode,
            trial.signature,
            trial.valid,
            number,
            each.began,
            each.seconds,
            each.penalty,
            each.fault,
            each.completed,
            each.passed,
            *(each.metrics.get(name, "") for name in names),
        ]
        for trial in trials
        for number, each in enumerate(trial.repetitions, 1)
    ]
    heads = "trial operator exercise setting mode signature valid repetition began seconds".split()
    return _table([*heads, "penalty", "fault", "completed", "passed", *names], rows)


def _table(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(heads)
    writer.writerows(rows)
    return file.getvalue()


def statements(trials: Sequence[TrialFacts], base: str = BASE) -> Iterator[Dict[str, Any]]:
    """Yield an xAPI statement for each trial.

    A trial's statement has the same id each time, so that a store takes it once. ``score.scaled``
    is the share of the repetitions that passed: there is no weighted total. An invalid trial was
    attempted, whatever came of it.

    Parameters
    ----------
    base : str
        Beginning of the addresses that name people, exercises and sheets.
    """
    for trial in trials:
        verb, word = _VERBS[trial.verdict if trial.valid else ""]
        count = len(trial.repetitions)
        result: Dict[str, Any] = {
            "completion": trial.ended in _COMPLETE,
            "duration": f"PT{trial.seconds:.2f}S",
            "extensions": {
                f"{base}/xapi/valid": trial.valid,
                f"{base}/xapi/repetitions": count,
                f"{base}/xapi/faults": trial.faults,
                f"{base}/xapi/log-sha256": trial.log,
                f"{base}/xapi/sheet": f"{base}/training/sheet.html?trial={quote(trial.trial)}",
            },
        }
        if trial.valid and trial.verdict:
            result["success"] = trial.verdict == PASSED
        if count:
            share = sum(each.passed for each in trial.repetitions) / count
            result["score"] = {"scaled": round(share, 4), "min": 0, "max": count}
            result["score"]["raw"] = sum(each.passed for each in trial.repetitions)
        yield {
            "id": str(uuid.uuid5(_NAMESPACE, f"{trial.trial} {trial.log}")),
            "actor": {
                "objectType": "Agent",
                "account": {"homePage": base, "name": trial.operator or "nobody"},
            },
            "verb": {"id": verb, "display": {"en": word}},
            "object": {
                "objectType": "Activity",
                "id": f"{base}/exercises/{quote(trial.exercise)}/{quote(trial.setting)}",
                "definition": {
                    "type": _KIND,
                    "name": {"en": f"{trial.title}, {trial.setting}"},
                },
            },
            "result": result,
            "context": {
                "platform": "telex_training",
                "extensions": {
                    f"{base}/xapi/mode": trial.mode,
                    f"{base}/xapi/signature": trial.signature,
                    f"{base}/xapi/software": trial.software,
                },
            },
            "timestamp": _moment(trial.began),
        }


def statements_text(trials: Sequence[TrialFacts], base: str = BASE) -> str:
    """Write statements as JSON lines."""
    return "".join(
        json.dumps(each, sort_keys=True, ensure_ascii=False) + "\n"
        for each in statements(trials, base)
    )


def _moment(wall: float) -> str:
    """Write a wall time (s since the epoch) in ISO 8601, as universal time."""
    moment = datetime.fromtimestamp(wall, timezone.utc)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")
