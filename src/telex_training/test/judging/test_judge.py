"""The judge: phases, repetitions, faults, validity; the same entries make the same sheet."""

from __future__ import annotations

import json
import random
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Float64, String
from telex_msgs.msg import BridgeClient, BridgeClients, JointTeleopStatus, TruthSample
from training_truth import JOINTS, LEVEL, SCENE, Trial, exercise, serialized

from telex_sim.offline.simulation import robot_description
from telex_training.command_lines.score import sheet_report
from telex_training.judging.entries import BadEntryError, Entry
from telex_training.judging.judge import Judge
from telex_training.judging.moments import MomentNote, moment_note, moment_notes
from telex_training.judging.truth import read_sample

pytestmark = pytest.mark.slow

DRILL = """
title: Drill
zones:
  start: {center: [0, 0, 0], size: [1, 2, 1]}
  goal: {center: [3, 0, 0], size: [1, 2, 1]}
begin: {not: {inside: {what: robot, zone: start}}}
steps:
  - {name: there, until: {inside: {what: robot, zone: goal}}}
  - {name: back, until: {inside: {what: robot, zone: start}, for: 0.2}}
repetitions: {most: 3, least: 2, trial_time: 600, time: 60}
faults: [{name: too hard, when: {force: {object: wall, above: 300}}}]
penalties: [{name: cube touched, when: {touches: {object: cube}}, seconds: 5}]
metrics:
  time: {pass: 30, expert: [10, 1]}
  contacts: {pass: 1}
  faults: {pass: 1}
  proficiency: {}
hints:
  - {on: back, text: Now back.}
  - {on: cube touched, text: Mind the cube.}
"""


@pytest.fixture(scope="module")
def urdf():
    return robot_description()


def ready(text=DRILL, mode="practice", **options):
    return Trial(exercise(text), **options).begin(mode)


def lap(trial, speed=1.0):
    trial.drive(3.0, speed)
    trial.drive(0.0, speed)
    trial.seconds(0.3)


def folded(trial, entries=None):
    judge = Judge(trial.judge.exercise)
    for entry in trial.entries if entries is None else entries:
        judge.feed(entry)
    return judge


def test_a_trial_goes_through_its_phases():
    trial = Trial(exercise(DRILL))
    assert trial.judge.phase == "idle"
    trial.names()
    trial.sample()
    trial.input("open", trial="t1", operator="ann", mode="practice", seed=7)
    assert trial.judge.phase == "ready"
    trial.input("start")
    assert trial.judge.phase == "preparing"
    trial.input("ready")
    assert trial.judge.phase == "waiting"
    trial.seconds(1.0)
    assert trial.judge.phase == "waiting"
    trial.drive(1.0)
    assert trial.judge.phase == "running"
    lap(trial)
    assert trial.judge.phase == "between"
    trial.again()
    lap(trial)
    trial.again()
    lap(trial)
    assert trial.judge.phase == "ended"
    assert trial.judge.state()["verdict"] == "passed"
    sheet = trial.judge.sheet()
    assert sheet["ended"] == "complete"
    assert sheet["summary"]["completed"] == 3
    assert sheet["operator"] == "ann"
    assert sheet["exercise"]["seed"] == 7


def test_the_clock_runs_from_the_begin_in_sim_time():
    trial = ready()
    trial.seconds(5.0)
    lap(trial, 1.0)
    (made,) = trial.judge.sheet()["repetitions"]
    # From 0.5 m to 3 and back to 0.5 at 1 m/s, and 0.2 s there.
    assert made["seconds"] == pytest.approx(5.2, abs=0.1)
    assert made["steps"][0] == pytest.approx(2.0, abs=0.05)
    assert made["steps"][1] == made["seconds"]
    assert made["metrics"]["base_path"] == pytest.approx(5.2, abs=0.1)
    assert made["metrics"]["reversals"] == 1
    assert made["completed"]
    assert made["fault"] is None


def test_what_moves_the_robot_is_a_command_on_whatever_topic():
    text = DRILL.replace("begin: {not: {inside: {what: robot, zone: start}}}\n", "")
    trial = ready(text)
    trial.at(0.05)
    trial.seconds(1.0)
    assert trial.judge.phase == "waiting"
    trial.at(0.11)
    assert trial.judge.phase == "running"


def test_what_moves_the_tool_is_a_command_as_well(urdf):
    text = DRILL.replace("begin: {not: {inside: {what: robot, zone: start}}}\n", "")
    trial = ready(text, urdf=urdf)
    trial.seconds(1.0)
    trial.joints[JOINTS.index("shoulder_joint")] -= 0.2
    trial.sample()
    assert trial.judge.phase == "running"


