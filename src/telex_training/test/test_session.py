"""Trials that begin badly: each ends with its reason, and its recording is closed and says so."""

from __future__ import annotations

import json
import threading
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import genpy
import pytest
import rospy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from telex_msgs.msg import (
    ActiveMalfunction,
    BridgeClient,
    BridgeClients,
    InstructorAction,
    Malfunctions,
    SimStatus,
)
from telex_msgs.srv import ListExercises, NoteTrial, OpenExercise
from training_truth import LEVEL, Trial, serialized
from waiting import wait_until

from telex_sim.scene.robot_in_scene import robot_description
from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import ExerciseError, parse_exercise
from telex_training.exercises.model import Failure
from telex_training.judging.trial_record import JudgeEvent
from telex_training.recording import writer as writing
from telex_training.recording.reader import read_recording
from telex_training.recording.signature import VALID
from telex_training.recording.station_keys import PRIVATE, known_keys
from telex_training.recording.trial_file import SHEET, judged, serialised_input, signature_of
from telex_training.recording.writer import RecordingError
from telex_training.ros import channels, training_node
from telex_training.ros import session as sessions
from telex_training.ros.apparatus import ApparatusError
from telex_training.ros.trial import presence

DRILL = """
title: Drill
zones: {start: {center: [0, 0, 0], size: [1, 2, 1]}}
begin: {not: {inside: {what: robot, zone: start}}}
steps:
  - {name: on the way, until: {moved: {what: robot, distance: 1}}}
  - {name: there, until: {moved: {what: robot, distance: 3}}}
scene: {objects: []}
"""


class Clock:
    """What a session asks of rospy."""

    get_time = staticmethod(time.monotonic)
    get_rostime = staticmethod(lambda: SimpleNamespace(to_nsec=time.monotonic_ns))
    is_shutdown = staticmethod(lambda: False)
    logerr = logwarn = staticmethod(lambda *_: None)


class Simulator:
    """An apparatus that does what it is told, or fails."""

    def __init__(self):
        self.busy = threading.Lock()
        self.status = SimStatus()
        self.problem = ""
        self.lines = []
        self.failed = []
        self.ring = []
        self.did = []

    def can_fail(self, _failure, _robot=""):
        return True

    def fail(self, failure, on=True, robot=""):
        self.failed.append((failure.what, failure.kind, on))
        if self.problem:
            raise ApparatusError(self.problem)

    @property
    def resets(self):
        return self.status.resets

    def load(self, _scene):
        return self._put_back("load")

    def reset(self, _entries):
        return self._put_back("reset")

    def _put_back(self, how):
        if self.problem:
            raise ApparatusError(self.problem)
        self.did.append(how)
        self.status.resets += 1
        return self.status.resets

    def set_line(self, link, _others):
        self.lines.append(link.described)

    def restore_line(self):
        self.lines.append("as before")

    def bookmark(self, name, replaces):
        if self.problem:
            raise ApparatusError(self.problem)
        self.ring = [each for each in self.ring if each not in (name, replaces)][-9:] + [name]
        return list(self.ring)

    def bookmarks(self):
        return list(self.ring)

    def back(self, name):
        if name not in self.ring:
            raise ApparatusError(f"bookmark '{name}' has ended: 'crate' was spawned")
        return self._put_back("back")


@pytest.fixture
def simulator():
    return Simulator()


@pytest.fixture
def session(new_session):
    return new_session(DRILL)


@pytest.fixture
def new_session(tmp_path, monkeypatch, simulator):
    """Opens a drill, by its text, in a mode."""
    opened = []

    def make(text, mode="practice", **given):
        opened.append(session_of(text, mode, tmp_path, simulator, **given))
        return opened[-1]

    monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(sessions, "rospy", Clock)
    monkeypatch.setattr(sessions, "Channels", lambda *_: SimpleNamespace(close=lambda: None))
    yield make
    for session in opened:
        session.close("the test is over")


def session_of(text, mode, folder, simulator, **given):
    file = parse_exercise(text, Path("/exercises/drill.yaml"))
    about = {"urdf": "", "cameras": {}, "meshes": {}}
    events = (lambda: None, lambda *_: None, lambda *_: None)
    return sessions.Session(
        file, file.first, mode, "ann", "test", folder, about, simulator, [], *events, **given
    )


