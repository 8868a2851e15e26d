"""Bookmarks in a trial: what goes on from one is practice, and is judged the same each time."""

from __future__ import annotations

import json

import pytest
from training_truth import LEVEL, Trial, exercise

from telex_training.judging.judge import Judge

DRILL = """
title: Drill
zones:
  start: {center: [0, 0, 0], size: [1, 2, 1]}
  goal: {center: [3, 0, 0], size: [1, 2, 1]}
begin: {not: {inside: {what: robot, zone: start}}}
steps:
  - {name: there, until: {inside: {what: robot, zone: goal}}}
  - {name: far, until: {moved: {what: robot, distance: 4}}}
  - {name: back, until: {inside: {what: robot, zone: start}, for: 0.2}}
repetitions: {most: 2, least: 1, time: 30}
penalties: [{name: cube touched, when: {touches: {object: cube}}, seconds: 5}]
questions: [{name: colour, ask: Which?, answer: red}]
metrics:
  time: {pass: 30, expert: [10, 1]}
  contacts: {pass: 1}
"""
THERE = "there, repetition 1"


def ready(mode="practice"):
    return Trial(exercise(DRILL)).begin(mode)


def to_goal(trial):
    """Drive to the first step, and set its bookmark."""
    trial.drive(3.0, 1.0)
    return trial.input("bookmark", name=THERE)


def home(trial):
    trial.drive(4.5, 1.0)
    trial.drive(0.0, 1.0)
    trial.seconds(0.4)


def back(trial, name=THERE, x=3.0):
    """Go back as the training node does; the simulation is where the bookmark was set."""
    trial.input("back", bookmark=name)
    trial.resets += 1
    trial.robot = ((x, 0.0, 0.112), LEVEL)
    trial.sample()
    trial.input("ready", resets=trial.resets, bookmark=name)
    trial.sample()


def anew(trial):
    """Begin the next repetition as the training node does."""
    trial.input("again")
    trial.resets += 1
    trial.robot = ((0.0, 0.0, 0.112), LEVEL)
    trial.input("ready", resets=trial.resets)
    trial.sample()


def test_what_goes_on_from_a_bookmark_cannot_be_given_up():
    trial = ready()
    to_goal(trial)
    back(trial)
    trial.input("abort", given_up=True)
    sheet = trial.judge.sheet()
    assert [made["fault"] for made in sheet["repetitions"]] == ["went back"]
    assert "practised" not in sheet


def test_going_back_ends_the_repetition_uncredited_and_is_no_interference():
    trial = ready()
    to_goal(trial)
    before = trial.judge.state()["elapsed"]
    trial.drive(4.2, 1.0)
    back(trial)
    state = trial.judge.state()
    assert state["valid"]
    assert state["results"] == ["went back"]
    assert state["phase"] == "running"  # its begin was long before the bookmark
    assert state["steps_done"] == [True, False, False]
    assert state["from_bookmark"] == THERE
    assert state["repetition"] == 1
    assert state["elapsed"] == pytest.approx(before, abs=0.05)
    trial.seconds(1.0)
    assert trial.judge.state()["elapsed"] == pytest.approx(before + 1.0, abs=0.05)


def test_what_goes_on_from_a_bookmark_is_practice_only_and_the_sheet_says_so():
    trial = ready()
    to_goal(trial)
    back(trial)
    home(trial)
    assert trial.judge.phase == "between"
    sheet = trial.judge.sheet()
    (practised,) = sheet["practised"]
    assert (practised["bookmark"], practised["repetition"]) == (THERE, 1)
    assert practised["completed"]
    assert practised["steps"][0] < practised["steps"][1] < practised["steps"][2]
    # The one that was left counts as tried.
    assert [each["fault"] for each in sheet["repetitions"]] == ["went back"]
    assert sheet["summary"]["completed"] == 0
    assert sheet["summary"]["rate"] is None
    assert sheet["summary"]["faults"] == 1
    anew(trial)
    state = trial.judge.state()
    assert (state["repetition"], state["from_bookmark"], state["elapsed"]) == (2, "", 0.0)
    assert state["steps_done"] == [False] * 3
    trial.drive(3.0, 1.0)
    home(trial)
    summary = trial.judge.sheet()["summary"]
    assert (summary["completed"], summary["faults"]) == (1, 1)
    assert trial.judge.phase == "ended"