def test_steps_count_in_their_order_alone():
    trial = ready()
    trial.at(1.0)
    trial.at(0.0)
    trial.seconds(1.0)
    assert trial.judge.state()["steps_done"] == [False, False]
    trial.at(3.0)
    assert trial.judge.state()["steps_done"] == [True, False]


def test_steps_in_any_order():
    trial = ready(DRILL + "any_order: true\n")
    trial.at(1.0)
    trial.at(0.0)
    trial.seconds(0.4)
    assert trial.judge.state()["steps_done"] == [False, True]
    trial.at(3.0)
    assert trial.judge.phase == "between"


def test_a_fault_ends_the_repetition_without_credit():
    trial = ready()
    trial.drive(2.0)
    trial.contacts = [("base", "wall", 310.0)]
    trial.sample()
    assert trial.judge.phase == "between"
    assert trial.judge.state()["results"] == ["too hard"]
    trial.contacts = []
    trial.robot = ((0.0, 0.0, 0.1), LEVEL)
    trial.again()
    lap(trial)
    assert trial.judge.state()["results"] == ["too hard", "passed"]
    assert trial.judge.sheet()["summary"]["completeness"] == 0.5


def test_a_fault_counts_before_the_last_step():
    trial = ready()
    trial.drive(3.0)
    trial.at(0.0)
    trial.sample(9)
    assert trial.judge.phase == "running"
    # With this sample the robot would have been back for long enough.
    trial.contacts = [("base", "wall", 310.0)]
    trial.sample()
    assert trial.judge.state()["results"] == ["too hard"]


def test_a_penalty_counts_once_an_occasion():
    trial = ready()
    trial.drive(1.0)
    for pause in (0.2, 1.0, 1.0):
        trial.contacts = [("tracks", "cube", 5.0)]
        trial.sample(3)
        trial.contacts = []
        trial.seconds(pause)
    # The second touch follows too soon on the first to be another one.
    assert trial.judge.state()["penalty"] == 10.0
    assert trial.judge.state()["hint"] == "Mind the cube."
    lap(trial)
    (made,) = trial.judge.sheet()["repetitions"]
    assert made["metrics"]["time"] == pytest.approx(made["seconds"] + 10.0)
    assert made["metrics"]["contacts"] == 2


def test_the_time_of_a_repetition_and_of_the_trial_end():
    trial = ready()
    trial.drive(1.0)
    trial.seconds(61.0)
    assert trial.judge.state()["results"] == ["time"]
    trial = ready(DRILL.replace("trial_time: 600", "trial_time: 20"))
    trial.drive(1.0)
    trial.seconds(21.0)
    sheet = trial.judge.sheet()
    assert (sheet["ended"], sheet["verdict"]) == ("time", "failed")
    assert sheet["repetitions"] == []


def test_again_while_it_runs_is_a_repetition_given_up():
    trial = ready()
    trial.again()
    trial.drive(1.0)
    trial.robot = ((0.0, 0.0, 0.1), LEVEL)
    trial.again()
    assert trial.judge.state()["results"] == ["given up"]
    assert trial.judge.phase == "waiting"


def test_an_input_at_the_wrong_time_is_refused_and_said():
    trial = Trial(exercise(DRILL))
    trial.input("ready")
    assert trial.judge.phase == "idle"
    assert trial.judge.state()["message"] == "ready: not now, the trial is idle"
    trial.begin()
    trial.input("open", trial="t2", operator="bob", mode="exam")
    assert trial.judge.state()["operator"] == "ann"
    assert trial.judge.state()["valid"]


def test_hints_are_for_practice():
    for mode, wanted in (("practice", "Now back."), ("exam", "")):
        trial = ready(mode=mode)
        trial.drive(2.0)
        assert trial.judge.state()["hint"] == ""
        trial.drive(3.0)
        assert trial.judge.state()["hint"] == wanted


def test_answers_that_were_drawn_count_for_the_next_repetition():
    ask = "questions: [{name: ring, ask: Where?, of: wall}]\nmetrics: {answers: {pass: 1}}\n"
    base = DRILL.split("metrics:")[0] + ask
    trial = Trial(exercise(base))
    trial.names()
    trial.sample()
    trial.input("open", trial="t", operator="ann", mode="practice")
    trial.input("start")
    shares = []
    for right, said in (("up", "UP"), ("left", "up")):
        trial.input("drawn", answers={"ring": right})
        trial.input("ready")
        trial.sample()
        trial.drive(1.0)
        assert not trial.judge.state()["questions"][0]["answered"]
        trial.input("answer", question="ring", answer=said)
        # A second thought does not count.
        trial.input("answer", question="ring", answer=right)
        assert trial.judge.state()["questions"][0]["answered"]
        lap(trial)
        shares.append(trial.judge.sheet()["repetitions"][-1]["metrics"]["answers"])
        trial.input("again")
    assert shares == [1.0, 0.0]
    for event in trial.events:
        if event.event == "answer":
            assert "right" not in event.detail