def wait(session, phase):
    deadline = time.monotonic() + 20.0
    while session.phase != phase and time.monotonic() < deadline:
        time.sleep(0.01)
    assert session.phase == phase


def ended(session):
    """The sheet of a session that ends by itself, which is that of its recording."""
    wait(session, "ended")
    assert session.wait_closed()
    recording = read_recording(session.path)
    assert recording.whole
    text = recording.attachments[SHEET].data.decode()
    assert judged(recording).text() == text
    return json.loads(text)


def test_a_scene_that_fails_ends_the_trial_and_says_why(session, simulator):
    simulator.problem = "moon.yaml: no such mesh"
    session.start()
    sheet = ended(session)
    assert sheet["ended"] == "the apparatus cannot be put back: moon.yaml: no such mesh"
    assert sheet["verdict"] == ""
    assert session.state()["message"] == sheet["ended"]


def test_the_line_is_the_exercises_for_the_trial_and_as_before_after_it(new_session, simulator):
    session = new_session(DRILL + "link: {profile: lossy, delay: 0.4}\n")
    session.start()
    wait(session, "waiting")
    session.again()
    wait(session, "waiting")
    assert simulator.lines == ["lossy (delay 0.4)"]
    session.abort("aborted")
    ended(session)
    assert simulator.lines[-1] == "as before"


def test_an_exercise_without_a_line_leaves_it_to_the_instructor(session, simulator):
    session.start()
    wait(session, "waiting")
    assert simulator.lines == []


def test_the_seed_of_an_exam_is_drawn_at_its_start(new_session, monkeypatch):
    drawn = iter((17, 4711))
    monkeypatch.setattr(sessions.secrets, "randbelow", lambda _: next(drawn))
    session = new_session(DRILL, "exam")
    session.start()
    assert "seed" not in session.state()
    wait(session, "waiting")
    assert "4711" not in json.dumps(session.state())
    assert not session.closed
    session.outside("the exam's list ended")
    session.abort("aborted")
    sheet = ended(session)
    assert session.closed
    assert sheet["exercise"]["seed"] == 4711
    assert sheet["mode"] == "exam"
    assert signature_of(session.path, known_keys()).state == VALID
    assert sheet["invalid_because"] == ["the exam's list ended from outside"]


def test_a_list_that_ends_while_its_exam_begins_makes_it_invalid(new_session):
    session = new_session(DRILL, "exam")
    node = training_node.TrainingNode.__new__(training_node.TrainingNode)
    node._exam = SimpleNamespace(take=lambda _: None, holds=lambda trial: trial != session.trial)
    node._start(session)
    wait(session, "waiting")
    assert not session.state()["valid"]
    assert session.state()["invalid_because"] == ["the exam's list ended from outside"]


def test_an_exam_whose_station_has_no_key_of_its_own_does_not_begin(new_session, tmp_path):
    session = new_session(DRILL, "exam")
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / PRIVATE).write_text("0" * 64)
    (tmp_path / "home" / PRIVATE).chmod(0o644)
    with pytest.raises(sessions.SessionError, match="the station's key: others may read"):
        session.start()
    assert session.phase == "ready"
    assert not list(tmp_path.glob("*.mcap"))


def test_a_scene_that_others_have_reset_is_loaded_anew(session, simulator):
    def did(*expected):
        wait_until(lambda: simulator.did == list(expected), f"{expected}", 20.0)
        wait_until(lambda: session._judge.resets == simulator.resets, "the repetition", 20.0)

    session.load()
    wait_until(lambda: session._resets == 1, "the scene", 20.0)
    simulator.status.resets += 1  # another scene, which somebody loads while the trainee reads
    session.start()
    did("load", "load")
    session.again()
    did("load", "load", "reset")
    simulator.status.resets = 0  # a simulator that was started again, with its own scene
    session.again()
    did("load", "load", "reset", "load")
    assert simulator.resets == 1
    # What only a reset has done leaves the bookmarks, and the scene with them.
    session.bookmark()
    simulator.status.resets += 1
    session.again()
    did("load", "load", "reset", "load", "reset")


def test_a_robot_that_lies_at_the_start_ends_the_trial(session, simulator):
    simulator.status.tipped_over = True
    session.start()
    assert "the robot lies on its side at its start" in ended(session)["ended"]


def test_a_scene_that_fails_again_later_ends_the_trial(session, simulator):
    session.start()
    wait(session, "waiting")
    simulator.problem = "/telex/sim/reset has not answered for 20 s"
    session.again()
    assert "has not answered for 20 s" in ended(session)["ended"]


