"""The judge: folds the entries of a trial into its state and its score sheet."""

from __future__ import annotations

import hashlib
import math
import struct
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, Optional

from ..exercises.conditions import EVENTS
from ..exercises.model import EXAM, MODES, PRACTICE, Exercise, Failure
from ..exercises.seeds import scene_of
from . import sheet as sheets
from .actions import action_of
from .activity import COMMANDS, STATUSES, ActivityRecord
from .conditions import Context
from .entries import (
    ACTIONS,
    CLIENTS,
    DOSES,
    E_STOP,
    INPUTS,
    LINK,
    MALFUNCTIONS,
    NAMES,
    ODOMETRY,
    STATUS,
    TELEMETRY,
    TRUTH,
    BadEntryError,
    Entry,
    decode,
    doses_of,
    json_of,
    number_field,
    odometry_of,
    text_field,
)
from .handling import goal_zones
from .malfunctions import MalfunctionRecord, Turn
from .moments import INPUT as MOMENT
from .records.aids import LASER, LASER_LINK
from .records.other_robot import CHANNELS, OtherRobot, channel_of
from .records.robot import Happening
from .repetition import GIVEN_UP, PUT_BACK, WENT_BACK, Progress, Repetition
from .truth import Names, Sample, World, read_sample
from .validity import MOST_SLOW, Continuity, LinkRecord, Pace
from .workload import INPUT as TLX
from .workload import workload_of

IDLE, READY, PREPARING, WAITING = "idle", "ready", "preparing", "waiting"
RUNNING, BETWEEN, ENDED = "running", "between", "ended"
_MOST_EVENTS = 10_000
_MOST_REASONS = 20
_MOST_BOOKMARKS = 100
_NAMES_PATIENCE = 1.0
_UNHEARD = "nothing is heard of the robot"
_UNCOUNTED = ("command", "answer", "step", "penalty", "contact", "drop", "tipped")
"""Events that the repetition counts itself."""


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