def test_nothing_compensates_for_a_metric_beyond_its_bound():
    trial = ready()
    for contacts in (0, 2):
        trial.drive(1.0)
        for _ in range(contacts):
            trial.contacts = [("arm", "wall", 5.0)]
            trial.sample()
            trial.contacts = []
            trial.seconds(0.6)
        lap(trial)
        trial.again()
    trial.input("abort", reason="ended", by="ann")
    sheet = trial.judge.sheet()
    assert sheet["verdict"] == "failed"
    metrics = {metric["name"]: metric for metric in sheet["metrics"]}
    assert metrics["time"]["within"] is True
    assert (metrics["contacts"]["value"], metrics["contacts"]["within"]) == (2.0, False)
    assert [made["passed"] for made in sheet["repetitions"]] == [True, False]


def test_a_metric_that_nothing_told_is_no_pass():
    text = DRILL.replace("metrics:", "metrics:\n  picture_age: {pass: 1}")
    trial = ready(text)
    lap(trial)
    trial.again()
    lap(trial)
    trial.input("abort", reason="ended")
    assert trial.judge.sheet()["verdict"] == "failed"


def test_the_figures_of_the_whole_trial():
    trial = ready()
    for _ in range(3):
        lap(trial)
        trial.again()
    sheet = trial.judge.sheet()
    times = [made["metrics"]["time"] for made in sheet["repetitions"]]
    assert sheet["summary"]["rate"] == pytest.approx(180.0 / sum(times), abs=1e-3)
    assert sheet["summary"]["proficiency"] == pytest.approx(30.0 / sum(times), abs=1e-3)
    assert sheet["summary"]["reliability"] == pytest.approx(0.2 ** (1 / 3), abs=1e-4)
    assert sheet["expert"]["provisional"] is True


def test_an_abort_has_no_verdict_below_what_is_asked_and_never_in_an_exam():
    for mode, laps, verdict in (
        ("practice", 1, ""),
        ("practice", 2, "passed"),
        ("exam", 2, ""),
    ):
        trial = ready(mode=mode)
        for _ in range(laps):
            lap(trial)
            trial.again()
        trial.input("abort", by="ann", reason="gave up")
        assert trial.judge.phase == "ended"
        assert trial.judge.sheet()["verdict"] == verdict


def test_who_gives_up_has_given_up_the_repetition_that_runs():
    trial = ready(DRILL.replace("faults: {pass: 1}", "faults: {pass: 0}"))
    for _ in range(2):
        lap(trial)
        trial.again()
    trial.drive(1.0)
    trial.input("abort", reason="aborted", by="", given_up=True)
    sheet = trial.judge.sheet()
    assert [made["fault"] for made in sheet["repetitions"]] == [None, None, "given up"]
    assert (sheet["ended"], sheet["verdict"]) == ("aborted", "failed")
    assert sheet["summary"]["faults"] == 1
    assert [each["event"] for each in sheet["events"]][-3:] == ["fault", "repetition", "end"]
    assert folded(trial).text() == trial.judge.text()


@pytest.mark.parametrize("by", [{}, {"by": "instructor"}, {"given_up": False}, {"given_up": "yes"}])
def test_an_abort_that_is_not_the_operators_leaves_the_repetition_out(by):
    trial = ready()
    trial.drive(1.0)
    trial.input("abort", reason="aborted", **by)
    sheet = trial.judge.sheet()
    assert (sheet["ended"], sheet["repetitions"]) == ("aborted", [])
    assert trial.kinds()[-1] == "end"
    assert trial.judge.state()["elapsed"] > 0.0


def test_a_repetition_that_waits_or_has_ended_cannot_be_given_up():
    trial = ready()
    trial.input("abort", given_up=True)
    assert trial.judge.sheet()["repetitions"] == []
    trial = ready()
    lap(trial)
    trial.input("abort", given_up=True)
    assert [made["completed"] for made in trial.judge.sheet()["repetitions"]] == [True]


def test_an_instructors_mark_stands_beside_the_verdict():
    trial = ready()
    lap(trial)
    trial.again()
    lap(trial)
    trial.again()
    lap(trial)
    before = trial.judge.sheet()["verdict"]
    trial.input("mark", verdict="failed", by="eve", reason="drove too fast")
    trial.input("note", text="see 0:12", by="eve")
    sheet = trial.judge.sheet()
    assert sheet["verdict"] == before == "passed"
    assert sheet["marks"][0]["reason"] == "drove too fast"
    assert sheet["notes"][0]["text"] == "see 0:12"