def test_a_full_disk_is_said_before_the_start_and_nothing_begins(session, tmp_path, monkeypatch):
    def full(_folder):
        raise RecordingError(f"{tmp_path}: 3 MB are free; at least 200 MB are needed")

    monkeypatch.setattr(sessions, "check_room", full)
    with pytest.raises(sessions.SessionError, match="cannot be recorded: .* 3 MB are free"):
        session.start()
    assert session.phase == "ready"
    assert not list(tmp_path.glob("*.mcap"))


def test_a_disk_that_fills_is_said_and_makes_the_trial_invalid(session, monkeypatch):
    session.start()
    wait(session, "waiting")

    def full(_handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writing.os, "fsync", full)
    deadline = time.monotonic() + 20.0
    while not session.state()["message"] and time.monotonic() < deadline:
        session.hear_status(SimStatus())
        time.sleep(0.05)
    assert session.state()["message"] == "the recording is broken off: No space left on device"
    session.abort("aborted")
    wait(session, "ended")
    assert session.wait_closed()
    state = session.state()
    assert not state["valid"]
    assert "No space left on device" in state["invalid_because"][0]
    assert state["message"].startswith("the recording is not complete: ")


def test_a_text_that_is_none_does_not_reach_the_sheet(session, simulator):
    session.start()
    wait(session, "waiting")
    Truth(session).at(0.8)
    wait(session, "running")
    telemetry = serialised_input({"released": "\ud800"})
    session._hear("console/telemetry", "std_msgs/String", telemetry)
    session.again()
    wait(session, "waiting")
    session.abort("aborted")
    sheet = ended(session)
    assert sheet["ended"] == "aborted"
    assert simulator.lines[-1] == "as before"


@pytest.mark.parametrize(
    "step", ["_make_sheet", "_close_recording", "_show_sheet", "_restore_line"]
)
def test_whatever_goes_wrong_at_its_end_the_rest_is_put_in_order(
    session, simulator, monkeypatch, step
):
    def fail():
        raise KeyError("nobody has thought of this")

    mended = threading.Event()
    monkeypatch.setattr(session, step, fail)
    monkeypatch.setattr(session, "_mend", mended.set)
    session.start()
    wait(session, "waiting")
    session.abort("aborted")
    assert session.wait_closed()
    assert mended.is_set()
    assert "nobody has thought of this" in session.state()["message"]
    assert ("as before" in simulator.lines) == (step != "_restore_line")
    if step != "_close_recording":
        recording = read_recording(session.path)
        assert recording.whole
        assert (SHEET in recording.attachments) == (step != "_make_sheet")


def test_it_is_started_once_and_not_again_after_its_end(session):
    session.start()
    wait(session, "waiting")
    with pytest.raises(sessions.SessionError, match="it can be started once"):
        session.start()
    session.abort("aborted")
    assert ended(session)["ended"] == "aborted"
    for act in (session.again, session.start):
        with pytest.raises(sessions.SessionError, match="the trial is ended"):
            act()


def test_an_exercise_that_asks_for_what_the_robot_lacks_is_not_opened():
    text = DRILL.replace("{moved: {what: robot, distance: 1}}", "{held: {}}")
    holding = parse_exercise(text, Path("/exercises/drill.yaml")).first
    training_node._require_robot(holding, robot_description("standard"), Simulator())
    probe = robot_description("standard", ["tool:=probe"])
    with pytest.raises(ExerciseError, match="held: it needs a gripper, which this robot lacks"):
        training_node._require_robot(holding, probe, Simulator())
    with pytest.raises(ValueError, match="is no XML"):
        training_node._require_robot(holding, "<robot", Simulator())


BREAKING = (
    DRILL
    + """
malfunctions:
  - {when: {elapsed: 0.1}, what: left_belt, kind: thrown}
  - {when: {elapsed: 0.2}, what: arm, kind: dark, value: 0.5, announced: true}
"""
)


class Told:
    """What a session tells: to operators, and when."""

    def __init__(self):
        self.events, self.states = [], 0

    def changed(self):
        self.states += 1

    def happened(self, _trial, event):
        self.events.append((event.event, event.name))


