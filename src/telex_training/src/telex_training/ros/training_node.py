"""The node ``training``: its services, its state, and who is at the console."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from telex_msgs.msg import (
    BridgeClients,
    SimStatus,
    TrainingEvent,
    TrainingExercise,
    TrainingQuestion,
    TrainingSheet,
    TrainingState,
)
from telex_msgs.srv import (
    AnswerQuestion,
    Bookmark,
    ListExercises,
    ListExercisesResponse,
    NoteTrial,
    OpenExercise,
    Restore,
)

from telex_control.common.params import ConfigError, read_config
from telex_control.ros.node_start import init_node

from ..briefing.texts import merged_texts
from ..exercises.catalog import exercises, find_exercise, known_exercise
from ..exercises.exercise_file import ExerciseError, load_exercise
from ..exercises.model import EXAM, PRACTICE, Exercise
from ..exercises.robot_needs import lacking
from ..judging.entries import TELEMETRY
from ..judging.trial_record import ENDED, IDLE, READY, JudgeEvent
from ..judging.workload import INPUT as TLX
from ..judging.workload import workload_of
from ..progress.index import ProgressIndex, ProgressIndexError
from ..progress.people import expire
from ..recording.amending import amend
from ..recording.trial_file import SUFFIX
from ..recording.writer import RecordingError
from .apparatus import Apparatus
from .channels import hear_decoded
from .exam.exam_list import ExamList, ExamListError
from .library import Library
from .pages.brief_pages import OpenTrial
from .pages.class_pages import ClassPages
from .pages.training_pages import TrainingPages
from .robot_files import about_robot, software_version
from .session import Session, SessionError
from .settings import TrainingSettings
from .texts import TraineeTexts
from .trial.presence import Presence
from .trial.team import require_in_team, require_opening, settings_of

_LONGEST_NAME = 40  # as of clients of the bridge and the video server
_MOST_TEXT = 2000
_DAY = 86400.0
_NOT_LISTED = ("own", "texts", "further")
"""What is known of an exercise's file, but not told by ``training/list``."""

Fields = Dict[str, Any]
"""Of a service's answer, but that it was a success."""
Act = Callable[[Any], Optional[Fields]]
"""Does what a service asks for; raises what the answer is to tell."""