def test_a_rating_of_the_workload_leaves_the_sheet_as_it_is():
    trial = ready()
    lap(trial)
    trial.input("tlx", values=[10, 20, 30, 40, 50, 60])
    assert trial.judge.workload is None  # the trial goes on
    trial.input("abort")
    shown = trial.judge.text()
    trial.input("tlx", values=[1, 2, 3])
    trial.input("tlx", values=[0, 0, 0, 0, 0, 101])
    assert trial.judge.workload is None
    trial.input("tlx", values=[10, 20, 30, 40, 50, 60])
    assert trial.judge.workload == {"ratings": [10, 20, 30, 40, 50, 60], "raw": 35.0}
    assert trial.judge.text() == shown
    trial.input("note", text="after it", by="eve")
    assert trial.judge.sheet()["notes"][0]["text"] == "after it"
    assert folded(trial).text() == trial.judge.text()
    assert folded(trial).workload == trial.judge.workload


def test_a_note_at_a_moment_leaves_the_sheet_as_it_is():
    trial = ready()
    lap(trial)
    note = {"at": 1.5, "text": "too close", "by": "eve", "instructor": True}
    before = trial.judge.text()
    trial.input("moment", **note)
    assert trial.judge.text() == before
    trial.input("abort")
    shown = trial.judge.text()
    trial.input("moment", **note)
    assert trial.judge.text() == shown
    assert folded(trial).text() == shown
    assert moment_notes(trial.entries) == [MomentNote(1.5, "too close", "eve", True)] * 2


def test_a_note_at_a_moment_hides_no_gap():
    trial = ready(mode="exam")
    trial.input("moment", at=1.0, text="here")
    bent = [*trial.entries[:-1], trial.entries[-1]._replace(number=999)]
    assert not folded(trial, bent).sheet()["valid"]
    assert folded(trial).sheet()["valid"]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"at": float("nan")}, "at"),
        ({"at": -1.0}, "0 s or later"),
        ({"at": "1"}, "a number"),
        ({"text": " "}, "one line of text"),
        ({"text": "a\nb"}, "one line of text"),
        ({"text": "x" * 501}, "at most 500"),
        ({"text": 7}, "a text"),
        ({"by": "x" * 101}, "at most 100"),
        ({"by": "a\x1b[2J"}, "a name"),
        ({"instructor": "yes"}, "true or false"),
    ],
)
def test_a_note_that_makes_no_sense_is_refused(change, why):
    with pytest.raises(BadEntryError, match=why):
        moment_note({"at": 1.0, "text": "here", "by": "ann", **change})


def test_a_lost_sample_is_a_gap():
    trial = ready(mode="exam")
    trial.drive(1.0)
    trial.message()
    trial.sample()
    assert trial.judge.sheet()["log"]["gaps"] == 1
    assert trial.judge.state()["invalid_because"] == ["samples of the truth are missing"]
    for _ in range(3):
        lap(trial)
        trial.again()
    assert trial.judge.sheet()["verdict"] == ""


def test_a_lost_entry_is_said():
    trial = ready()
    lap(trial)
    judge = folded(trial, trial.entries[:50] + trial.entries[51:])
    assert "entries of the recording are missing" in judge.state()["invalid_because"]


def test_an_object_that_is_put_elsewhere_is_interference():
    """Deleted and spawned in one pause, it has the same names, of another revision."""
    trial = ready()
    trial.drive(1.0)
    trial.names()  # told once more
    assert trial.judge.state()["valid"]
    trial.revision += 1
    trial.names()
    trial.sample()
    (reason,) = trial.judge.state()["invalid_because"]
    assert reason == "objects were moved, or robots came or went, from outside"


@pytest.mark.parametrize(
    ("act", "reason"),
    [
        (lambda t: setattr(t, "resets", 1), "the simulation was reset from outside"),
        (lambda t: setattr(t, "sequence", 0), "the simulator began anew"),
        (lambda t: t.input("outside", what="sim/spawn"), "sim/spawn from outside"),
    ],
)
def test_interference_from_outside_is_said(act, reason):
    trial = ready()
    trial.drive(1.0)
    act(trial)
    trial.sample()
    assert reason in trial.judge.state()["invalid_because"]


@pytest.mark.parametrize("mode", ["practice", "exam"])
def test_what_an_instructor_does_to_the_scene_is_recorded_with_his_name(mode):
    trial = ready(mode=mode)
    trial.drive(1.0)
    place = {"position": {"x": 1.0, "y": -2.5, "z": 0.1}}
    for service, request in (
        ("sim/move", {"name": "cube", "pose": place}),
        ("sim/delete", {"name": "cube"}),
        ("sim/spawn", {"object": "{type: crate}"}),
        ("sim/set_light", {"daylight": 0.25, "lamps": 1}),
        ("sim/move", {"pose": {"position": "?"}}),
        ("sim/else", []),
    ):
        trial.action("Bob", service, json.dumps(request))
    trial.action("Bob", "sim/move", "{")
    said = [note["text"] for note in trial.judge.sheet()["notes"]]
    assert said == [
        "moved 'cube' to 1.00, -2.50, 0.10",
        "took out 'cube'",
        "put in: {type: crate}",
        "set daylight to 25%, lamps to 100%",
        "moved '' elsewhere",
        "sim/else",
        "sim/move",
    ]
    assert {note["by"] for note in trial.judge.sheet()["notes"]} == {"Bob"}
    wanted = [] if mode == "practice" else ["Bob has changed the scene"]
    assert trial.judge.state()["invalid_because"] == wanted