class Judge:
    """A pure fold over the entries of one trial: the same entries make the same sheet.

    No entry makes it raise: one that cannot be used is an event "invalid" with the reason.

    Parameters
    ----------
    exercise : Exercise
        In the setting of the trial.
    scene : str
        Text of the scene as it was loaded; without one, zones in the frame of what stands fast
        contain nothing.
    urdf : str
        Of the robot; without one, nothing of the tool is measured.
    urdfs : mapping of str to str, optional
        The same of further robots, by the exercise's names.

    Attributes
    ----------
    phase : str
        As in telex_msgs/TrainingState.
    workload : dict, optional
        The operator's own ratings of the trial that has ended, see `workload_of`; None: not given.

    Raises
    ------
    telex_training.exercises.exercise_file.ExerciseError
        The scene cannot be read.
    telex_control.urdf.joints.UrdfError
        The URDF cannot.
    """

    def __init__(
        self,
        exercise: Exercise,
        scene: str = "",
        urdf: str = "",
        urdfs: Optional[Mapping[str, str]] = None,
    ) -> None:
        self.exercise = exercise
        self.phase = IDLE
        known = scene_of(exercise, scene) if scene else None
        self._world = World(known, urdf)
        self._others = [
            OtherRobot(robot.name, known, (urdfs or {}).get(robot.name, ""))
            for robot in exercise.robots
        ]
        self._context = Context(
            self._world, exercise.zones, others={each.name: each.world for each in self._others}
        )
        self._goals = goal_zones(exercise)
        self._digest = hashlib.sha256()
        self._continuity = Continuity()
        self._pace = Pace()
        self._link = LinkRecord()
        self._activity = ActivityRecord()
        self._malfunctions = MalfunctionRecord()
        self._header: Dict[str, Any] = {}
        self._repetition: Optional[Repetition] = None
        self._finished: List[Dict[str, Any]] = []
        # Those that went on from bookmarks: they count for nothing.
        self._practised: List[Dict[str, Any]] = []
        self._bookmarks: Dict[str, Progress] = {}
        self._expected: Dict[str, str] = {}
        self._events: List[JudgeEvent] = []
        self._new: List[JudgeEvent] = []
        self._reasons: List[str] = []
        self._marks: List[Dict[str, Any]] = []
        self._notes: List[Dict[str, Any]] = []
        self.workload: Optional[Dict[str, Any]] = None
        self._trial_time = 0.0
        self._ended_by = ""
        self._hint = self._message = ""
        self._time = 0.0
        self._last: Optional[float] = None
        self._last_steps = 0
        self._nameless: Optional[float] = None
        self._resets_due = 0
        self._paused = False
        self._handlers: Dict[str, Callable[[Entry], None]] = {
            TRUTH: self._take_truth,
            NAMES: self._take_names,
            STATUS: self._take_status,
            DOSES: self._take_doses,
            ODOMETRY: self._take_odometry,
            CLIENTS: self._activity.clients,
            ACTIONS: self._take_action,
            LINK: self._take_link,
            TELEMETRY: self._take_telemetry,
            **({LASER: self._take_lasers} if f'"{LASER_LINK}"' in urdf else {}),
            INPUTS: self._take_input,
            MALFUNCTIONS: lambda entry: self._say_turns(self._malfunctions.hear(entry)),
            E_STOP: lambda entry: self._say_turns(self._malfunctions.e_stop(entry)),
            **dict.fromkeys(COMMANDS, self._take_command),
            **dict.fromkeys(STATUSES, self._take_teleop_status),
        }
        for other in self._others:
            for channel in CHANNELS:
                take = partial(self._take_of_other, other, channel)
                self._handlers[channel_of(other.name, channel)] = take
        self._inputs: Dict[str, Callable[[Dict[str, Any]], None]] = {
            "open": self._open,
            "start": self._start,
            "ready": self._ready,
            "drawn": self._drawn,
            "answer": self._answer,
            "again": self._again,
            "bookmark": self._bookmark,
            "back": self._back,
            "abort": self._abort,
            "pause": self._pause,
            "mark": self._mark,
            "note": self._note,
            TLX: self._rate,
            "outside": self._outside,
        }

    @property
    def repetition(self) -> int:
        """Number of the repetition that is under way or comes next, from 1."""
        repetition = self._repetition
        return len(self._finished) + 1 if repetition is None else repetition.number

    def feed(self, entry: Entry) -> List[JudgeEvent]:
        """Take the next entry.

        Once the trial has ended, only the training's own inputs are looked at: a recording that was
        closed a little later makes the same sheet. Ratings of the workload and notes at moments
        leave no trace in it, so that a sheet that was printed is still that of the recording.

        Returns
        -------
        list of JudgeEvent
            What happened with it.
        """
        self._new = []
        if self._takes_aside(entry) if entry.channel == INPUTS else self.phase == ENDED:
            return self._new
        channel = entry.channel.encode("utf-8", "replace")
        self._digest.update(struct.pack("<II", len(channel), len(entry.data)))
        self._digest.update(channel)
        self._digest.update(entry.data)
        if math.isfinite(entry.time):
            self._time = entry.time
        self._count(entry)
        handle = self._handlers.get(entry.channel)
        if handle is not None:
            try:
                if not math.isfinite(entry.time):
                    raise BadEntryError(f"its time is {entry.time}; a finite one is needed")
                handle(entry)
            except BadEntryError as error:
                self._invalidate(f"{entry.channel}: {error}")
            except Exception as error:  # live and from the file alike, and never the trial's end
                self._invalidate(f"{entry.channel}: the judge fails: {type(error).__name__}")
        return self._new

    def _count(self, entry: Entry) -> None:
        wrong = self._continuity.entry(entry.number) if self.phase != ENDED else None
        if wrong:
            self._invalidate("entries of the recording are missing", at=wrong)

    # What comes from the simulator

    def _take_truth(self, entry: Entry) -> None:
        sample = _sample_of(entry)
        was_reset = self._continuity.resets(sample)
        wrong = self._continuity.sample(sample)
        if self.phase not in (IDLE, READY):
            for reason in wrong:
                self._invalidate(reason)
        wanted = sample.resets == self._resets_due
        if was_reset and not wanted and self.phase in (WAITING, RUNNING, BETWEEN):
            self._invalidate("the simulation was reset from outside")
            self._put_back_from_outside()
        self._time = self._context.time = sample.time
        if self._pace_counts() and self._pace.sample(sample.time, sample.wall_time):
            self._say("slow")
        if not self._world.knows(sample):
            self._miss_names(sample.time)
            return
        self._nameless = None
        self._world.take(sample)
        self._say_turns(self._malfunctions.sample(sample.time))
        # Time in which the apparatus is put back does not count.
        counts = self.phase in (WAITING, RUNNING) and self._last is not None
        span = max(0.0, sample.time - (self._last or 0.0)) if counts else 0.0
        steps = max(0, sample.steps - self._last_steps)
        self._last, self._last_steps = sample.time, sample.steps
        self._judge(span, steps)

    def _pace_counts(self) -> bool:
        # While the apparatus is put back, the simulator may stand.
        return self.phase in (WAITING, RUNNING, BETWEEN)

    def _miss_names(self, time: float) -> None:
        if self._nameless is None:
            self._nameless = time
        elif time - self._nameless > _NAMES_PATIENCE and self.phase in (WAITING, RUNNING):
            self._invalidate("the names of the truth are missing")

    def _judge(self, span: float, steps: int) -> None:
        repetition = self._repetition
        if repetition is None or self.phase not in (WAITING, RUNNING):
            return
        sample = self._world.sample
        if self.phase == WAITING and sample is not None and sample.resets < self._resets_due:
            # It was on its way when the apparatus was put back.
            return
        if not self._all_there():
            return
        self._trial_time += span
        self._activity.aids.pass_time(span)
        if self.phase == WAITING:
            if repetition.wait():
                self.phase = RUNNING
                bookmark = {"bookmark": repetition.bookmark} if repetition.bookmark else {}
                self._say("begin", detail={"repetition": repetition.number, **bookmark})
                self._hint_on(repetition.current_step)
        else:
            step = repetition.current_step
            self._tell(repetition.run(span, steps))
            if repetition.current_step not in ("", step):
                self._hint_on(repetition.current_step)
            if repetition.ended:
                self._finish(repetition)
                if not repetition.bookmark:
                    self._end_if_complete()
        limit = self.exercise.repetitions.trial_time
        if limit and self._trial_time >= limit and self.phase != ENDED:
            self._end("time")

    def _all_there(self) -> bool:
        """Whether further robots are heard of, as they must be while one waits to begin."""
        for other in self._others:
            if other.is_there(self._time, self._resets_due):
                continue
            text = f"{_UNHEARD} '{other.name}'"
            if self.phase == WAITING:
                self._message = text
                return False
            if text not in self._reasons:
                self._invalidate(text)
        if self.phase == WAITING and self._message.startswith(_UNHEARD):
            self._message = ""
        return True

    def _take_of_other(self, other: OtherRobot, channel: str, entry: Entry) -> None:
        entry = entry._replace(channel=channel)
        if channel == TRUTH:
            self._take_truth_of_other(other, entry)
        elif channel == LINK:
            self._hear_line(other.link, entry, {"robot": other.name})
        else:
            for event in other.hear(entry):
                if event != "command":
                    self._say(event, other.name)
                elif self._repetition is not None and self.phase in (WAITING, RUNNING):
                    self._repetition.count(event)

    def _take_truth_of_other(self, other: OtherRobot, entry: Entry) -> None:
        sample = _sample_of(entry)
        for reason in other.continuity.sample(sample):
            if self.phase not in (IDLE, READY):
                self._invalidate(f"{other.name}: {reason}")
        passed = other.take(sample)
        if passed is not None and self.phase == RUNNING and self._repetition is not None:
            self._tell(self._repetition.run_other(other.name, sample.time, *passed))

    def _tell(self, happened: List[Happening]) -> None:
        for event, name, detail in happened:
            self._say(event, name, detail)
            # A step's hint is for when it becomes due.
            self._hint_on(event, "" if event == "step" else name)

    def _take_names(self, entry: Entry) -> None:
        before = self._world.names
        names = Names(decode(entry, "telex_msgs/TruthNames"))
        looked = self._repetition is not None and self._repetition.looked
        if before is not None and looked and self.phase in (WAITING, RUNNING, BETWEEN):
            if before.objects != names.objects or before.bodies != names.bodies:
                self._invalidate("objects were put into the scene or taken out")
            elif before.revision != names.revision:
                # Taken out and put in again elsewhere, in one pause; or another robot came or went.
                self._invalidate("objects were moved, or robots came or went, from outside")
        self._world.name(names)

    def _take_doses(self, entry: Entry) -> None:
        self._context.doses.take(doses_of(entry))

    def _take_odometry(self, entry: Entry) -> None:
        pose = odometry_of(entry)
        if self._repetition is not None and self.phase == RUNNING:
            self._repetition.hear_odometry(pose)

    def _take_status(self, entry: Entry) -> None:
        message = decode(entry, "telex_msgs/SimStatus")
        for event in self._activity.sim_status(message):
            self._say(event)
        self._pace.pause(bool(message.paused))
        if bool(message.paused) != self._paused:
            self._paused = bool(message.paused)
            if self.phase != IDLE:
                self._say("pause", detail={"on": self._paused})

    def _take_action(self, entry: Entry) -> None:
        by, words = action_of(entry)
        self._note({"text": words, "by": by})
        exam = self._header.get("mode") == EXAM
        if exam and self.phase in (WAITING, RUNNING, BETWEEN):
            self._invalidate(f"{by[:40]} has changed the scene")

    def _take_link(self, entry: Entry) -> None:
        self._hear_line(self._link, entry, {})

    def _hear_line(self, record: LinkRecord, entry: Entry, of: Dict[str, Any]) -> None:
        setting, outage = record.take(entry)
        if setting is not None:
            figures = {key: value for key, value in setting.items() if key != "profile"}
            self._say("link", setting["profile"], {**figures, **of})
            # In practice it is the instructor's to change; an exam has the line of its exercise.
            exam = self._header.get("mode") == EXAM
            if exam and self.phase in (WAITING, RUNNING, BETWEEN):
                self._invalidate("the line was changed from outside")
        if outage is not None:
            self._say("outage", detail={"on": outage, **of})

    # What the operator does

    def _take_command(self, entry: Entry) -> None:
        self._say_turns(self._malfunctions.command(entry))
        event = self._activity.command(entry)
        if event and self._repetition is not None and self.phase in (WAITING, RUNNING):
            self._repetition.count(event)

    def _take_teleop_status(self, entry: Entry) -> None:
        event = self._activity.teleop_status(entry)
        if event:
            self._say(event)

    def _take_telemetry(self, entry: Entry) -> None:
        event = self._activity.telemetry(entry)
        if event:
            self._say(event)

    def _take_lasers(self, entry: Entry) -> None:
        self._activity.aids.switch_lasers(decode(entry, "std_msgs/Float64").data)

    def _say_turns(self, turns: List[Turn]) -> None:
        for event, episode, detail in turns:
            self._say(event, episode.name, detail, secret=not episode.announced)

    def take_due(self) -> List[Failure]:
        """Return what shall fail now, once; who runs the trial makes it fail."""
        if self._repetition is None:
            return []
        due, self._repetition.due = self._repetition.due, []
        return due

    # The training's own inputs

    def _take_input(self, entry: Entry) -> None:
        content = json_of(entry)
        kind = text_field(content, "input")
        act = self._inputs.get(kind)
        if act is None:
            raise BadEntryError(f"input is '{kind[:40]}'; {', '.join(self._inputs)} are possible")
        act(content)

    def _allowed(self, content: Dict[str, Any], *phases: str) -> bool:
        if self.phase in phases:
            return True
        self._message = f"{content['input']}: not now, the trial is {self.phase}"
        self._say("refused", content["input"], {"phase": self.phase})
        return False

    def _open(self, content: Dict[str, Any]) -> None:
        if not self._allowed(content, IDLE):
            return
        header = {
            key: text_field(content, key)
            for key in ("trial", "operator", "mode", "setting", "software")
        }
        header["mode"] = header["mode"] or PRACTICE
        seed = content.get("seed")
        if header["mode"] not in MODES:
            raise BadEntryError(f"mode is '{header['mode']}'; {' or '.join(MODES)} is needed")
        if isinstance(seed, bool) or not isinstance(seed, (int, type(None))):
            raise BadEntryError(f"seed is {str(seed)[:40]!r}; a whole number is needed")
        if header["setting"] not in ("", self.exercise.setting):
            self._invalidate(f"the trial is of the setting '{header['setting']}'")
        self._header = {**header, "seed": seed}
        self.phase = READY
        self._say("open", self.exercise.name)

    def _start(self, content: Dict[str, Any]) -> None:
        if self._allowed(content, READY):
            self.phase = PREPARING

    def _ready(self, content: Dict[str, Any]) -> None:
        due = number_field(content, "resets") if "resets" in content else 0
        bookmark, missed = text_field(content, "bookmark"), text_field(content, "missed")
        if not self._allowed(content, PREPARING):
            return
        number = len(self._finished) + 1
        progress = None
        if bookmark:
            # One that is not known was set while nothing could be done: still it is no start.
            progress = self._bookmarks.get(bookmark) or Progress(bookmark, number)
        self._resets_due = int(due)
        self._pace.cut()
        self._repetition = Repetition(
            number if progress is None else progress.number,
            self.exercise,
            self._context,
            self._goals,
            self._activity,
            self._expected,
            progress,
            {other.name: other.activity for other in self._others},
        )
        self._expected = {}
        self._hint, self._message = "", missed
        if missed:
            self._say("refused", "back", {"reason": missed})
        self.phase = WAITING

    def _drawn(self, content: Dict[str, Any]) -> None:
        answers = content.get("answers")
        if not isinstance(answers, dict):
            raise BadEntryError("answers: a struct of texts is needed")
        if self._allowed(content, READY, PREPARING):
            self._expected = {str(name): text_field(answers, name) for name in answers}

    def _answer(self, content: Dict[str, Any]) -> None:
        question, given = text_field(content, "question"), text_field(content, "answer")
        if not self._allowed(content, RUNNING) or self._repetition is None:
            return
        if self._repetition.answer(question, given):
            self._say("answer", question)
        else:
            self._message = f"'{question}' is no question, or is answered already"
            self._say("refused", "answer", {"question": question[:60]})

    def _again(self, content: Dict[str, Any]) -> None:
        if not self._allowed(content, WAITING, RUNNING, BETWEEN):
            return
        self._leave(GIVEN_UP)
        self._end_if_complete()
        if self.phase != ENDED:
            self.phase = PREPARING

    def _leave(self, fault: str) -> None:
        """End the repetition that runs with a fault; one that waits has not been."""
        if self.phase == RUNNING and self._repetition is not None:
            self._tell(self._repetition.spoil(fault))
            self._finish(self._repetition)
        self._repetition = None

    def _put_back_from_outside(self) -> None:
        """Leave a repetition whose world is another one now."""
        if self.phase == BETWEEN:
            return
        self._leave(PUT_BACK)
        self._end_if_complete()
        if self.phase != ENDED:
            self._message = "the simulation was reset from outside; again begins anew"
            self.phase = BETWEEN

    def _in_practice(self, content: Dict[str, Any]) -> bool:
        if self._header.get("mode") != EXAM:
            return True
        self._message = f"{content['input']}: an exam has no bookmarks"
        self._say("refused", content["input"], {"mode": EXAM})
        return False

    def _bookmark(self, content: Dict[str, Any]) -> None:
        name = text_field(content, "name")
        if not self._in_practice(content) or not self._allowed(content, WAITING, RUNNING):
            return
        assert self._repetition is not None
        self._bookmarks.pop(name, None)
        self._bookmarks[name] = self._repetition.progress(name)
        while len(self._bookmarks) > _MOST_BOOKMARKS:
            del self._bookmarks[next(iter(self._bookmarks))]
        self._say("bookmark", name)

    def _back(self, content: Dict[str, Any]) -> None:
        """Going back to a bookmark begins: the repetition ends, uncredited."""
        name = text_field(content, "bookmark")
        if not self._in_practice(content) or not self._allowed(content, WAITING, RUNNING, BETWEEN):
            return
        # Even the last repetition does not end the trial so: what comes counts for nothing.
        self._leave(WENT_BACK)
        self._say("back", name)
        self.phase = PREPARING

    def _abort(self, content: Dict[str, Any]) -> None:
        reason, by = text_field(content, "reason", "aborted"), text_field(content, "by")
        if self._allowed(content, READY, PREPARING, WAITING, RUNNING, BETWEEN):
            self._end(reason or "aborted", by)

    def _pause(self, content: Dict[str, Any]) -> None:
        self._say("pause", text_field(content, "by"), {"on": content.get("on", True) is not False})

    def _mark(self, content: Dict[str, Any]) -> None:
        value = text_field(content, "verdict")
        if value not in (sheets.PASSED, sheets.FAILED):
            raise BadEntryError(f"verdict is '{value[:40]}'; passed or failed is needed")
        given = {"verdict": value, "by": text_field(content, "by")}
        self._marks.append({**given, "reason": text_field(content, "reason"), "time": self._time})
        self._say("mark", value)

    def _note(self, content: Dict[str, Any]) -> None:
        text = text_field(content, "text")
        self._notes.append({"by": text_field(content, "by"), "text": text, "time": self._time})
        self._say("note", detail={"text": text})

    def _rate(self, content: Dict[str, Any]) -> None:
        self._allowed(content, ENDED)

    def _takes_aside(self, entry: Entry) -> bool:
        """Take an input that leaves no trace in the sheet; tells whether it is one."""
        try:
            content = json_of(entry)
        except BadEntryError:
            return False
        kind = content.get("input")
        if kind == MOMENT:
            self._count(entry)
            return True
        if kind != TLX or self.phase != ENDED:
            return False
        try:
            self.workload = workload_of(content.get("values"))
        except BadEntryError as error:
            self._new.append(JudgeEvent(self._time, "refused", TLX, {"reason": str(error)}))
        else:
            self._new.append(JudgeEvent(self._time, TLX, "", sheets.rounded(self.workload)))
        return True

    def _outside(self, content: Dict[str, Any]) -> None:
        what = text_field(content, "what") or "something"
        if self.phase in (PREPARING, WAITING, RUNNING, BETWEEN):
            self._invalidate(f"{what[:80]} from outside")

    # What comes of it

    def _finish(self, repetition: Repetition) -> None:
        made = repetition.sheet()
        if repetition.bookmark:
            self._practise(repetition, made)
            return
        made["passed"] = sheets.passes(self.exercise, made)
        self._finished.append(made)
        self._say(
            "repetition",
            "passed" if repetition.completed else repetition.fault,
            {"number": repetition.number, "seconds": repetition.time},
        )
        self.phase = BETWEEN

    def _end_if_complete(self) -> None:
        most = self.exercise.repetitions.most
        if most and len(self._finished) >= most:
            self._end("complete")

    def _practise(self, repetition: Repetition, made: Dict[str, Any]) -> None:
        """Note a repetition that went on from a bookmark, apart from all that counts."""
        made.update(bookmark=repetition.bookmark, repetition=repetition.number)
        self._practised.append(made)
        self._say(
            "practised",
            "completed" if repetition.completed else repetition.fault,
            {"number": repetition.number, "bookmark": repetition.bookmark},
        )
        self.phase = BETWEEN

    def _end(self, reason: str, by: str = "") -> None:
        self._ended_by = reason
        if self._header.get("mode") == EXAM and self._pace.slow_share > MOST_SLOW:
            self._invalidate("the simulation did not keep up with the wall's time")
        self.phase = ENDED
        self._say("end", reason, {"by": by} if by else {})

    def _verdict(self, found: List[Dict[str, Any]], completed: int) -> str:
        """Empty while it goes on, and where the trial is invalid or was left."""
        left = self._ended_by not in ("complete", "time")
        exam = self._header.get("mode") == EXAM
        if self.phase != ENDED or (exam and (self._reasons or left)):
            return ""
        if left and completed < self.exercise.repetitions.least:
            return ""
        return sheets.verdict(self.exercise, completed, found)

    def _invalidate(self, reason: str, **detail: Any) -> None:
        known = reason in self._reasons
        if not known and len(self._reasons) < _MOST_REASONS:
            self._reasons.append(reason)
        self._say("invalid", reason, detail)

    def _say(
        self,
        event: str,
        name: str = "",
        detail: Optional[Dict[str, Any]] = None,
        secret: bool = False,
    ) -> None:
        made = JudgeEvent(self._time, event, name, sheets.rounded(detail or {}), secret)
        self._new.append(made)
        if len(self._events) < _MOST_EVENTS:
            self._events.append(made)
        running = self._repetition is not None and self.phase == RUNNING
        if running and event in EVENTS and event not in _UNCOUNTED:
            assert self._repetition is not None
            self._repetition.count(event)

    def _hint_on(self, *names: str) -> None:
        """Show the hint that belongs to a step, a fault, a penalty or an event, in practice."""
        if self._header.get("mode") == EXAM:
            return
        for hint in self.exercise.hints:
            if hint.on in names and hint.on:
                self._hint = hint.text
                self._say("hint", hint.on, {"text": hint.text})

    def state(self) -> Dict[str, Any]:
        """Return the fields of telex_msgs/TrainingState, but its header and bookmarks."""
        exercise, repetition = self.exercise, self._repetition
        running = repetition if repetition is not None and self.phase != IDLE else None
        answered = running.answers if running else {}
        return {
            "phase": self.phase,
            "trial": self._header.get("trial", ""),
            "exercise": exercise.name,
            "title": exercise.title,
            "setting": exercise.setting,
            "mode": self._header.get("mode", ""),
            "operator": self._header.get("operator", ""),
            "valid": not self._reasons,
            "invalid_because": list(self._reasons),
            "repetition": self.repetition,
            "repetitions": exercise.repetitions.most,
            "from_bookmark": running.bookmark if running else "",
            "results": [
                "passed" if made["completed"] else made["fault"] for made in self._finished
            ],
            "elapsed": running.seconds if running else 0.0,
            "penalty": running.penalty if running else 0.0,
            "trial_elapsed": self._trial_time,
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
            "malfunctions": self._malfunctions.announced(),
            "hint": self._hint,
            "message": self._message,
            "verdict": self.sheet()["verdict"] if self.phase == ENDED else "",
        }

    def sheet(self) -> Dict[str, Any]:
        """Return the score sheet as plain data, rounded; `sheet_text` writes it."""
        exercise = self.exercise
        figures = sheets.summary(exercise, self._finished)
        found = sheets.results(exercise, self._finished, figures)
        header = self._header
        link = {"link": self._link.settings} if self._link.settings else {}
        return sheets.rounded(
            {
                **link,
                **self._activity.aids.sheet(),
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
                    "sha256": self._digest.hexdigest(),
                    "samples": self._continuity.samples,
                    "gaps": self._continuity.gaps,
                },
                "valid": not self._reasons,
                "invalid_because": list(self._reasons),
                "real_time_factor": {
                    **self._pace.figures(),
                    "slow_share": self._pace.slow_share,
                    "slow": self._pace.stretches,
                },
                "ended": self._ended_by,
                "trial_seconds": self._trial_time,
                "repetitions": self._finished,
                # Sheets of trials that had none stay as they were.
                **({"practised": self._practised} if self._practised else {}),
                "summary": figures,
                "metrics": found,
                "expert": {
                    "provisional": exercise.expert.by == "script",
                    "sees": exercise.expert.sees,
                    "repetitions": exercise.expert.repetitions,
                },
                "verdict": self._verdict(found, figures["completed"]),
                "malfunctions": [each.sheet() for each in self._malfunctions.episodes],
                "marks": self._marks,
                "notes": self._notes,
                "events": [
                    {
                        "time": event.time,
                        "event": event.event,
                        "name": event.name,
                        "detail": event.detail,
                    }
                    for event in self._events
                ],
            }
        )

    def text(self) -> str:
        """Return the score sheet as JSON with sorted keys."""
        return sheets.sheet_text(self.sheet())


def _sample_of(entry: Entry) -> Sample:
    if entry.kind != "telex_msgs/TruthSample":
        raise BadEntryError(f"its type is '{entry.kind}'; telex_msgs/TruthSample is needed")
    return read_sample(entry.data)