@pytest.fixture
def breaking(tmp_path, monkeypatch, simulator):
    """A session of an exercise with malfunctions, what it tells, and what it hears."""
    heard = []
    monkeypatch.setattr(sessions, "rospy", Clock)
    monkeypatch.setattr(
        sessions, "Channels", lambda hear, *_: heard.append(hear) or SimpleNamespace(close=int)
    )
    file = parse_exercise(BREAKING, Path("/exercises/drill.yaml"))
    about, told = {"urdf": "", "cameras": {}, "meshes": {}}, Told()
    opened = sessions.Session(
        *(file, file.first, "practice", "ann", "test", tmp_path, about, simulator, []),
        *(told.changed, told.happened, lambda *_: None),
    )
    opened.start()
    wait(opened, "waiting")
    trial = Trial(file.first)
    trial.feed = lambda channel, kind, data: heard[0](channel, kind, data) or []
    trial.resets = 1
    trial.names()
    yield opened, trial, told
    opened.close("the test is over")


def failures(*active):
    return Malfunctions(
        active=[
            ActiveMalfunction(what, group, kind, 0.0, announced, rospy.Time(11))
            for what, group, kind, announced in active
        ]
    )


def test_what_fails_silently_is_told_to_nobody_before_the_end(breaking, simulator):
    session, trial, told = breaking
    trial.seconds(0.1)
    trial.at(0.7)
    trial.seconds(0.4)
    wait_until(lambda: len(simulator.failed) == 2, "both to fail", 10.0)
    assert sorted(simulator.failed) == [("arm", "dark", True), ("left_belt", "thrown", True)]
    before = session.state()
    told.events.clear()
    states = told.states
    thrown = ("left_belt", "belt", "thrown", False)
    tell = partial(trial.feed, "sim/malfunctions", "telex_msgs/Malfunctions")
    tell(serialized(failures(thrown)))
    trial.feed("e_stop", "std_msgs/Bool", serialized(Bool(True)))

    def reacted():
        failed = session._judge.sheet()["malfunctions"]
        return failed and failed[0]["e_stop"] is not None

    wait_until(reacted, "the reaction", 10.0)
    after = session.state()
    assert {key for key in after if after[key] != before[key]} <= {"elapsed", "trial_elapsed"}
    assert told.events == []
    assert told.states == states

    tell(serialized(failures(thrown, ("arm", "camera", "dark", True))))
    wait_until(lambda: told.events, "the announced one", 10.0)
    assert told.events == [("malfunction", "arm dark")]
    assert session.state()["malfunctions"] == ["arm: its pictures are dark"]
    session.abort("aborted")
    sheet = ended(session)
    assert [each["what"] for each in sheet["malfunctions"]] == ["left_belt", "arm"]
    # What no reset has mended ends with the trial.
    wait_until(lambda: len(simulator.failed) == 4, "the end of both", 10.0)
    assert ("left_belt", "thrown", False) in simulator.failed


def test_a_malfunction_whose_repetition_is_over_does_not_happen(breaking, simulator):
    session, _, _ = breaking
    failure = Failure("left_belt", "thrown")
    before = simulator.resets
    session.again()
    wait_until(lambda: session._judge.resets == simulator.resets > before, "the next", 20.0)
    session._fail(failure, before)
    assert simulator.failed == []
    session._fail(failure, simulator.resets)
    session.abort("aborted")
    ended(session)
    assert simulator.failed == [("left_belt", "thrown", True), ("left_belt", "thrown", False)]
    session._fail(failure, simulator.resets)
    assert len(simulator.failed) == 2


def test_a_malfunction_that_is_refused_makes_the_trial_invalid(breaking, simulator):
    session, trial, _ = breaking
    simulator.problem = "what is 'left_belt'; there are: key"
    trial.seconds(0.1)
    trial.at(0.7)
    trial.seconds(0.3)
    wait_until(lambda: not session.state()["valid"], "the reason", 10.0)
    assert session.state()["invalid_because"] == [
        "a malfunction that could not be made from outside"
    ]


class Truth:
    """Lets a session hear a robot that drives."""

    def __init__(self, session):
        self.session, self.trial, self.heard = session, Trial(session.exercise), 0
        self.trial.names()
        self.tell()

    def tell(self):
        self.trial.resets = self.session._apparatus.resets
        self.trial.sample()
        for entry in self.trial.entries[self.heard :]:
            self.session._hear(entry.channel, entry.kind, entry.data)
        self.heard = len(self.trial.entries)

    def at(self, x):
        self.trial.robot = ((x, 0.0, 0.112), LEVEL)
        self.tell()