@pytest.mark.parametrize("mode", ["practice", "exam"])
def test_another_light_counts_whoever_has_set_it(mode):
    """Through the page of a robot that is not the exam's, it is no action that is recorded."""
    trial = ready(mode=mode)
    trial.light(1.0, 0.5)
    trial.light(1.0, 0.5)
    assert trial.judge.state()["invalid_because"] == []  # how it was
    trial.drive(1.0)
    trial.light(0.0, 0.5)
    wanted = [] if mode == "practice" else ["the light was changed from outside"]
    assert trial.judge.state()["invalid_because"] == wanted


@pytest.mark.parametrize("mode", ["practice", "exam"])
def test_the_sheet_says_what_the_line_was(mode):
    trial = ready(mode=mode)
    trial.link("perfect", 1.0)
    assert "link" not in trial.judge.sheet()
    trial.drive(1.0)
    trial.link("300", 12.0, delay=0.3)
    trial.link("300", 12.0, delay=0.3, outage=True)
    trial.link("300", 12.0, delay=0.3)
    first, *_ = settings = trial.judge.sheet()["link"]
    assert (len(settings), first["profile"], first["delay"]) == (1, "300", 0.3)
    told = [
        (event.event, event.name) for event in trial.events if event.event in ("link", "outage")
    ]
    assert told == [("link", "300"), ("outage", ""), ("outage", "")]
    # The line is the instructor's to change, but for the exam's.
    wanted = [] if mode == "practice" else ["the line was changed from outside"]
    assert trial.judge.state()["invalid_because"] == wanted
    assert folded(trial).text() == trial.judge.text()


def test_what_the_judge_itself_puts_back_is_not_from_outside():
    trial = ready()
    lap(trial)
    trial.input("again")
    trial.input("ready", resets=1)
    # On its way before the reset; it must not begin the repetition.
    trial.robot = ((2.0, 0.0, 0.1), LEVEL)
    trial.sample(3)
    assert trial.judge.phase == "waiting"
    trial.resets, trial.robot = 1, ((0.0, 0.0, 0.1), LEVEL)
    trial.sample(3)
    assert trial.judge.phase == "waiting"
    assert trial.judge.state()["valid"]
    lap(trial)
    assert trial.judge.state()["results"] == ["passed", "passed"]


def test_pauses_do_not_count_but_are_events():
    trial = ready(mode="exam")
    trial.drive(1.0)
    before = trial.judge.state()["elapsed"]
    trial.input("pause", on=True, by="eve")
    trial.status(paused=True)
    trial.wall += 100.0
    trial.status(paused=False)
    trial.sample()
    assert trial.judge.state()["elapsed"] == pytest.approx(before + 0.02)
    for _ in range(3):
        lap(trial)
        trial.again()
    sheet = trial.judge.sheet()
    assert sheet["real_time_factor"]["slow_share"] == 0.0
    assert sheet["verdict"] == "passed"
    assert [event["event"] for event in sheet["events"]].count("pause") == 3


@pytest.mark.parametrize(("mode", "verdict"), [("practice", "passed"), ("exam", "")])
def test_a_slow_simulation_is_said_and_spoils_an_exam(mode, verdict):
    trial = ready(mode=mode)
    trial.drive(1.0)
    trial.pace = 0.5
    trial.seconds(2.0)
    trial.pace = 1.0
    for _ in range(3):
        lap(trial)
        trial.again()
    sheet = trial.judge.sheet()
    factor = sheet["real_time_factor"]
    assert factor["worst"] == pytest.approx(0.5, abs=0.02)
    ((begin, end),) = factor["slow"]
    # Means over a second: at each end, up to 0.2 s of what is beside it counts too.
    assert end - begin == pytest.approx(2.2, abs=0.2)
    assert sheet["verdict"] == verdict
    assert "slow" in trial.kinds()


def test_a_simulation_that_stands_is_slow_for_as_long():
    trial = ready()
    trial.drive(1.0)
    trial.seconds(2.0)
    trial.wall += 5.0
    trial.seconds(5.0)
    sheet = trial.judge.sheet()
    wall = trial.time - 10.0 + 5.0
    assert sheet["real_time_factor"]["worst"] == pytest.approx(0.0, abs=0.02)
    assert sheet["real_time_factor"]["slow_share"] * wall == pytest.approx(5.4, abs=0.4)


