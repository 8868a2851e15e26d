"""The brief of an exercise: all that counts in it, as plain data and in words."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Tuple

from ..exercises.conditions import ROBOT, TOOL, Condition
from ..exercises.metric_kinds import KINDS
from ..exercises.model import ARM, CAMERA, GRIPPER, TRACKS, Exercise, Metric
from .words import Said, condition_words, say

TIME_FAULT = "time"


def exercise_brief(exercise: Exercise) -> Dict[str, Any]:
    """Return the brief as plain data; docs/engineer/training.md describes its keys.

    Times in s, other figures in the units that they come with.
    """
    limits = exercise.repetitions
    return {
        "exercise": exercise.name,
        "title": exercise.title,
        "setting": exercise.setting,
        "description": exercise.description,
        "begins": _told(condition_words(exercise.begin)),
        "steps": [
            {"name": step.name, "until": _told(condition_words(step.until))}
            for step in exercise.steps
        ],
        "any_order": exercise.any_order,
        "faults": _faults(exercise),
        "penalties": [
            {
                "name": penalty.name,
                "when": _told(condition_words(penalty.when)),
                "seconds": penalty.seconds,
            }
            for penalty in exercise.penalties
        ],
        "questions": [question.ask for question in exercise.questions],
        "metrics": [_metric(metric) for metric in exercise.metrics if metric.bound is not None],
        "repetitions": {
            "most": limits.most,
            "least": limits.least,
            "time": limits.time,
            "trial_time": limits.trial_time,
        },
        "controls": list(needed_controls(exercise)),
        "expert": _expert(exercise),
    }


def needed_controls(exercise: Exercise) -> Tuple[str, ...]:
    """Return the controls that an exercise needs: as its file says, or as its steps show."""
    if exercise.controls:
        return exercise.controls
    atoms = [part for step in exercise.steps for part in step.until.walk()]
    found = [TRACKS]
    if any(_by_arm(part) for part in atoms):
        found += [ARM, GRIPPER]
    if any(question.of for question in exercise.questions):
        found.append(CAMERA)
    return tuple(found)


def _by_arm(part: Condition) -> bool:
    """Whether a condition of a step can be fulfilled by arm and gripper alone."""
    if part.kind in ("held", "dropped", "latch"):
        return True
    if part.kind == "joint":
        return bool(part.of.object != ROBOT)
    if part.kind in ("touches", "force"):
        return part.of.group in ("arm", "gripper")
    return part.kind == "inside" and part.of.what == TOOL


def _told(said: Said) -> Dict[str, Any]:
    """A sentence as it is said in English, and its parts for other languages."""
    return {"text": str(said), **said.as_json()}


def _faults(exercise: Exercise) -> List[Dict[str, Any]]:
    made: List[Dict[str, Any]] = [
        {"name": fault.name, "when": _told(condition_words(fault.when))}
        for fault in exercise.faults
    ]
    if exercise.repetitions.time:
        longest = say("a repetition takes more than {seconds} s", seconds=exercise.repetitions.time)
        made.append({"name": TIME_FAULT, "when": _told(longest)})
    return made


def _metric(metric: Metric) -> Dict[str, Any]:
    kind = KINDS[metric.kind]
    return {
        "text": metric.text,
        "unit": kind.unit,
        "more_is_better": kind.more_is_better,
        "pass": metric.bound,
        "expert": None if metric.expert is None else list(metric.expert),
    }


def _expert(exercise: Exercise) -> Optional[Dict[str, Any]]:
    """The expert's time of a repetition (s), and whose it is; None: there is none."""
    for metric in exercise.metrics:
        if metric.kind == "time" and metric.expert is not None:
            mean, spread = metric.expert
            return {
                "seconds": mean,
                "spread": spread,
                "provisional": exercise.expert.by == "script",
                "sees": exercise.expert.sees,
            }
    return None