class TrainingNode:
    """Lets operators and instructors open exercises, do them, and see how well it went."""

    def __init__(self, settings: TrainingSettings) -> None:
        self._settings = settings
        self._folder = Path(os.path.expanduser(settings.folder))
        self._library = Library(self._folder)
        self._lock = threading.RLock()
        self._offers: Dict[Path, Tuple[int, Dict[str, Any]]] = {}
        self._session: Optional[Session] = None
        self._presence = Presence()
        self._asked_for_help: Optional[float] = None
        self._telemetry = ""
        self._wanted = threading.Event()
        self._robots = [f"/{name}" for name in settings.others]
        prefixes = ["", *(f"{each}/" for each in self._robots)]
        self._state, *self._other_states = (
            rospy.Publisher(f"{each}training/state", TrainingState, queue_size=4, latch=True)
            for each in prefixes
        )
        self._events = [
            rospy.Publisher(f"{each}training/events", TrainingEvent, queue_size=100)
            for each in prefixes
        ]
        self._sheets = [
            rospy.Publisher(f"{each}training/sheet", TrainingSheet, queue_size=4, latch=True)
            for each in prefixes
        ]
        self._exam = ExamList(settings.bridge, self._on_list_lifted, others=self._robots)
        self._apparatus = Apparatus(self._on_status, self._robots)
        self._clients = [
            hear_decoded(
                f"{robot}/bridge/clients" if robot else "bridge/clients",
                BridgeClients,
                partial(self._presence.hear, robot),
            )
            for robot in ("", *self._robots)
        ]
        self._console = hear_decoded(TELEMETRY, String, self._on_telemetry)
        class_pages = ClassPages(self._tell_class, self._open_for_class, self._help)
        self.pages = TrainingPages(
            self._library, self._folder, settings.port, self._rate, class_pages
        )
        self.pages.briefs.opened = self._opened
        self.pages.briefs.texts = self._own_texts
        self._texts = TraineeTexts(
            self._note_said, self._presence.name, self._robots, self._trials_robots, self.for_team
        )
        acts: Dict[str, Tuple[Any, Act]] = {
            "training/open": (OpenExercise, self._on_open),
            "training/start": (Trigger, lambda _: self._trigger(self._start)),
            "training/again": (Trigger, lambda _: self._trigger(Session.again)),
            "training/abort": (Trigger, self._on_abort),
            "training/call_off": (Trigger, self._on_call_off),
            "training/bookmark": (Bookmark, self._on_bookmark),
            "training/back": (Restore, self._on_back),
            "training/help": (SetBool, lambda request: self._help(request.data)),
            "training/answer": (AnswerQuestion, self._on_answer),
            "training/note": (NoteTrial, self._on_note),
            "training/rate": (NoteTrial, self._on_rate),
        }
        services = {name: (kind, _answering(kind, act)) for name, (kind, act) in acts.items()}
        services["training/list"] = (ListExercises, self._on_list)
        self._services = [
            rospy.Service(name, kind, answer) for name, (kind, answer) in services.items()
        ]
        # In a further robot's namespace, for its operators: their bridge knows no other.
        self._services += [
            rospy.Service(f"{robot}/{name}", kind, self.for_team(kind, answer, name, robot))
            for robot in self._robots
            for name, (kind, answer) in services.items()
        ]
        self._publish_state()

    # --- services --------------------------------------------------------------------------------

    def for_team(
        self, kind: Any, answer: Callable[[Any], Any], name: str, robot: str
    ) -> Callable[[Any], Any]:
        """Return what answers a further robot's operator: other robots' exercises are not his."""
        place = 1 + self._robots.index(robot)
        if name == "training/list":
            return lambda request: self._on_list(request, place)

        def answer_team(request: Any) -> Any:
            try:
                if name == "training/open":
                    file = load_exercise(known_exercise(request.exercise))
                    exercise = file.setting(request.setting)
                    require_opening(self._session, exercise, robot, place)
                elif kind is not NoteTrial or self._session is not None:
                    # A note may be of a trial of another day, with nothing open.
                    require_in_team(self._open_session(), robot)
            except (SessionError, ValueError) as error:
                return kind._response_class(success=False, message=str(error))
            return answer(request)

        return answer_team

    def _on_list(self, request: Any, place: int = 0) -> ListExercisesResponse:
        """List what can be opened at a robot: the first, or a further one by its place."""
        best = self._library.best(request.operator)
        listed = []
        for name, path in exercises().items():
            offer = self._offer(path)
            settings = settings_of(offer, place)
            if place and not settings:
                continue
            own = best.get(offer.get("own", ""), 0.0)
            shown = {key: value for key, value in offer.items() if key not in _NOT_LISTED}
            shown["settings"] = settings
            listed.append(TrainingExercise(name=name, best=own, **shown))
        return ListExercisesResponse(exercises=listed)

    def _offer(self, path: Path) -> Dict[str, Any]:
        """What the list says of an exercise's file; read again only where that has changed.

        ``own`` is the name by which sheets know it, ``texts`` what it says in other languages,
        ``further`` how many robots beside the first each setting is for.
        """
        try:
            changed = path.stat().st_mtime_ns
        except OSError:
            changed = -1
        known = self._offers.get(path)
        if known is None or known[0] != changed:
            known = self._offers[path] = (changed, self._read_offer(path))
        return dict(known[1])

    def _read_offer(self, path: Path) -> Dict[str, Any]:
        try:
            file = load_exercise(path)
        except ExerciseError as error:
            return {"problem": str(error)}
        first = file.first
        return {
            "own": first.name,
            "texts": file.texts,
            "further": {name: len(each.robots) for name, each in file.settings.items()},
            "title": first.title,
            "description": first.description,
            "settings": list(file.settings),
            "modes": list(first.modes),
            "preview": self.pages.preview_address(path),
        }

    def _own_texts(self) -> Dict[str, Dict[str, str]]:
        """What exercises say in other languages by their own files."""
        session = self._session
        paths = [*exercises().values(), *([] if session is None else [session.exercise.path])]
        return merged_texts(self._offer(path).get("texts", {}) for path in paths)

    def _on_open(self, request: Any) -> Fields:
        try:
            # Callers may sit anywhere: which files the station has is not for them to try out.
            path = known_exercise(request.exercise)
            session = self.open(path, request.setting, request.mode, request.operator)
        except (SessionError, ValueError) as error:
            rospy.logwarn("training/open: %s", error)
            raise
        return {"message": f"opened: {session.exercise.title}", "trial": session.trial}

    def open(self, path: Path, setting: str, mode: str, operator: str) -> Session:
        """Open an exercise.

        Parameters
        ----------
        path : Path
            Of its file.
        setting, mode : str
            Empty: the first setting, practice.

        Raises
        ------
        ExerciseError, SessionError, ValueError
            With a message for a person.
        """
        operator = operator.strip()
        if len(operator) > _LONGEST_NAME or not operator.isprintable():
            raise SessionError(
                f"operator is {operator[:_LONGEST_NAME]!r}; at most {_LONGEST_NAME} printable "
                "characters are possible"
            )
        file = load_exercise(path)
        exercise = file.setting(setting)
        mode = mode or PRACTICE
        if mode not in exercise.modes:
            raise ExerciseError(
                f"{file.path}: mode is '{mode}'; there are: {', '.join(exercise.modes)}"
            )
        others = self._team(exercise)
        about = about_robot(others)
        _require_robot(exercise, about["urdf"], self._apparatus)
        for name, urdf in about["urdfs"].items():
            _require_robot(exercise, urdf, self._apparatus, name, others[name])
        with self._lock:
            self._refuse_second()
            # The one before is left once there is another: this one may be refused.
            session = Session(
                file,
                exercise,
                mode,
                operator,
                software_version(),
                self._folder,
                about,
                self._apparatus,
                list(self._settings.recorded),
                self._wanted.set,
                self._tell,
                self._show,
                others,
                self._robots,
            )
            if self._session is not None:
                self._session.leave()
                self._session.wait_closed()
            self._session, self._asked_for_help = session, None
            self._texts.clear()
        if mode == PRACTICE:
            session.load()
        self._wanted.set()
        return session

    def _team(self, exercise: Exercise) -> Dict[str, str]:
        """Return the namespaces of an exercise's further robots, by its names.

        Raises
        ------
        ExerciseError
            There are too few robots.
        """
        if len(exercise.robots) > len(self._robots):
            needed, there = 1 + len(exercise.robots), 1 + len(self._robots)
            raise ExerciseError(
                f"{exercise.path}: robots: the exercise is for {needed} robots, and the station "
                f"has {there}; start it with robots:={needed}"
            )
        return {robot.name: name for robot, name in zip(exercise.robots, self._robots)}

    def _opened(self) -> Optional[OpenTrial]:
        session = self._session
        if session is None:
            return None
        return OpenTrial(session.trial, session.exercise, session.mode, session.operator)

    def _refuse_second(self) -> None:
        session = self._session
        if session is not None and session.begun:
            raise SessionError(
                f"a trial of {session.exercise.title} is {session.phase} "
                f"({session.operator or 'no name'}); it has to be ended first"
            )

    def _trigger(self, act: Callable[[Session], None]) -> None:
        """Do something to the session that is open.

        Raises
        ------
        SessionError
        """
        with self._lock:
            act(self._open_session())
        self._somebody_is_there()

    def _somebody_is_there(self) -> None:
        self._presence.stay(self._trials_robots())
        self._wanted.set()

    def _start(self, session: Session) -> None:
        """Start a trial; of an exam, once the list holds.

        Raises
        ------
        SessionError
        """
        if session.mode != EXAM or session.phase != READY:
            session.start()
            return
        try:
            self._exam.take(session.trial)
        except ExamListError as error:
            raise SessionError(str(error)) from error
        try:
            session.start()
        except Exception:
            self._exam.release(session.trial)
            raise
        if not self._exam.holds(session.trial):
            # Before its trial began: nobody has told it.
            self._list_ended(session)

    def _on_list_lifted(self) -> None:
        session = self._session
        if session is not None and session.begun and session.mode == EXAM:
            self._list_ended(session)

    def _list_ended(self, session: Session) -> None:
        session.outside("the exam's list ended")

    def _end_list(self) -> None:
        """Let an exam's list end with its trial, once that is recorded to its end."""
        session = self._session
        of = self._exam.trial
        if of and (session is None or session.trial != of or session.closed):
            self._exam.release(of)

    def _open_session(self) -> Session:
        if self._session is None:
            raise SessionError("no exercise is open; training/open opens one")
        return self._session

    def _on_abort(self, _request: Any) -> None:
        self._trigger(lambda session: session.abort("aborted", given_up=True))

    def _on_call_off(self, _request: Any) -> None:
        """End a trial as its instructor, which is not held against the operator."""
        self._trigger(lambda session: session.abort("aborted", "instructor"))

    def _on_bookmark(self, request: Any) -> Fields:
        if request.replaces:
            raise SessionError(
                f"replaces is '{request.replaces[:80]}'; the trial's own are replaced by age"
            )
        session = self._open_session()
        name = session.bookmark(request.name)
        names = session.state()["bookmarks"]
        return {"message": f"bookmark '{name}' is set", "name": name, "names": names}

    def _on_back(self, request: Any) -> Fields:
        with self._lock:
            name = self._open_session().back(request.name)
        self._somebody_is_there()
        said = f"back to '{name}': practice only, it counts for nothing"
        return {"message": said, "name": name}

    def _help(self, wanted: bool) -> None:
        """Ask for the instructor, or say that he has come.

        Raises
        ------
        SessionError
            No exercise is open.
        """
        session = self._open_session()
        if wanted == (self._asked_for_help is not None):
            return
        self._asked_for_help = time.monotonic() if wanted else None
        if wanted and session.begun:
            session.note({"input": "note", "text": "asked for help", "by": session.operator})
        self._wanted.set()

    def _note_said(self, content: Dict[str, Any]) -> None:
        """Record what instructor and trainee have said to each other while a trial is under way."""
        session = self._session
        if session is not None and session.begun:
            session.note(content)

    def _on_answer(self, request: Any) -> None:
        self._open_session().answer(request.question, request.answer[:_MOST_TEXT])

    def _on_note(self, request: Any) -> None:
        self._note(request.trial, _note_input(request))

    def _on_rate(self, request: Any) -> None:
        """Take the operator's own workload, of the trial that he has just done."""
        request.kind, request.trial = TLX, ""
        self._on_note(request)

    def _rate(self, trial: str, ratings: List[float]) -> None:
        """Add an operator's ratings of his workload; for the sheet's page."""
        self._note(trial, {"input": TLX, "values": ratings})

    def _note(self, trial: str, content: Dict[str, Any]) -> None:
        """Add something to the recording of a trial; of one that has ended the sheet is shown anew.

        Raises
        ------
        SessionError, RecordingError
        """
        session = self._session
        if not trial:
            if session is None or session.path is None:
                raise SessionError("there is no trial yet; a name of one is needed")
            trial = session.trial
        if session is not None and trial == session.trial and session.begun:
            if content["input"] != "note":
                raise SessionError("the trial goes on; it can be marked once it has ended")
            session.note(content)
            return
        if session is not None and not session.begun and not session.wait_closed():
            raise SessionError("the recording is still being closed; again in a moment")
        path = self._library.path(trial)
        if path is None:
            raise SessionError(f"trial is '{trial}'; there is no recording {trial}{SUFFIX}")
        sheet = amend(path, [content], time.time_ns())
        self._library.forget()
        self._publish_sheet(trial, sheet)

    # --- what happens ----------------------------------------------------------------------------

    def _on_status(self, status: SimStatus) -> None:
        session = self._session
        if session is not None:
            session.hear_status(status)

    def _on_telemetry(self, message: String) -> None:
        self._telemetry = message.data

    def _look_who_is_there(self) -> None:
        """End a trial whose operators have been gone for long: their pages were closed, or lost."""
        session, away = self._session, self._settings.away
        if session is None or not session.begun or not away:
            self._presence.rest()
            return
        robots = self._trials_robots()
        if self._presence.left(robots, rospy.get_time(), away):
            # That a bridge has ended is nobody's giving up.
            given_up = not self._presence.silent(robots)
            with contextlib.suppress(SessionError), self._lock:
                session.abort("abandoned", "training", given_up=given_up)

    def _trials_robots(self) -> List[str]:
        """Namespaces of the robots of what is open; that of the first is empty."""
        session = self._session
        return ["", *([] if session is None else session.others.values())]

    def _tell(self, trial: str, event: JudgeEvent) -> None:
        message = TrainingEvent(
            trial=trial,
            event=event.event,
            name=event.name,
            detail=json.dumps(event.detail, sort_keys=True),
        )
        message.header.stamp = rospy.Time.from_sec(event.time)
        self._publish_to_team(self._events, message)

    def _show(self, trial: str, sheet: str) -> None:
        self._library.forget()
        self._publish_sheet(trial, sheet)

    def _publish_sheet(self, trial: str, sheet: str) -> None:
        message = TrainingSheet(trial=trial, sheet=sheet)
        message.header.stamp = rospy.get_rostime()
        self._publish_to_team(self._sheets, message)

    def _publish_to_team(self, publishers: List[rospy.Publisher], message: Any) -> None:
        """Tell something of a trial at its robots; of one that is open no more at the first."""
        session = self._session
        is_open = session is not None and session.trial == message.trial
        team = self._trials_robots() if is_open else [""]
        for robot, publisher in zip(["", *self._robots], publishers):
            if robot in team:
                publisher.publish(message)

    def _publish_state(self) -> None:
        session = self._session
        message = TrainingState(phase=IDLE)
        if session is not None:
            state = session.state()
            state["questions"] = [TrainingQuestion(**each) for each in state["questions"]]
            message = TrainingState(**state, help=self._asked_for_help is not None)
        message.header.stamp = rospy.get_rostime()
        self._state.publish(message)
        team = self._trials_robots()
        idle = TrainingState(header=message.header, phase=IDLE)
        for robot, publisher in zip(self._robots, self._other_states):
            publisher.publish(message if robot in team else idle)

    # --- for the class's page --------------------------------------------------------------------

    def _tell_class(self) -> Dict[str, Any]:
        """What a class's page shows of this station."""
        session, asked = self._session, self._asked_for_help
        state = {"phase": IDLE} if session is None else session.state()
        return {
            **state,
            "help": None if asked is None else time.monotonic() - asked,
            "holder": self._presence.name(),
            "view": view_of(self._telemetry),
        }

    def _open_for_class(
        self, exercise: str, setting: str, mode: str, operator: str, start: bool
    ) -> str:
        """Open an exercise, and start it if that is wanted; returns the trial.

        Raises
        ------
        ExerciseError, SessionError, ValueError
        """
        session = self.open(known_exercise(exercise), setting, mode, operator)
        if start:
            try:
                self._trigger(self._start)
            except SessionError as error:
                raise SessionError(f"it is open, but not started: {error}") from error
        return session.trial

    def keep_no_longer(self) -> None:
        """Remove what is older than the parameter allows, now and once a day."""
        days = self._settings.retention
        if days > 0.0:
            threading.Thread(
                target=self._expire, args=(days,), name="retention", daemon=True
            ).start()

    def _expire(self, days: float) -> None:
        index = ProgressIndex(self._folder)
        while not rospy.is_shutdown():
            try:
                for path in expire(index, days):
                    rospy.loginfo("training: older than %g days, removed: %s", days, path)
            except (ProgressIndexError, OSError) as error:
                rospy.logerr("training: retention: %s", error)
            self._library.forget()
            time.sleep(_DAY)

    def run(self) -> None:
        """Tell the state at every change, and at its rate while a trial runs."""
        told_at = -1.0
        while not rospy.is_shutdown():
            changed = self._wanted.wait(0.05)
            now = rospy.get_time()
            self._look_who_is_there()
            self._end_list()
            session = self._session
            running = session is not None and session.begun and session.phase != ENDED
            due = running and abs(now - told_at) >= 1.0 / self._settings.state_rate
            if changed or due:
                self._wanted.clear()
                told_at = now
                self._publish_state()

    def close(self) -> None:
        """End the trial, if one runs, and close its recording."""
        if self._session is not None:
            self._session.close("the training node was ended")
            self._end_list()
        self.pages.close()