def test_what_is_put_back_may_take_its_time():
    trial = ready(mode="exam")
    for _ in range(3):
        lap(trial)
        trial.input("again")
        trial.wall += 10.0
        trial.input("ready")
        trial.seconds(1.5)
    assert trial.judge.sheet()["real_time_factor"]["slow_share"] == 0.0
    assert trial.judge.sheet()["verdict"] == "passed"


def test_a_short_slow_stretch_is_none():
    trial = ready(mode="exam")
    trial.drive(1.0)
    trial.wall += 0.15
    trial.pace = 1.0
    trial.seconds(2.0)
    assert trial.judge.sheet()["real_time_factor"]["slow"] == []


def test_what_the_operator_did_is_counted():
    trial = ready()
    trial.drive(1.0)
    status = JointTeleopStatus(mode="JOINT", active=True)
    for fields in ({}, {"active": False, "message": "e-stop"}, {"mode": "CARTESIAN"}):
        for name, value in fields.items():
            setattr(status, name, value)
        trial.feed("arm_teleop/status", "telex_msgs/JointTeleopStatus", serialized(status))
    for dropped in (3, 5):
        clients = BridgeClients(clients=[BridgeClient(id="c1", dropped_commands=dropped)])
        trial.feed("bridge/clients", "telex_msgs/BridgeClients", serialized(clients))
    for view, age, released in (("mast", 0.1, ""), ("arm", 0.2, "focus lost"), ("arm", 0.6, "")):
        shown = {"view": view, "picture_age": age, "released": released}
        text = json.dumps(shown).encode()
        data = struct.pack("<I", len(text)) + text
        trial.feed("console/telemetry", "std_msgs/String", data)
    trial.status(stuck=True)
    trial.status(e_stop=True)
    trial.seconds(2.0)
    lap(trial)
    (made,) = trial.judge.sheet()["repetitions"]
    wanted = {
        "dead_man": 2,
        "mode_switches": 1,
        "refused": 2,
        "camera_switches": 1,
        "picture_age": 0.2,
        "stuck": 1,
        "e_stops": 1,
    }
    assert {name: made["metrics"][name] for name in wanted} == wanted
    assert made["dead_man"] == {"e-stop": 1, "focus lost": 1}
    # Two seconds without a command, of which the last one before held for 0.3 s; and in the end.
    assert made["metrics"]["idle"] == pytest.approx(1.7, abs=0.1)


def tell(trial, **shown):
    text = json.dumps({"view": "arm", **shown})
    return trial.feed("console/telemetry", "std_msgs/String", serialized(String(text)))


def test_the_sheet_says_which_aids_were_on_and_for_how_long(urdf):
    trial = ready(mode="exam", urdf=urdf)
    tell(trial, aids={"range": False, "proximity": True, "one of my own": False})
    trial.drive(1.0)
    trial.seconds(2.0)
    tell(trial)  # a page that says nothing of aids has changed none
    tell(trial, aids={"range": False})
    for level in (1.0, 0.0):
        trial.feed("lamps/laser_left/level", "std_msgs/Float64", serialized(Float64(level)))
        tell(trial, aids={"range": False})
        trial.seconds(0.5)
    sheet = trial.judge.sheet()
    assert sheet["valid"]
    found = {each["name"]: each for each in sheet["aids"]}
    assert sorted(found) == ["laser dots", "one of my own", "proximity", "range"]
    assert (found["laser dots"]["training"], found["laser dots"]["seconds"]) == (
        False,
        pytest.approx(0.5, abs=0.05),
    )
    assert found["proximity"]["training"] is True
    assert found["proximity"]["text"] == "distances to what is near the arm"
    assert found["one of my own"]["text"] == "one of my own"
    longer = found["range"]["seconds"] - found["proximity"]["seconds"]
    assert longer == pytest.approx(1.0, abs=0.05)
    text = sheet_report(sheet, "t1", [])
    assert "training aid on: distances to what is near the arm," in text
    assert "\n  aid on: range to what the tool points at," in text


def test_a_page_without_aids_leaves_no_word_of_them_and_one_with_none_says_so():
    trial = ready()
    tell(trial)
    trial.drive(1.0)
    assert "aids" not in trial.judge.sheet()
    tell(trial, aids={})
    trial.seconds(1.0)
    assert trial.judge.sheet()["aids"] == []


def test_a_switch_without_lasers_is_no_aid():
    trial = ready()
    trial.feed("lamps/laser_left/level", "std_msgs/Float64", serialized(Float64(1.0)))
    trial.drive(1.0)
    assert "aids" not in trial.judge.sheet()