def test_a_step_sets_a_bookmark_and_one_goes_on_from_it(session, simulator):
    session.start()
    wait(session, "waiting")
    truth = Truth(session)
    truth.at(0.8)
    truth.at(1.5)
    wait_until(lambda: session.state()["bookmarks"] == ["on the way, repetition 1"])
    assert session.bookmark() == "mark 1, repetition 1"
    assert session.bookmark(" the door ") == "the door"
    assert simulator.ring == session.state()["bookmarks"]
    with pytest.raises(sessions.SessionError, match="name is 'x'; bookmarks of this trial: 'on"):
        session.back("x")
    assert session.back("on the way, repetition 1") == "on the way, repetition 1"
    wait(session, "waiting")
    truth.tell()
    wait(session, "running")
    state = session.state()
    assert (state["from_bookmark"], state["valid"]) == ("on the way, repetition 1", True)
    assert state["steps_done"] == [True, False]
    truth.at(3.5)
    wait(session, "between")
    assert session.back() == "the door"  # the newest
    wait(session, "waiting")
    session.abort("aborted")
    sheet = ended(session)
    assert sheet["valid"]
    assert [each["bookmark"] for each in sheet["practised"]] == ["on the way, repetition 1"]
    assert [each["fault"] for each in sheet["repetitions"]] == ["went back"]
    assert session.state()["bookmarks"] == []


def test_steps_and_marks_leave_room_for_those_with_names(session, simulator):
    simulator.ring = [f"instructor's {number}" for number in range(4)]
    session.start()
    wait(session, "waiting")
    for _ in range(9):
        session.bookmark()
    for number in range(9):
        session._set(session._bookmarks.of_step(f"step {number}", 1))
    assert simulator.ring[:4] == [f"instructor's {number}" for number in range(4)]
    assert session.state()["bookmarks"] == [
        *(f"mark {number}, repetition 1" for number in (7, 8, 9)),
        *(f"step {number}, repetition 1" for number in (6, 7, 8)),
    ]


def test_a_bookmark_that_has_ended_leads_to_the_start_and_says_so(session, simulator):
    session.start()
    wait(session, "waiting")
    name = session.bookmark()
    simulator.ring.clear()
    session.back()
    wait_until(lambda: "'crate' was spawned; all is put to the start" in session.state()["message"])
    wait(session, "waiting")
    assert session.state()["bookmarks"] == []
    assert session.state()["from_bookmark"] == ""
    with pytest.raises(sessions.SessionError, match="there is no bookmark of this trial"):
        session.back(name)


def test_no_bookmark_is_offered_that_the_simulator_refused(session, simulator):
    session.start()
    wait(session, "waiting")
    simulator.problem = "/telex/sim/bookmark has not answered for 20 s"
    with pytest.raises(sessions.SessionError, match="no bookmark is set: .*not answered"):
        session.bookmark()
    assert session.state()["bookmarks"] == []


@pytest.mark.parametrize("name", ["x" * 61, "a\nb"])
def test_a_name_that_cannot_be_shown_is_refused(session, name):
    session.start()
    wait(session, "waiting")
    with pytest.raises(sessions.SessionError, match="at most 60 characters"):
        session.bookmark(name)


def test_before_the_start_after_the_end_and_in_an_exam_there_are_none(session, new_session):
    for act in (session.bookmark, session.back):
        with pytest.raises(sessions.SessionError, match="the trial is ready"):
            act()
    session.start()
    wait(session, "waiting")
    session.abort("aborted")
    ended(session)
    for act in (session.bookmark, session.back):
        with pytest.raises(sessions.SessionError, match="the trial is ended"):
            act()
    exam = new_session(DRILL, "exam")
    exam.start()
    wait(exam, "waiting")
    for act in (exam.bookmark, exam.back):
        with pytest.raises(sessions.SessionError, match="mode is exam; bookmarks are for practice"):
            act()


class Watched:
    """What the node looks at in a session, to see whether its operator has left."""

    begun, phase = True, "running"

    def __init__(self):
        self.ended = []
        self.others = {}

    def abort(self, reason, by, given_up):
        self.ended.append((reason, by, given_up))