def _answering(kind: Any, act: Act) -> Callable[[Any], Any]:
    """Return what answers a service by doing something."""

    def answer(request: Any) -> Any:
        try:
            return kind._response_class(success=True, **(act(request) or {}))
        except (SessionError, RecordingError, ValueError) as error:
            return kind._response_class(success=False, message=str(error))

    return answer


def view_of(telemetry: str) -> str:
    """Name of the camera that the operator's page shows large; empty: it tells none."""
    try:
        told = json.loads(telemetry)
        view = told.get("view") if isinstance(told, dict) else None
    except (ValueError, RecursionError):
        return ""
    return view if isinstance(view, str) and len(view) <= _LONGEST_NAME else ""


def _require_robot(
    exercise: Exercise, urdf: str, apparatus: Apparatus, robot: str = "", namespace: str = ""
) -> None:
    """Refuse an exercise that asks for what one of its robots lacks.

    Parameters
    ----------
    robot, namespace : str
        Of a further one; empty: the first.

    Raises
    ------
    ExerciseError, ValueError
    """
    lacks = f"this robot lacks; the variant '{exercise.variant}' is meant"
    if robot:
        lacks = f"the robot '{robot}' lacks"
    for where, text in lacking(exercise, urdf, robot):
        raise ExerciseError(f"{exercise.path}: {where}: {text}, which {lacks}")
    for i, malfunction in enumerate(exercise.malfunctions):
        failure = malfunction.failure
        if failure.robot == robot and not apparatus.can_fail(failure, namespace):
            which = f"the robot '{robot}'" if robot else "this robot"
            raise ExerciseError(
                f"{exercise.path}: malfunctions[{i}]: {failure.what} {failure.kind}: nothing of "
                f"{which} fails so"
            )


