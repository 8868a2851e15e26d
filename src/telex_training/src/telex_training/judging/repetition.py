"""One repetition: its conditions, its clock, and what is measured in it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, FrozenSet, List, Mapping, NamedTuple, Optional, Tuple

from telex_control.common.geometry.quaternions import Pose, Vector3

from ..exercises.conditions import ROBOT
from ..exercises.metric_kinds import KINDS, OF_ALL, SURVEYED
from ..exercises.model import Exercise, Failure, Metric
from .activity import ActivityRecord
from .conditions import SLACK, Context, Evaluator
from .records.contacts import APART
from .records.motion import SurveyRecord
from .records.robot import Happening, RobotRecord

TIME_FAULT = "time"
GIVEN_UP = "given up"
WENT_BACK = "went back"
PUT_BACK = "put back from outside"
"""Faults that no exercise names: the repetition's time was over; the operator began anew, or left
the trial; he went back to a bookmark; somebody else reset the simulation, or went back.
"""


class Progress(NamedTuple):
    """How far a repetition was when a bookmark was set; another one goes on from it, as practice.

    Attributes
    ----------
    number : int
        Of the repetition.
    seconds : float, optional
        Since its begin (s); None: it had not begun.
    penalty : float
        s.
    step_times, marks, answers
        See `Repetition`.
    places : dict of str to tuple of 3 floats
    counts : dict of str to int
        See `Context`.
    expected : dict of str to str
        Right answers.
    """

    bookmark: str
    number: int
    seconds: Optional[float] = None
    penalty: float = 0.0
    step_times: Tuple[Optional[float], ...] = ()
    marks: Tuple[str, ...] = ()
    answers: Dict[str, str] = {}
    rights: Dict[str, Optional[bool]] = {}
    places: Dict[str, Vector3] = {}
    counts: Dict[str, int] = {}
    expected: Dict[str, str] = {}


class Repetition:
    """A repetition from "ready" to its end.

    One that goes on from a bookmark has the clock, steps, penalties and answers of then; what else
    is measured begins with it. Its time has no limit: it counts for nothing.

    Parameters
    ----------
    number : int
        From 1.
    context : Context
        Whose world is at the start.
    goals : dict of str to frozenset of str
        See `handling.goal_zones`.
    expected : dict of str to str
        Right answers of this repetition.
    progress : Progress, optional
        What it goes on from; None: it begins at the start.
    others : mapping of str to ActivityRecord
        Of the exercise's further robots.

    Attributes
    ----------
    bookmark : str
        That it goes on from; empty: none.
    began : float, optional
        s; None: it has not.
    looked : bool
        Whether a sample of the start was seen.
    seconds : float
        Without penalties (s of sim time), while it lasts and when it has ended.
    penalty : float
        s.
    fault : str
        Empty: none.
    step_times : list of float or None
        When each step was done (s from the begin), None: it was not.
    marks : list of str
        Names of its penalties and its fault.
    answers : dict of str to str
        As they were given.
    due : list of Failure
        What shall fail now; who makes it fail takes it out.
    """

    def __init__(
        self,
        number: int,
        exercise: Exercise,
        context: Context,
        goals: Dict[str, FrozenSet[str]],
        activity: ActivityRecord,
        expected: Dict[str, str],
        progress: Optional[Progress] = None,
        others: Optional[Mapping[str, ActivityRecord]] = None,
    ) -> None:
        self.number = number
        self.bookmark = ""
        self.began: Optional[float] = None
        self.ended = self.completed = False
        self.seconds = self.penalty = 0.0
        self.fault = ""
        self.step_times: List[Optional[float]] = [None] * len(exercise.steps)
        self.marks: List[str] = []
        self.answers: Dict[str, str] = {}
        self._exercise = exercise
        self._context = context
        self._expected = {
            question.name: expected.get(question.name, question.answer)
            for question in exercise.questions
        }
        self._begin = Evaluator(exercise.begin)
        self._steps = [Evaluator(step.until) for step in exercise.steps]
        self._faults = [Evaluator(fault.when) for fault in exercise.faults]
        self._penalties = [Evaluator(penalty.when) for penalty in exercise.penalties]
        self._failing = [Evaluator(malfunction.when) for malfunction in exercise.malfunctions]
        self._failed = [False] * len(exercise.malfunctions)
        self.due: List[Failure] = []
        self._holding: List[Optional[float]] = [None] * len(exercise.penalties)
        self._penalty_count = 0
        self._record = RobotRecord.of(exercise, goals, activity)
        self._others = {
            name: RobotRecord.of(exercise, goals, each) for name, each in (others or {}).items()
        }
        self._survey = SurveyRecord(exercise.survey)
        self.looked = False
        self._begin_activities()
        context.began = None
        context.places = {}
        context.answers = {}
        context.counts = {}
        self._resumes = False
        self._before = 0.0  # on the clock when it begins (s)
        if progress is not None:
            self._take_up(progress)

    def _take_up(self, progress: Progress) -> None:
        self.bookmark = progress.bookmark
        self._resumes = progress.seconds is not None
        self.seconds = self._before = progress.seconds or 0.0
        self.penalty = progress.penalty
        self.step_times[: len(progress.step_times)] = progress.step_times
        self.marks = list(progress.marks)
        self.answers = dict(progress.answers)
        self._expected.update(progress.expected)
        self.looked = bool(progress.places)
        self._context.places = dict(progress.places)
        self._context.answers = dict(progress.rights)
        self._context.counts = dict(progress.counts)

    def progress(self, bookmark: str) -> Progress:
        """Return how far it is, under the name of a bookmark that is set now."""
        context = self._context
        return Progress(
            bookmark,
            self.number,
            None if self.began is None else self.seconds,
            self.penalty,
            tuple(self.step_times),
            tuple(self.marks),
            dict(self.answers),
            dict(context.answers),
            dict(context.places),
            dict(context.counts),
            dict(self._expected),
        )

    @property
    def current_step(self) -> str:
        """Name of the step that is due; empty: all are done, or they have no order."""
        if self._exercise.any_order or None not in self.step_times:
            return ""
        return self._exercise.steps[self.step_times.index(None)].name

    def wait(self) -> bool:
        """Look at a sample before the begin; tells whether the repetition begins with it."""
        if not self.looked:
            self.looked = True
            self._context.note_places()
        if "command" not in self._context.counts and self._context.driven():
            # By a topic that is not watched, as a controller's own.
            self.count("command")
        if not self._resumes and not self._begin.holds(self._context):
            return False
        self.began = self._context.time
        self._context.began = self.began - self._before
        self._begin_activities()
        for world in (self._context.world, *self._context.others.values()):
            world.doses.begin()
        self._measure(0.0, 0)
        return True

    def run(self, span: float, steps: int) -> List[Happening]:
        """Look at a sample, `span` (s) and a number of physics steps after the one before."""
        assert self.began is not None
        self.seconds = self._before + self._context.time - self.began
        happened = self._measure(span, steps)
        for kind, _, _ in happened:
            self.count(kind)
        self._let_fail()
        happened += self._penalise()
        fault = self._spoilt()
        if fault:
            return [*happened, *self.spoil(fault)]
        return happened + self._advance()

    def run_other(self, robot: str, time: float, span: float, steps: int) -> List[Happening]:
        """Measure a further robot by its own sample, of a time (s); see `run`."""
        context = replace(self._context.of(robot), time=time)
        happened = self._others[robot].sample(context, span, steps)
        for kind, _, _ in happened:
            self.count(kind)
        return [(kind, name, {**detail, "robot": robot}) for kind, name, detail in happened]

    def _begin_activities(self) -> None:
        for record in (self._record, *self._others.values()):
            record.activity.begin()

    def hear_odometry(self, pose: Pose) -> None:
        """Take where the robot is by its own odometry."""
        self._survey.hear_odometry(self._context.world, pose)

    def count(self, event: str) -> None:
        """Count an event for the condition ``event``."""
        self._context.counts[event] = self._context.counts.get(event, 0) + 1

    def answer(self, question: str, given: str) -> bool:
        """Take an answer; the first to a question counts, others are refused."""
        if question not in self._expected or question in self.answers:
            return False
        self.answers[question] = given
        self._context.answers[question] = self._is_right(question)
        self.count("answer")
        return True

    def spoil(self, fault: str) -> List[Happening]:
        """End it with a fault."""
        self.ended, self.fault = True, fault
        self.marks.append(fault)
        return [("fault", fault, {})]

    def _is_right(self, question: str) -> Optional[bool]:
        expected = self._expected[question]
        if not expected:
            return None
        given = self.answers[question]
        return _plain(given) == _plain(expected)

    def _measure(self, span: float, steps: int) -> List[Happening]:
        self._survey.sample(self._context, span)
        return self._record.sample(self._context, span, steps)

    def _let_fail(self) -> None:
        for i, (malfunction, evaluator) in enumerate(
            zip(self._exercise.malfunctions, self._failing)
        ):
            # Each keeps its own time, whether it is over or not.
            if evaluator.holds(self._context) and not self._failed[i]:
                self._failed[i] = True
                self.due.append(malfunction.failure)

    def _penalise(self) -> List[Happening]:
        happened: List[Happening] = []
        for i, (penalty, evaluator) in enumerate(zip(self._exercise.penalties, self._penalties)):
            if not evaluator.holds(self._context):
                continue
            # What comes and goes within half a second is one occasion, as with contacts.
            before, self._holding[i] = self._holding[i], self._context.time
            if before is None or self._context.time - before >= APART:
                self.penalty += penalty.seconds
                self._penalty_count += 1
                self.marks.append(penalty.name)
                self.count("penalty")
                happened.append(("penalty", penalty.name, {"seconds": penalty.seconds}))
        return happened

    def _spoilt(self) -> str:
        spoilt = [evaluator.holds(self._context) for evaluator in self._faults]
        for fault, holds in zip(self._exercise.faults, spoilt):
            if holds:
                return fault.name
        limit = self._exercise.repetitions.time
        over = bool(limit) and not self.bookmark and self.seconds >= limit - SLACK
        return TIME_FAULT if over else ""

    def _advance(self) -> List[Happening]:
        """At most one step a sample where they have an order: the next is due from then on."""
        happened: List[Happening] = []
        for i, (step, evaluator) in enumerate(zip(self._exercise.steps, self._steps)):
            if self.step_times[i] is not None:
                continue
            if evaluator.holds(self._context):
                self.step_times[i] = self.seconds
                self.count("step")
                happened.append(("step", step.name, {}))
            if not self._exercise.any_order:
                break
        if None not in self.step_times:
            self.ended = self.completed = True
        return happened

    @property
    def time(self) -> float:
        """With penalties (s)."""
        return self.seconds + self.penalty

    def figure(self, metric: Metric) -> Optional[float]:
        """Measure a metric; None where it could not be measured."""
        kind = metric.kind
        if kind == "time":
            return self.time
        if kind == "penalties":
            return float(self._penalty_count)
        if kind == "answers":
            return self._right_share()
        if kind == "dose":
            world = self._context.of(metric.robot).world
            return world.doses.received(metric.object or ROBOT)
        if kind in SURVEYED:
            return self._survey.figure(kind)
        record = self._others[metric.robot] if metric.robot else self._record
        return record.figure(metric)

    def _right_share(self) -> Optional[float]:
        rights = [self._is_right(name) for name in self.answers]
        if None in rights or not self._expected:
            return None
        return sum(map(bool, rights)) / len(self._expected)

    def sheet(self) -> Dict[str, Any]:
        """What the sheet says of it, not yet rounded; to be asked when it has ended."""
        kinds = {
            name: Metric(name, name)
            for name, kind in KINDS.items()
            if not kind.of_trial and not kind.needs_length
        }
        of_each = [metric for name, metric in kinds.items() if name not in OF_ALL]
        kinds.update(
            (metric.name, metric)
            for metric in self._exercise.metrics
            if not KINDS[metric.kind].of_trial
        )
        others = {
            robot: {
                "dead_man": record.activity.releases(),
                "metrics": {
                    metric.name: self.figure(replace(metric, robot=robot)) for metric in of_each
                },
            }
            for robot, record in self._others.items()
        }
        return {
            # Sheets of one robot stay as they were.
            **({"robots": others} if others else {}),
            "began": self.began,
            "seconds": self.seconds,
            "penalty": self.penalty,
            "completed": self.completed,
            "fault": self.fault or None,
            "marks": list(self.marks),
            "steps": list(self.step_times),
            "answers": {
                name: {"given": given, "right": self._is_right(name)}
                for name, given in self.answers.items()
            },
            "dead_man": self._record.activity.releases(),
            "metrics": {name: self.figure(metric) for name, metric in kinds.items()},
        }


def _plain(text: str) -> str:
    return " ".join(text.replace(",", " ").split()).casefold()
