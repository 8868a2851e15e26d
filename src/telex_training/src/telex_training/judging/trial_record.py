"""Record of a trial: phase, repetitions and events, of which state and score sheet are made."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional

from ..exercises.model import EXAM, Exercise
from . import sheet as sheets
from .activity import ActivityRecord
from .malfunctions import MalfunctionRecord
from .records.other_robot import OtherRobot
from .repetition import Repetition
from .validity import Continuity, LinkRecord, Pace

IDLE, READY, PREPARING, WAITING = "idle", "ready", "preparing", "waiting"
RUNNING, BETWEEN, ENDED = "running", "between", "ended"
_MOST_EVENTS = 10_000
_MOST_REASONS = 20


@dataclass(frozen=True)
class JudgeEvent:
    """Something that the judge saw or decided.

    Attributes
    ----------
    time : float
        Sim time (s).
    event, name : str
        As in telex_msgs/TrainingEvent.
    detail : dict
        Plain data.
    secret : bool
        Whether the operator must not hear of it before the trial has ended.
    """

    time: float
    event: str
    name: str = ""
    detail: Dict[str, Any] = field(default_factory=dict)
    secret: bool = False


class TrialRecord:
    """A trial as far as it has come; the judge writes it.

    Attributes
    ----------
    phase : str
        As in telex_msgs/TrainingState.
    header : dict
        What the trial was opened with.
    repetition : Repetition, optional
        That waits, runs or has just ended.
    finished, practised : list of dict
        Sheets of repetitions: of those that count, and of those that went on from bookmarks.
    digest
        Of all entries.
    events : list of JudgeEvent
        The first ten thousand.
    reasons : list of str
        Why it is not valid.
    others : list of OtherRobot
        The further robots.
    trial_time : float
        In which repetitions waited and ran (s of sim time).
    """

    def __init__(self, exercise: Exercise) -> None:
        self.exercise = exercise
        self.phase = IDLE
        self.header: Dict[str, Any] = {}
        self.repetition: Optional[Repetition] = None
        self.finished: List[Dict[str, Any]] = []
        self.practised: List[Dict[str, Any]] = []
        self.digest = hashlib.sha256()
        self.continuity = Continuity()
        self.pace = Pace()
        self.link = LinkRecord()
        self.activity = ActivityRecord()
        self.malfunctions = MalfunctionRecord()
        self.others: List[OtherRobot] = []
        self.events: List[JudgeEvent] = []
        self.reasons: List[str] = []
        self.marks: List[Dict[str, Any]] = []
        self.notes: List[Dict[str, Any]] = []
        self.trial_time = 0.0
        self.ended_by = self.hint = self.message = ""

    @property
    def is_exam(self) -> bool:
        """Whether it was opened as an exam."""
        return self.header.get("mode") == EXAM

    @property
    def number(self) -> int:
        """Number of the repetition that is under way or comes next, from 1."""
        repetition = self.repetition
        return len(self.finished) + 1 if repetition is None else repetition.number

    def keep(self, event: JudgeEvent) -> None:
        """Keep an event for the sheet."""
        if len(self.events) < _MOST_EVENTS:
            self.events.append(event)

    def doubt(self, reason: str) -> None:
        """Keep a reason for which the trial is not valid."""
        if reason not in self.reasons and len(self.reasons) < _MOST_REASONS:
            self.reasons.append(reason)

    def state(self) -> Dict[str, Any]:
        """Return the fields of telex_msgs/TrainingState, but its header and bookmarks."""
        exercise, repetition = self.exercise, self.repetition
        running = repetition if repetition is not None and self.phase != IDLE else None
        answered = running.answers if running else {}
        return {
            "phase": self.phase,
            "trial": self.header.get("trial", ""),
            "exercise": exercise.name,
            "title": exercise.title,
            "setting": exercise.setting,
            "mode": self.header.get("mode", ""),
            "operator": self.header.get("operator", ""),
            "valid": not self.reasons,
            "invalid_because": list(self.reasons),
            "repetition": self.number,
            "repetitions": exercise.repetitions.most,
            "from_bookmark": running.bookmark if running else "",
            "results": ["passed" if made["completed"] else made["fault"] for made in self.finished],
            "elapsed": running.seconds if running else 0.0,
            "penalty": running.penalty if running else 0.0,
            "trial_elapsed": self.trial_time,
            "trial_limit": exercise.repetitions.trial_time,
            "steps": [step.name for step in exercise.steps],
            "steps_done": [
                time is not None
                for time in (running.step_times if running else [None] * len(exercise.steps))
            ],
            "faults": list(running.marks) if running else [],
            "questions": [
                {
                    "name": question.name,
                    "ask": question.ask,
                    "choices": list(question.choices),
                    "answered": question.name in answered,
                }
                for question in exercise.questions
            ],
            "malfunctions": self._announced(),
            "hint": self.hint,
            "message": self.message,
            "verdict": self.sheet()["verdict"] if self.phase == ENDED else "",
        }

    def sheet(self) -> Dict[str, Any]:
        """Return the score sheet as plain data, rounded; `sheet_text` writes it."""
        exercise = self.exercise
        figures = sheets.summary(exercise, self.finished)
        found = sheets.results(exercise, self.finished, figures)
        header = self.header
        link = {"link": self.link.settings} if self.link.settings else {}
        return sheets.rounded(
            {
                **link,
                **self._aids(),
                "format": sheets.FORMAT,
                "exercise": {
                    "name": exercise.name,
                    "title": exercise.title,
                    "sha256": exercise.sha256,
                    "setting": exercise.setting,
                    "seed": header.get("seed"),
                },
                "trial": header.get("trial", ""),
                "operator": header.get("operator", ""),
                "mode": header.get("mode", ""),
                "software": header.get("software", ""),
                "log": {
                    "sha256": self.digest.hexdigest(),
                    "samples": self.continuity.samples,
                    "gaps": self.continuity.gaps,
                },
                "valid": not self.reasons,
                "invalid_because": list(self.reasons),
                "real_time_factor": {
                    **self.pace.figures(),
                    "slow_share": self.pace.slow_share,
                    "slow": self.pace.stretches,
                },
                "ended": self.ended_by,
                "trial_seconds": self.trial_time,
                "repetitions": self.finished,
                # Sheets of trials that had none stay as they were.
                **({"practised": self.practised} if self.practised else {}),
                "summary": figures,
                "metrics": found,
                "expert": {
                    "provisional": exercise.expert.by == "script",
                    "sees": exercise.expert.sees,
                    "repetitions": exercise.expert.repetitions,
                },
                "verdict": self._verdict(found, figures["completed"]),
                "malfunctions": self._failed(),
                "marks": self.marks,
                "notes": self.notes,
                "events": [
                    {
                        "time": event.time,
                        "event": event.event,
                        "name": event.name,
                        "detail": event.detail,
                    }
                    for event in self.events
                ],
            }
        )

    def _aids(self) -> Dict[str, List[Dict[str, Any]]]:
        """Return what the sheet says of the aids on each operator's page."""
        found = self.activity.aids.sheet()
        for other in self.others:
            for name, aids in other.activity.aids.sheet(other.name).items():
                found[name] = [*found.get(name, []), *aids]
        return found

    def _announced(self) -> List[str]:
        others = (
            f"{other.name}: {text}"
            for other in self.others
            for text in other.malfunctions.announced()
        )
        return [*self.malfunctions.announced(), *others]

    def _failed(self) -> List[Dict[str, Any]]:
        made = [each.sheet() for each in self.malfunctions.episodes]
        for other in self.others:
            made += [{**each.sheet(), "robot": other.name} for each in other.malfunctions.episodes]
        return sorted(made, key=lambda each: float(each["time"]))

    def _verdict(self, found: List[Dict[str, Any]], completed: int) -> str:
        """Empty while it goes on, and where the trial is invalid or was left."""
        left = self.ended_by not in ("complete", "time")
        exam = self.is_exam
        if self.phase != ENDED or (exam and (self.reasons or left)):
            return ""
        if left and completed < self.exercise.repetitions.least:
            return ""
        return sheets.verdict(self.exercise, completed, found)