@pytest.fixture
def console(monkeypatch):
    """Looks who is at the robots of a trial: a time after the look before, with new holders."""
    now, wall = [100.0], [1000.0]
    monkeypatch.setattr(training_node.rospy, "get_time", lambda: now[0])
    monkeypatch.setattr(presence, "time", SimpleNamespace(monotonic=lambda: wall[0]))
    node = training_node.TrainingNode.__new__(training_node.TrainingNode)
    node._session, node._lock, node._wanted = Watched(), threading.RLock(), threading.Event()
    node._settings, node._presence = SimpleNamespace(away=30.0), presence.Presence()

    def look(after, silent=0.0, **holders):
        now[0] += after
        wall[0] += 100.0
        for name, holder in holders.items():
            robot = "" if name == "telex" else f"/{name}"
            clients = [BridgeClient(id="7", name=holder)] if holder else []
            node._presence.hear(robot, BridgeClients(holder="7" * len(clients), clients=clients))
        wall[0] += silent
        node._look_who_is_there()
        return node._session.ended

    return SimpleNamespace(look=look, node=node, team=node._session.others)


def test_a_page_that_is_gone_for_long_abandons_the_trial(console):
    look = console.look
    assert not look(0.0, telex="ann")
    assert not look(1.0, telex="")  # reloaded
    assert not look(29.0, telex="")
    assert not look(0.5, telex="ann")  # and back
    assert not look(1.0, telex="")
    assert not look(29.9, telex="")
    assert look(0.2, telex="") == [("abandoned", "training", True)]
    # That the bridge has ended is nobody's giving up.
    assert not look(1.0, silent=10.0, telex="ann")[1:]
    assert look(30.1, silent=40.0, telex="")[1:] == [("abandoned", "training", False)]


def test_a_team_has_left_once_nobody_has_any_of_its_robots(console):
    look = console.look
    console.team["second"] = "/telex_b"
    assert not look(0.0, telex="ann", telex_b="bob")
    assert not look(1.0, telex="", telex_b="bob")
    assert not look(40.0, telex="", telex_b="bob")
    assert not look(1.0, telex="", telex_b="")
    # Whoever is at a robot that is not in the team does not count.
    assert look(30.1, telex="", telex_b="", telex_c="cid") == [("abandoned", "training", True)]


def test_a_team_of_which_only_the_second_was_ever_there_leaves_as_well(console):
    look = console.look
    console.team["second"] = "/telex_b"
    assert not look(0.0, telex="", telex_b="bob")
    console.node._somebody_is_there()
    assert not look(1.0, telex="", telex_b="")
    assert look(30.1, telex="", telex_b="") == [("abandoned", "training", True)]


def test_a_trial_of_one_robot_is_left_whoever_is_at_another(console):
    look = console.look
    assert not look(0.0, telex="ann", telex_b="bob")
    assert not look(1.0, telex="", telex_b="bob")
    assert look(30.1, telex="", telex_b="bob") == [("abandoned", "training", True)]


def test_what_is_done_from_the_page_of_any_robot_is_noted(new_session, monkeypatch):
    heard = {}

    def subscriber(topic, _, hear, **__):
        heard.setdefault(topic, []).append(hear)
        return mock.Mock()

    monkeypatch.setattr(channels.rospy, "Subscriber", subscriber)
    monkeypatch.setattr(sessions, "Channels", channels.Channels)
    monkeypatch.setattr(sessions, "ConfigurationWatch", mock.Mock())
    session = new_session(DRILL, station=["/telex_b"])
    session.start()
    wait(session, "waiting")
    request = json.dumps({"daylight": 0.0, "lamps": 0.1})
    action = InstructorAction(by="ina", service="sim/set_light", request=request)
    for topic in ("bridge/actions", "/telex_b/bridge/actions"):
        (hear,) = heard[topic]
        hear(SimpleNamespace(_buff=serialized(action), _connection_header={"type": action._type}))
    assert "/telex_b/bridge/clients" not in heard
    session.abort("aborted")
    said = {"by": "ina", "text": "set daylight to 0%, lamps to 10%"}
    notes = ended(session)["notes"]
    assert [{key: each[key] for key in said} for each in notes] == [said, said]


def test_what_the_page_of_a_teams_robot_does_is_recorded_once(monkeypatch):
    topics = []
    monkeypatch.setattr(channels.rospy, "Subscriber", lambda topic, *_, **__: topics.append(topic))
    channels.Channels(mock.Mock(), [], {"second": "/telex_b"}, ["/telex_b", "/telex_c"])
    assert [each for each in topics if each.endswith("bridge/actions")] == [
        "bridge/actions",
        "/telex_b/bridge/actions",
        "/telex_c/bridge/actions",
    ]
    assert len(set(topics)) == len(topics)


