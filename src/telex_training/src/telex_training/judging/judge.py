"""The judge: folds the entries of a trial into its state and its score sheet."""

from __future__ import annotations

import math
import struct
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, Optional

from ..exercises.conditions import EVENTS
from ..exercises.model import EXAM, MODES, PRACTICE, Exercise, Failure
from ..exercises.seeds import scene_of
from . import sheet as sheets
from .actions import action_of, interference
from .activity import COMMANDS, STATUSES
from .conditions import Context
from .entries import (
    ACTIONS,
    CLIENTS,
    DOSES,
    E_STOP,
    INPUTS,
    LIGHT,
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
from .malfunctions import EpisodeEvent
from .moments import INPUT as MOMENT
from .records.aids import LASER_LINK, LASERS
from .records.handling import goal_zones
from .records.other_robot import CHANNELS, OtherRobot, channel_of
from .records.robot import Happening
from .repetition import GIVEN_UP, PUT_BACK, WENT_BACK, Progress, Repetition
from .trial_record import (
    BETWEEN,
    ENDED,
    IDLE,
    PREPARING,
    READY,
    RUNNING,
    WAITING,
    JudgeEvent,
    TrialRecord,
)
from .truth import Names, Sample, World, read_sample
from .validity import MOST_SLOW, LightRecord, LinkRecord
from .workload import INPUT as TLX
from .workload import workload_of

_MOST_BOOKMARKS = 100
_NAMES_PATIENCE = 1.0
_UNHEARD = "nothing is heard of the robot"
_UNCOUNTED = ("command", "answer", "step", "penalty", "contact", "drop", "tipped")
"""Events that the repetition counts itself."""


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
        self._record = TrialRecord(exercise)
        known = scene_of(exercise, scene) if scene else None
        self._world = World(known, urdf)
        self._others = [
            OtherRobot(robot.name, known, (urdfs or {}).get(robot.name, ""))
            for robot in exercise.robots
        ]
        self._record.others = self._others
        self._context = Context(
            self._world, exercise.zones, others={each.name: each.world for each in self._others}
        )
        self._goals = goal_zones(exercise)
        self._bookmarks: Dict[str, Progress] = {}
        self._expected: Dict[str, str] = {}
        self._new: List[JudgeEvent] = []
        self.workload: Optional[Dict[str, Any]] = None
        self._time = 0.0
        self._last: Optional[float] = None
        self._last_steps = 0
        self._nameless: Optional[float] = None
        self._resets_due = 0
        self._light = LightRecord()
        self._paused = False
        self._handlers: Dict[str, Callable[[Entry], None]] = {
            TRUTH: self._take_truth,
            NAMES: self._take_names,
            STATUS: self._take_status,
            DOSES: self._take_doses,
            ODOMETRY: self._take_odometry,
            CLIENTS: self._record.activity.clients,
            ACTIONS: self._take_action,
            LIGHT: self._take_light,
            LINK: self._take_link,
            TELEMETRY: self._take_telemetry,
            **(dict.fromkeys(LASERS, self._take_lasers) if f'"{LASER_LINK}"' in urdf else {}),
            INPUTS: self._take_input,
            MALFUNCTIONS: lambda entry: self._say_events(self._record.malfunctions.hear(entry)),
            E_STOP: lambda entry: self._say_events(self._record.malfunctions.e_stop(entry)),
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
    def phase(self) -> str:
        """As in telex_msgs/TrainingState."""
        return self._record.phase

    @property
    def repetition(self) -> int:
        """Number of the repetition that is under way or comes next, from 1."""
        return self._record.number

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
        if self._takes_aside(entry) if entry.channel == INPUTS else self._record.phase == ENDED:
            return self._new
        channel = entry.channel.encode("utf-8", "replace")
        self._record.digest.update(struct.pack("<II", len(channel), len(entry.data)))
        self._record.digest.update(channel)
        self._record.digest.update(entry.data)
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
        wrong = self._record.continuity.entry(entry.number) if self._record.phase != ENDED else None
        if wrong:
            self._invalidate("entries of the recording are missing", at=wrong)

    # What comes from the simulator

    def _take_truth(self, entry: Entry) -> None:
        sample = _sample_of(entry)
        was_reset = self._record.continuity.resets(sample)
        wrong = self._record.continuity.sample(sample)
        if self._record.phase not in (IDLE, READY):
            for reason in wrong:
                self._invalidate(reason)
        wanted = sample.resets == self._resets_due
        if was_reset and not wanted and self._record.phase in (WAITING, RUNNING, BETWEEN):
            self._invalidate("the simulation was reset from outside")
            self._put_back_from_outside()
        self._time = self._context.time = sample.time
        if self._pace_counts() and self._record.pace.sample(sample.time, sample.wall_time):
            self._say("slow")
        if not self._world.knows(sample):
            self._miss_names(sample.time)
            return
        self._nameless = None
        self._world.take(sample)
        self._say_events(self._record.malfunctions.sample(sample.time))
        # Time in which the apparatus is put back does not count.
        counts = self._record.phase in (WAITING, RUNNING) and self._last is not None
        span = max(0.0, sample.time - (self._last or 0.0)) if counts else 0.0
        steps = max(0, sample.steps - self._last_steps)
        self._last, self._last_steps = sample.time, sample.steps
        self._judge(span, steps)

    def _pace_counts(self) -> bool:
        # While the apparatus is put back, the simulator may stand.
        return self._record.phase in (WAITING, RUNNING, BETWEEN)

    def _miss_names(self, time: float) -> None:
        if self._nameless is None:
            self._nameless = time
        elif time - self._nameless > _NAMES_PATIENCE and self._record.phase in (WAITING, RUNNING):
            self._invalidate("the names of the truth are missing")

    def _judge(self, span: float, steps: int) -> None:
        repetition = self._record.repetition
        if repetition is None or self._record.phase not in (WAITING, RUNNING):
            return
        sample = self._world.sample
        if (
            self._record.phase == WAITING
            and sample is not None
            and sample.resets < self._resets_due
        ):
            # It was on its way when the apparatus was put back.
            return
        if not self._all_there():
            return
        self._record.trial_time += span
        for activity in (self._record.activity, *(other.activity for other in self._others)):
            activity.aids.pass_time(span)
        if self._record.phase == WAITING:
            if repetition.wait():
                self._record.phase = RUNNING
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
        if limit and self._record.trial_time >= limit and self._record.phase != ENDED:
            self._end("time")

    def _all_there(self) -> bool:
        """Whether further robots are heard of, as they must be while one waits to begin."""
        for other in self._others:
            if other.is_there(self._time, self._resets_due):
                continue
            text = f"{_UNHEARD} '{other.name}'"
            if self._record.phase == WAITING:
                self._record.message = text
                return False
            if text not in self._record.reasons:
                self._invalidate(text)
        if self._record.phase == WAITING and self._record.message.startswith(_UNHEARD):
            self._record.message = ""
        return True

    def _take_of_other(self, other: OtherRobot, channel: str, entry: Entry) -> None:
        entry = entry._replace(channel=channel)
        if channel == TRUTH:
            self._take_truth_of_other(other, entry)
        elif channel == ACTIONS:
            self._take_action(entry)
        elif channel == LINK:
            self._hear_line(other.link, entry, {"robot": other.name})
        elif channel == MALFUNCTIONS:
            self._say_events(other.malfunctions.hear(entry), other.name)
        elif channel == E_STOP:
            self._say_events(other.malfunctions.e_stop(entry), other.name)
        else:
            if channel in COMMANDS:
                self._say_events(other.malfunctions.command(entry), other.name)
            for event in other.hear(entry):
                if event != "command":
                    self._say(event, other.name)
                elif self._record.repetition is not None and self._record.phase in (
                    WAITING,
                    RUNNING,
                ):
                    self._record.repetition.count(event)

    def _take_truth_of_other(self, other: OtherRobot, entry: Entry) -> None:
        sample = _sample_of(entry)
        for reason in other.continuity.sample(sample):
            if self._record.phase not in (IDLE, READY):
                self._invalidate(f"{other.name}: {reason}")
        passed = other.take(sample)
        self._say_events(other.malfunctions.sample(sample.time), other.name)
        if (
            passed is not None
            and self._record.phase == RUNNING
            and self._record.repetition is not None
        ):
            self._tell(self._record.repetition.run_other(other.name, sample.time, *passed))

    def _tell(self, happened: List[Happening]) -> None:
        for event, name, detail in happened:
            self._say(event, name, detail)
            # A step's hint is for when it becomes due.
            self._hint_on(event, "" if event == "step" else name)

    def _take_names(self, entry: Entry) -> None:
        before = self._world.names
        names = Names(decode(entry, "telex_msgs/TruthNames"))
        looked = self._record.repetition is not None and self._record.repetition.looked
        if before is not None and looked and self._record.phase in (WAITING, RUNNING, BETWEEN):
            if before.objects != names.objects or before.bodies != names.bodies:
                self._invalidate("objects were put into the scene or taken out")
            elif before.revision != names.revision:
                # Taken out and put in again elsewhere, in one pause; or another robot came or went.
                self._invalidate("objects were moved, or robots came or went, from outside")
        self._world.name(names)

    def _take_doses(self, entry: Entry) -> None:
        self._world.doses.take(doses_of(entry))

    def _take_odometry(self, entry: Entry) -> None:
        pose = odometry_of(entry)
        if self._record.repetition is not None and self._record.phase == RUNNING:
            self._record.repetition.hear_odometry(pose)

    def _take_status(self, entry: Entry) -> None:
        message = decode(entry, "telex_msgs/SimStatus")
        for event in self._record.activity.sim_status(message):
            self._say(event)
        self._record.pace.pause(bool(message.paused))
        if bool(message.paused) != self._paused:
            self._paused = bool(message.paused)
            if self._record.phase != IDLE:
                self._say("pause", detail={"on": self._paused})

    def _take_action(self, entry: Entry) -> None:
        by, words = action_of(entry)
        self._note({"text": words, "by": by})
        exam = self._record.is_exam
        if exam and self._record.phase in (WAITING, RUNNING, BETWEEN):
            self._invalidate(interference(by))

    def _take_light(self, entry: Entry) -> None:
        exam = self._record.is_exam
        if self._light.take(entry) and exam and self._record.phase in (WAITING, RUNNING, BETWEEN):
            self._invalidate("the light was changed from outside")

    def _take_link(self, entry: Entry) -> None:
        self._hear_line(self._record.link, entry, {})

    def _hear_line(self, record: LinkRecord, entry: Entry, of: Dict[str, Any]) -> None:
        setting, outage = record.take(entry)
        if setting is not None:
            figures = {key: value for key, value in setting.items() if key != "profile"}
            self._say("link", setting["profile"], {**figures, **of})
            # In practice it is the instructor's to change; an exam has the line of its exercise.
            exam = self._record.is_exam
            if exam and self._record.phase in (WAITING, RUNNING, BETWEEN):
                self._invalidate("the line was changed from outside")
        if outage is not None:
            self._say("outage", detail={"on": outage, **of})

    # What the operator does

    def _take_command(self, entry: Entry) -> None:
        self._say_events(self._record.malfunctions.command(entry))
        event = self._record.activity.command(entry)
        if (
            event
            and self._record.repetition is not None
            and self._record.phase in (WAITING, RUNNING)
        ):
            self._record.repetition.count(event)

    def _take_teleop_status(self, entry: Entry) -> None:
        event = self._record.activity.teleop_status(entry)
        if event:
            self._say(event)

    def _take_telemetry(self, entry: Entry) -> None:
        event = self._record.activity.telemetry(entry)
        if event:
            self._say(event)

    def _take_lasers(self, entry: Entry) -> None:
        self._record.activity.aids.switch_lasers(decode(entry, "std_msgs/Float64").data)

    def _say_events(self, events: List[EpisodeEvent], robot: str = "") -> None:
        of = {"robot": robot} if robot else {}
        for event, episode, detail in events:
            self._say(event, episode.name, {**detail, **of}, secret=not episode.announced)

    @property
    def resets(self) -> int:
        """The simulator's number of resets from which the repetition has begun."""
        return self._resets_due

    def take_due(self) -> List[Failure]:
        """Return what shall fail now, once; who runs the trial makes it fail."""
        if self._record.repetition is None:
            return []
        due, self._record.repetition.due = self._record.repetition.due, []
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
        if self._record.phase in phases:
            return True
        self._record.message = f"{content['input']}: not now, the trial is {self._record.phase}"
        self._say("refused", content["input"], {"phase": self._record.phase})
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
        self._record.header = {**header, "seed": seed}
        self._record.phase = READY
        self._say("open", self.exercise.name)

    def _start(self, content: Dict[str, Any]) -> None:
        if self._allowed(content, READY):
            self._record.phase = PREPARING

    def _ready(self, content: Dict[str, Any]) -> None:
        due = number_field(content, "resets") if "resets" in content else 0
        bookmark, missed = text_field(content, "bookmark"), text_field(content, "missed")
        if not self._allowed(content, PREPARING):
            return
        number = len(self._record.finished) + 1
        progress = None
        if bookmark:
            # One that is not known was set while nothing could be done: still it is no start.
            progress = self._bookmarks.get(bookmark) or Progress(bookmark, number)
        self._resets_due = int(due)
        self._record.pace.cut()
        self._record.repetition = Repetition(
            number if progress is None else progress.number,
            self.exercise,
            self._context,
            self._goals,
            self._record.activity,
            self._expected,
            progress,
            {other.name: other.activity for other in self._others},
        )
        self._expected = {}
        self._record.hint, self._record.message = "", missed
        if missed:
            self._say("refused", "back", {"reason": missed})
        self._record.phase = WAITING

    def _drawn(self, content: Dict[str, Any]) -> None:
        answers = content.get("answers")
        if not isinstance(answers, dict):
            raise BadEntryError("answers: a struct of texts is needed")
        if self._allowed(content, READY, PREPARING):
            self._expected = {str(name): text_field(answers, name) for name in answers}

    def _answer(self, content: Dict[str, Any]) -> None:
        question, given = text_field(content, "question"), text_field(content, "answer")
        if not self._allowed(content, RUNNING) or self._record.repetition is None:
            return
        if self._record.repetition.answer(question, given):
            self._say("answer", question)
        else:
            self._record.message = f"'{question}' is no question, or is answered already"
            self._say("refused", "answer", {"question": question[:60]})

    def _again(self, content: Dict[str, Any]) -> None:
        if not self._allowed(content, WAITING, RUNNING, BETWEEN):
            return
        self._leave(GIVEN_UP)
        self._end_if_complete()
        if self._record.phase != ENDED:
            self._record.phase = PREPARING

    def _leave(self, fault: str) -> None:
        """End the repetition that runs with a fault; one that waits has not been."""
        if self._record.phase == RUNNING and self._record.repetition is not None:
            self._tell(self._record.repetition.spoil(fault))
            self._finish(self._record.repetition)
        self._record.repetition = None

    def _put_back_from_outside(self) -> None:
        """Leave a repetition whose world is another one now."""
        if self._record.phase == BETWEEN:
            return
        self._leave(PUT_BACK)
        self._end_if_complete()
        if self._record.phase != ENDED:
            self._record.message = "the simulation was reset from outside; again begins anew"
            self._record.phase = BETWEEN

    def _in_practice(self, content: Dict[str, Any]) -> bool:
        if not self._record.is_exam:
            return True
        self._record.message = f"{content['input']}: an exam has no bookmarks"
        self._say("refused", content["input"], {"mode": EXAM})
        return False

    def _bookmark(self, content: Dict[str, Any]) -> None:
        name = text_field(content, "name")
        if not self._in_practice(content) or not self._allowed(content, WAITING, RUNNING):
            return
        assert self._record.repetition is not None
        self._bookmarks.pop(name, None)
        self._bookmarks[name] = self._record.repetition.progress(name)
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
        self._record.phase = PREPARING

    def _abort(self, content: Dict[str, Any]) -> None:
        reason, by = text_field(content, "reason", "aborted"), text_field(content, "by")
        if not self._allowed(content, READY, PREPARING, WAITING, RUNNING, BETWEEN):
            return
        repetition = self._record.repetition
        runs = self._record.phase == RUNNING and repetition is not None and not repetition.bookmark
        if runs and content.get("given_up") is True:
            self._leave(GIVEN_UP)
        self._end(reason or "aborted", by)

    def _pause(self, content: Dict[str, Any]) -> None:
        self._say("pause", text_field(content, "by"), {"on": content.get("on", True) is not False})

    def _mark(self, content: Dict[str, Any]) -> None:
        value = text_field(content, "verdict")
        if value not in (sheets.PASSED, sheets.FAILED):
            raise BadEntryError(f"verdict is '{value[:40]}'; passed or failed is needed")
        given = {"verdict": value, "by": text_field(content, "by")}
        self._record.marks.append(
            {**given, "reason": text_field(content, "reason"), "time": self._time}
        )
        self._say("mark", value)

    def _note(self, content: Dict[str, Any]) -> None:
        text = text_field(content, "text")
        self._record.notes.append(
            {"by": text_field(content, "by"), "text": text, "time": self._time}
        )
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
        if kind != TLX or self._record.phase != ENDED:
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
        if self._record.phase in (PREPARING, WAITING, RUNNING, BETWEEN):
            self._invalidate(f"{what[:80]} from outside")

    # What comes of it

    def _finish(self, repetition: Repetition) -> None:
        made = repetition.sheet()
        if repetition.bookmark:
            self._practise(repetition, made)
            return
        made["passed"] = sheets.passes(self.exercise, made)
        self._record.finished.append(made)
        self._say(
            "repetition",
            "passed" if repetition.completed else repetition.fault,
            {"number": repetition.number, "seconds": repetition.time},
        )
        self._record.phase = BETWEEN

    def _end_if_complete(self) -> None:
        most = self.exercise.repetitions.most
        if most and len(self._record.finished) >= most:
            self._end("complete")

    def _practise(self, repetition: Repetition, made: Dict[str, Any]) -> None:
        """Note a repetition that went on from a bookmark, apart from all that counts."""
        made.update(bookmark=repetition.bookmark, repetition=repetition.number)
        self._record.practised.append(made)
        self._say(
            "practised",
            "completed" if repetition.completed else repetition.fault,
            {"number": repetition.number, "bookmark": repetition.bookmark},
        )
        self._record.phase = BETWEEN

    def _end(self, reason: str, by: str = "") -> None:
        self._record.ended_by = reason
        if self._record.is_exam and self._record.pace.slow_share > MOST_SLOW:
            self._invalidate("the simulation did not keep up with the wall's time")
        self._record.phase = ENDED
        self._say("end", reason, {"by": by} if by else {})

    def _invalidate(self, reason: str, **detail: Any) -> None:
        self._record.doubt(reason)
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
        self._record.keep(made)
        running = self._record.repetition is not None and self._record.phase == RUNNING
        if running and event in EVENTS and event not in _UNCOUNTED:
            assert self._record.repetition is not None
            self._record.repetition.count(event)

    def _hint_on(self, *names: str) -> None:
        """Show the hint that belongs to a step, a fault, a penalty or an event, in practice."""
        if self._record.is_exam:
            return
        for hint in self.exercise.hints:
            if hint.on in names and hint.on:
                self._record.hint = hint.text
                self._say("hint", hint.on, {"text": hint.text})

    def state(self) -> Dict[str, Any]:
        """See `TrialRecord.state`."""
        return self._record.state()

    def sheet(self) -> Dict[str, Any]:
        """See `TrialRecord.sheet`."""
        return self._record.sheet()

    def text(self) -> str:
        """Return the score sheet as JSON with sorted keys."""
        return sheets.sheet_text(self.sheet())


def _sample_of(entry: Entry) -> Sample:
    if entry.kind != "telex_msgs/TruthSample":
        raise BadEntryError(f"its type is '{entry.kind}'; telex_msgs/TruthSample is needed")
    return read_sample(entry.data)