def _note_input(request: Any) -> Dict[str, Any]:
    """The judge's input for a note of the service.

    Raises
    ------
    SessionError
    """
    value, reason = request.value[:_MOST_TEXT], request.reason[:_MOST_TEXT]
    if request.kind == "mark":
        if value not in ("passed", "failed"):
            raise SessionError(f"value is '{value}'; passed or failed is needed")
        if not reason.strip():
            raise SessionError("reason is ''; a mark needs one")
        return {"input": "mark", "verdict": value, "reason": reason, "by": "instructor"}
    if request.kind == "note":
        if not value.strip():
            raise SessionError("value is ''; a text is needed")
        return {"input": "note", "text": value, "by": reason or "instructor"}
    if request.kind == TLX:
        try:
            ratings = [float(part) for part in value.replace(",", " ").split()]
            return {"input": TLX, "values": workload_of(ratings)["ratings"]}
        except ValueError:  # BadEntryError is one
            raise SessionError(
                f"value is '{value[:60]}'; six numbers from 0 to 100 are needed"
            ) from None
    raise SessionError(f"kind is '{request.kind}'; mark, note or tlx is needed")


def training_main() -> int:
    """Run the node."""
    init_node("training", coarse_clock=True)
    try:
        settings = read_config(TrainingSettings, rospy.get_param("~", {}), rospy.get_name())
    except ConfigError as error:
        rospy.logfatal("%s", error)
        return os.EX_CONFIG
    node = TrainingNode(settings)
    node.pages.start()
    node.keep_no_longer()
    if settings.video_server:
        node.pages.show_at(settings.video_server)
    try:
        if settings.exercise:
            try:
                path = find_exercise(settings.exercise)
                node.open(path, settings.setting, settings.mode, settings.operator)
            except (SessionError, ValueError) as error:
                rospy.logerr("training: %s", error)
        node.run()
    finally:
        node.close()
    return 0


if __name__ == "__main__":
    sys.exit(training_main())