def test_what_an_instructor_calls_off_is_not_given_up(station, session):
    node = station()
    node._session, node._lock, node._wanted = session, threading.RLock(), threading.Event()
    node._presence = presence.Presence()
    session.start()
    wait(session, "waiting")
    with mock.patch.object(session, "_put") as put:
        node._on_call_off(None)
        node._on_abort(None)
    assert [each.args[0] for each in put.call_args_list] == [
        {"input": "abort", "reason": "aborted", "by": "instructor"},
        {"input": "abort", "reason": "aborted", "by": "", "given_up": True},
    ]


@pytest.fixture
def station(monkeypatch):
    """A training node with further robots, which has got no further than to know of them."""

    def make(*robots):
        node = training_node.TrainingNode.__new__(training_node.TrainingNode)
        node._robots = list(robots)
        monkeypatch.setattr(training_node, "about_robot", lambda others: {"others": others})
        return node

    return make


def test_an_exercise_for_more_robots_than_there_are_is_refused(station):
    wrong = "beam.yaml: robots: the exercise is for 2 robots, and the station has 1; .*robots:=2"
    with pytest.raises(ExerciseError, match=wrong):
        station().open(find_exercise("beam"), "", "", "ann")


@pytest.fixture
def opening(station, monkeypatch, session, simulator):
    """A training node at which an exercise is open, and which can open another."""
    node = station()
    node._lock, node._session, node._apparatus = threading.RLock(), session, simulator
    node._folder, node._settings = Path(), SimpleNamespace(recorded=[])
    node._wanted, node._asked_for_help = threading.Event(), 1.0
    node._texts = mock.Mock()
    monkeypatch.setattr(training_node, "about_robot", lambda _: {"urdf": "", "urdfs": {}})
    monkeypatch.setattr(training_node, "_require_robot", lambda *_: None)
    return node


def test_what_cannot_be_opened_leaves_the_exercise_that_is_open(opening, monkeypatch, session):
    def refuse(*_):
        raise ExerciseError("slalom.yaml: the scene cannot be made")

    monkeypatch.setattr(training_node, "Session", refuse)
    with pytest.raises(ExerciseError, match="cannot be made"):
        opening.open(find_exercise("slalom"), "", "", "bob")
    assert opening._session is session
    assert opening._asked_for_help == 1.0
    opening._texts.clear.assert_not_called()
    session.start()
    wait(session, "waiting")


def test_what_is_opened_knows_nothing_of_who_was_there_before(opening, session):
    opened = opening.open(find_exercise("slalom"), "", "", "bob")
    assert opening._session is opened
    assert opening._asked_for_help is None
    opening._texts.clear.assert_called_once_with()
    assert session._left


def at_robot(node, name, kind, robot="/telex_b"):
    """What a service answers at a further robot, or "done" where the request is passed on."""
    service = node.for_team(kind, lambda _: "done", f"training/{name}", robot)

    def ask(**request):
        answer = service(SimpleNamespace(**request))
        return answer if answer == "done" else (answer.success, answer.message)

    return ask


def what_is_open(title, *team, phase="ready"):
    others = {f"robot {i}": robot for i, robot in enumerate(team)}
    exercise = SimpleNamespace(robots=tuple(others), title=title)
    return SimpleNamespace(exercise=exercise, others=others, phase=phase, operator="ann")


def test_a_teams_pages_show_its_trial_and_others_do_not(station):
    node = station("/telex_b")
    again = at_robot(node, "again", Trigger)
    node._session = what_is_open("Slalom")
    assert again() == (False, "Slalom is an exercise for one robot, the first one's")
    node._session = what_is_open("Beam for two", "/telex_b")
    assert again() == "done"
    node._session = None
    assert again() == (False, "no exercise is open; training/open opens one")
    assert at_robot(node, "note", NoteTrial)() == "done", "of a trial of another day"


def test_who_is_not_in_the_team_can_neither_end_its_trial_nor_open_its_exercise(station):
    node = station("/telex_b", "/telex_c")
    node._session = what_is_open("Beam for two", "/telex_b", phase="running")
    refused = (False, "Beam for two is an exercise for the station's first 2 robots")
    assert at_robot(node, "abort", Trigger)() == "done"
    assert at_robot(node, "abort", Trigger, "/telex_c")() == refused
    node._session = None
    asked = {"exercise": "beam", "setting": ""}
    assert at_robot(node, "open", OpenExercise)(**asked) == "done"
    assert at_robot(node, "open", OpenExercise, "/telex_c")(**asked) == refused