def test_distances_answers_and_penalties_are_those_of_the_bookmark():
    trial = ready()
    trial.drive(1.0, 1.0)
    trial.contacts = [("base", "cube", 10.0)]
    trial.sample()
    trial.contacts = []
    trial.input("answer", question="colour", answer="Red")
    to_goal(trial)
    trial.contacts = [("base", "cube", 10.0)]
    trial.seconds(1.0)
    trial.contacts = []
    trial.seconds(1.0)
    back(trial)
    state = trial.judge.state()
    assert state["penalty"] == 5.0
    assert state["faults"] == ["cube touched"]
    assert state["questions"][0]["answered"]
    # 4 m from where the repetition began, not from the bookmark.
    trial.drive(3.8, 1.0)
    assert trial.judge.state()["steps_done"] == [True, False, False]
    trial.drive(4.1, 1.0)
    assert trial.judge.state()["steps_done"] == [True, True, False]


def test_its_time_has_no_limit():
    trial = ready()
    to_goal(trial)
    trial.seconds(31.0)
    assert trial.judge.state()["results"] == ["time"]
    back(trial)
    trial.seconds(31.0)
    assert trial.judge.phase == "running"


def test_the_last_repetition_may_be_left_as_often_as_one_likes():
    trial = ready()
    to_goal(trial)
    for _ in range(3):
        back(trial)
    anew(trial)
    to_goal(trial)
    back(trial)
    assert trial.judge.state()["results"] == ["went back", "went back"]
    assert trial.judge.phase == "running"
    back(trial)
    left = [each["fault"] for each in trial.judge.sheet()["practised"]]
    assert left == ["went back", "went back", "given up", "went back"]
    trial.input("again")
    assert trial.judge.sheet()["ended"] == "complete"


def test_one_of_before_the_begin_waits_for_it():
    trial = ready()
    trial.input("bookmark", name="mark 1")
    trial.drive(2.0, 1.0)
    back(trial, "mark 1", x=0.0)
    assert trial.judge.phase == "waiting"
    trial.drive(1.0, 1.0)
    assert trial.judge.phase == "running"
    assert trial.judge.state()["elapsed"] < 1.0
    assert trial.judge.state()["from_bookmark"] == "mark 1"


def test_a_bookmark_that_the_judge_does_not_know_is_no_start_either():
    trial = ready()
    trial.drive(3.0, 1.0)
    back(trial, "unknown")
    trial.drive(7.2, 2.0)
    trial.drive(0.0, 2.0)
    trial.seconds(0.4)
    sheet = trial.judge.sheet()
    assert [each["bookmark"] for each in sheet["practised"]] == ["unknown"]
    assert sheet["valid"]


def test_one_that_has_ended_is_said_and_all_begins_anew():
    trial = ready()
    to_goal(trial)
    trial.input("back", bookmark=THERE)
    trial.robot = ((0.0, 0.0, 0.112), LEVEL)
    trial.input("ready", missed="bookmark 'x' has ended; all is put to the start")
    trial.sample()
    state = trial.judge.state()
    assert "has ended" in state["message"]
    assert (state["phase"], state["from_bookmark"], state["repetition"]) == ("waiting", "", 2)


def test_exams_have_none():
    trial = ready("exam")
    events = to_goal(trial)
    assert [(event.event, event.name) for event in events] == [("refused", "bookmark")]
    (refused,) = trial.input("back", bookmark=THERE)
    assert (refused.event, refused.name) == ("refused", "back")
    assert trial.judge.phase == "running"
    assert "an exam has no bookmarks" in trial.judge.state()["message"]


@pytest.mark.parametrize("mode", ["practice", "exam"])
def test_going_back_from_outside_ends_the_repetition_and_makes_the_trial_invalid(mode):
    trial = ready(mode)
    trial.drive(2.0, 1.0)
    trial.resets += 1
    trial.robot = ((0.7, 0.0, 0.112), LEVEL)
    trial.sample()
    state = trial.judge.state()
    assert state["phase"] == "between"
    assert state["results"] == ["put back from outside"]
    assert state["invalid_because"] == ["the simulation was reset from outside"]
    anew(trial)
    assert trial.judge.phase == "waiting"


def test_the_same_entries_make_the_same_sheet():
    trial = ready()
    to_goal(trial)
    back(trial)
    home(trial)
    trial.input("abort", reason="aborted")
    again = Judge(trial.judge.exercise)
    for entry in trial.entries:
        again.feed(entry)
    assert again.text() == trial.judge.text()
    assert json.loads(again.text())["practised"]


def test_sheets_of_trials_without_bookmarks_stay_as_they_were():
    trial = ready()
    home(trial)
    assert "practised" not in trial.judge.sheet()


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        ("bookmark", {"name": 3}),
        ("bookmark", {"name": "x" * 3000}),
        ("back", {"bookmark": [1]}),
        ("ready", {"bookmark": {}}),
        ("ready", {"missed": 1.5}),
    ],
)
def test_what_is_no_name_is_said_and_changes_nothing(kind, content):
    trial = ready()
    trial.drive(2.0, 1.0)
    phase = trial.judge.phase
    events = trial.input(kind, **content)
    assert [event.event for event in events] == ["invalid"]
    assert trial.judge.phase == phase