@pytest.mark.parametrize(
    "aids",
    [
        ["horizon"],
        None,
        {"horizon": 1},
        {"horizon": None},
        {"": True},
        {"HORIZON": True},
        {"a" * 41: True},
        {f"a{i}": True for i in range(41)},
    ],
)
def test_aids_that_cannot_be_are_refused(aids):
    trial = ready()
    (event,) = tell(trial, aids=aids)
    assert event.event == "invalid"
    assert event.name.startswith("console/telemetry: aids")


def test_contacts_forces_and_impulses():
    trial = ready(DRILL.split("faults:")[0] + "metrics: {wall: {kind: peak_force, object: wall}}\n")
    trial.drive(1.0)
    trial.contacts, trial.impulse = [("tracks", "floor", 400.0), ("arm", "wall", 80.0)], 0.5
    trial.seconds(0.6)
    trial.contacts = []
    trial.seconds(0.1)
    trial.contacts, trial.impulse = [("arm", "wall", 20.0)], 1.0
    trial.sample(4)
    trial.contacts = []
    lap(trial)
    (made,) = trial.judge.sheet()["repetitions"]
    metrics = made["metrics"]
    # Apart for less than half a second: the same contact; its impulse begins anew.
    assert metrics["contacts"] == 1
    assert metrics["peak_force"] == metrics["wall"] == 80.0
    assert metrics["impulse"] == pytest.approx(15.0)
    assert metrics["pushing"] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("until", "drops"),
    [
        ("{inside: {what: cube, zone: goal}}", 0),
        ("{not: {inside: {what: cube, zone: goal}}}", 1),
        ("{not: {not: {inside: {what: cube, zone: goal}}}}", 0),
    ],
)
def test_a_fall_where_the_object_is_to_come_from_is_a_drop(urdf, until, drops):
    text = f"""
zones: {{goal: {{center: [2, 0, 0.5], size: [3, 3, 3]}}}}
begin: {{elapsed: 0}}
steps: [{{name: go, until: {{all: [{until}, {{event: {{name: stuck}}}}]}}}}]
metrics: {{drops: {{}}}}
"""
    trial = ready(text.replace("begin: {elapsed: 0}", "begin: {not: {held: {object: wall}}}"))
    trial.held = "cube"
    trial.seconds(0.2)
    trial.held = None
    for height in (0.5, 0.4, 0.2, 0.05):
        trial.bodies["cube/cube"] = ((2.0, 0.0, height), LEVEL)
        trial.sample()
    trial.input("again")
    (made,) = trial.judge.sheet()["repetitions"]
    assert made["metrics"]["drops"] == drops


def test_drops_slip_and_the_tool(urdf):
    text = DRILL.split("faults:")[0] + "metrics: {drops: {pass: 0}, sparc: {}, slip: {}}\n"
    trial = Trial(exercise(text), urdf=urdf, scene=SCENE).begin()
    trial.drive(1.0)
    for i in range(100):
        trial.joints[0] = 0.005 * i
        trial.sample()
    trial.held = "cube"
    trial.bodies["cube/cube"] = ((2.0, 0.0, 0.5), LEVEL)
    trial.sample(10)
    trial.bodies["cube/cube"] = ((2.0, 0.01, 0.5), LEVEL)
    trial.sample(5)
    trial.held = None
    trial.sample()
    trial.bodies["cube/cube"] = ((2.0, 0.0, 0.4), LEVEL)
    trial.sample()
    assert "drop" in trial.kinds()
    lap(trial)
    metrics = trial.judge.sheet()["repetitions"][0]["metrics"]
    assert metrics["drops"] == 1
    assert metrics["slip"] == pytest.approx(0.01, abs=1e-4)
    assert -5.0 < metrics["sparc"] < -1.3
    assert metrics["tool_path"] > 5.0


def test_the_margin_and_a_tip():
    trial = ready()
    trial.drive(1.0)
    trial.margin = 0.3
    trial.seconds(1.0)
    trial.margin = 0.9
    turn = (0.65, 0.0, 0.0, 0.7599342)
    trial.robot = (trial.robot[0], turn)
    trial.seconds(0.6)
    trial.robot = (trial.robot[0], LEVEL)
    lap(trial)
    metrics = trial.judge.sheet()["repetitions"][0]["metrics"]
    assert metrics["margin"] == pytest.approx(0.3)
    assert metrics["caution"] == pytest.approx(1.0)
    assert metrics["tips"] == 1
    assert "tipped" in trial.kinds()


def test_move_and_wait():
    trial = ready()
    trial.drive(1.0)
    for x in (1.2, 1.4, 1.6):
        trial.drive(x, 0.2)
        trial.seconds(1.0)
    lap(trial)
    metrics = trial.judge.sheet()["repetitions"][0]["metrics"]
    assert 0.5 <= metrics["move_and_wait"] <= 1.0