def test_the_state_of_a_trial_is_told_to_its_team_alone(station, session, monkeypatch):
    monkeypatch.setattr(training_node.rospy, "get_rostime", lambda: genpy.Time(7))
    node = station("/telex_b", "/telex_c")
    node._session, node._asked_for_help = session, None
    session.others = {"second": "/telex_b"}
    node._state, *node._other_states = (mock.Mock() for _ in range(3))
    node._publish_state()
    told = [each.publish.call_args.args[0] for each in (node._state, *node._other_states)]
    assert [(each.phase, each.title) for each in told] == [
        ("ready", "Drill"),
        ("ready", "Drill"),
        ("idle", ""),
    ]


def test_what_is_open_at_the_first_robot_is_thrown_out_there_alone(station):
    node = station("/telex_b")
    node._session = None
    opening = at_robot(node, "open", OpenExercise)
    assert opening(exercise="slalom", setting="") == (
        False,
        "Slalom is an exercise for one robot, the first one's",
    )
    assert "nonsense" in opening(exercise="nonsense", setting="")[1]
    node._session = what_is_open("Slalom")
    success, message = opening(exercise="beam", setting="")
    assert not success
    assert message.startswith("Slalom is open at the first robot for ann; ")
    node._session.phase = "ended"
    assert opening(exercise="beam", setting="") == "done"
    node._session = what_is_open("Beam for two", "/telex_b")
    assert opening(exercise="beam", setting="") == "done"


def test_a_team_is_told_of_its_trial_and_nobody_else(station, monkeypatch):
    monkeypatch.setattr(training_node.rospy, "get_rostime", lambda: genpy.Time(7))
    node = station("/telex_b", "/telex_c")
    node._library = mock.Mock()
    node._events, node._sheets = ([mock.Mock() for _ in range(3)] for _ in range(2))
    node._session = what_is_open("Beam for two", "/telex_b")
    node._session.trial = "beam_1"
    node._tell("beam_1", JudgeEvent(3.0, "begin", "", {}))
    node._show("beam_1", "{}")
    node._publish_sheet("another day's", "{}")
    counts = [
        [each.publish.call_count for each in publishers]
        for publishers in (node._events, node._sheets)
    ]
    assert counts == [[1, 1, 0], [2, 1, 0]]


MIXED = """
title: Mixed
scene: {objects: []}
settings:
  - {name: alone}
  - {name: in_team, robots: [{name: second, x: 2, y: 0}]}
steps: [{name: there, until: {moved: {what: robot, distance: 1}}}]
"""


def test_a_further_robots_list_has_what_can_be_opened_there(station, tmp_path, monkeypatch):
    mixed = tmp_path / "mixed.yaml"
    mixed.write_text(MIXED)
    (tmp_path / "wrong.yaml").write_text("title: 7")
    files = {
        "mixed": mixed,
        "wrong": tmp_path / "wrong.yaml",
        **{name: find_exercise(name) for name in ("slalom", "beam")},
    }
    monkeypatch.setattr(training_node, "exercises", lambda: files)
    monkeypatch.setattr(training_node, "known_exercise", files.__getitem__)
    node = station("/telex_b", "/telex_c")
    node._session, node._offers = None, {}
    node._library = SimpleNamespace(best=lambda _: {"mixed": 0.5})
    node.pages = SimpleNamespace(preview_address=lambda _: "")

    def listed(listing):
        answer = listing(SimpleNamespace(operator="bob"))
        return {each.name: list(each.settings) for each in answer.exercises}

    first = listed(node._on_list)
    assert sorted(first) == sorted(files)
    assert first["mixed"] == ["alone", "in_team"]
    at_robots = [
        listed(node.for_team(ListExercises, mock.Mock(), "training/list", robot))
        for robot in node._robots
    ]
    assert at_robots == [{"mixed": ["in_team"], "beam": first["beam"]}, {}]
    opening = at_robot(node, "open", OpenExercise)
    assert opening(exercise="mixed", setting="in_team") == "done"
    assert not opening(exercise="mixed", setting="alone")[0]