def test_the_same_entries_make_the_same_sheet(urdf):
    trial = Trial(exercise(DRILL), urdf=urdf).begin()
    numbers = random.Random(3)
    for _ in range(3):
        trial.joints = [numbers.uniform(-0.5, 0.5) for _ in trial.joints]
        lap(trial)
        trial.again()
    live = trial.judge.text()
    again = Judge(exercise(DRILL), "", urdf)
    for entry in trial.entries:
        message = entry
        if entry.kind == "telex_msgs/TruthSample":
            decoded = TruthSample()
            decoded.deserialize(entry.data)
            message = entry._replace(data=serialized(decoded))
        again.feed(message)
    assert again.text() == live
    assert list(json.loads(live)) == sorted(json.loads(live))
    # What comes behind the end changes nothing.
    trial.sample(20)
    assert trial.judge.text() == live
    other = list(trial.entries)
    other[20] = other[20]._replace(data=other[20].data[:-1] + b"\x01")
    assert folded(trial, other).sheet()["log"]["sha256"] != json.loads(live)["log"]["sha256"]


def test_a_sample_is_decoded_as_genpy_does():
    trial = Trial(exercise(DRILL))
    trial.contacts, trial.held = [("arm", "wall", 3.5)], "plug"
    message = trial.message()
    made = read_sample(serialized(message))
    assert made.sequence == message.sequence
    assert made.base[0] == pytest.approx(message.base[:3])
    assert made.base[1] == pytest.approx(message.base[3:])
    assert made.joints == pytest.approx(message.joints)
    assert made.held == message.held
    assert made.contacts[0].peak == pytest.approx(3.5)
    assert made.contacts[0].object == 1
    assert [index for index, _ in made.moved] == [0, 1, 2]
    assert made.moved[1][1][0] == pytest.approx((0.0, 4.0, 0.0))
    assert made.time == pytest.approx(message.header.stamp.to_sec())


@pytest.mark.parametrize(
    "change",
    [
        lambda message: setattr(message, "margin", float("nan")),
        lambda message: setattr(message, "base", [0.0] * 7),
        lambda message: setattr(message, "joints", [0.0]),
        lambda message: setattr(message, "held", 99),
        lambda message: setattr(message, "moved", [99, 1, 2]),
        lambda message: setattr(message, "poses", [0.0]),
        lambda message: setattr(message.contacts[0], "group", 99),
        lambda message: setattr(message.contacts[0], "object", 99),
    ],
)
def test_a_bad_sample_is_an_event_with_a_reason(change):
    trial = ready()
    trial.contacts = [("arm", "wall", 1.0)]
    message = trial.message()
    change(message)
    (event,) = trial.feed("sim/truth", "telex_msgs/TruthSample", serialized(message))
    assert event.event == "invalid"
    assert event.name.startswith("sim/truth: ")
    assert not trial.judge.state()["valid"]


CHANNELS = st.sampled_from(
    [
        ("sim/truth", "telex_msgs/TruthSample"),
        ("sim/truth_names", "telex_msgs/TruthNames"),
        ("sim/status", "telex_msgs/SimStatus"),
        ("bridge/clients", "telex_msgs/BridgeClients"),
        ("console/telemetry", "std_msgs/String"),
        ("track_teleop/cmd_vel", "geometry_msgs/Twist"),
        ("arm_teleop/delta_joint_cmds", "control_msgs/JointJog"),
        ("arm_teleop/status", "telex_msgs/JointTeleopStatus"),
        ("training/inputs", "std_msgs/String"),
        ("training/inputs", "telex_msgs/Nothing"),
        ("somewhere/else", "std_msgs/String"),
    ]
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=7),
    max_leaves=7,
)
INPUT = st.dictionaries(
    st.sampled_from(["input", "question", "answer", "answers", "values", "mode", "seed", "resets"]),
    JSON
    | st.sampled_from(
        ["open", "start", "ready", "again", "answer", "drawn", "abort", "tlx", "note", "moment"]
    ),
)


def as_string(text):
    data = text.encode()
    return struct.pack("<I", len(data)) + data


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(CHANNELS, st.binary(max_size=300))
        | st.tuples(
            st.just(("training/inputs", "std_msgs/String")), INPUT.map(json.dumps).map(as_string)
        ),
        max_size=12,
    ),
    st.integers(0, 60),
    st.integers(0, 200),
)
def test_no_entry_makes_the_judge_raise(fuzz, place, cut):
    trial = ready()
    trial.drive(0.8)
    entries = list(trial.entries)
    sample = entries[-1]
    fuzzed = [Entry(0, 11.0, channel, kind, data) for (channel, kind), data in fuzz]
    fuzzed.append(sample._replace(data=sample.data[:cut]))
    judge = folded(trial, [*entries[:place], *fuzzed, *entries[place:]])
    judge.state()
    json.loads(judge.text())
