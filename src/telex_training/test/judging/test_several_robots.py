"""The judge of several robots: conditions, metrics and events of each, and who is not heard."""

from __future__ import annotations

import json

import genpy
import pytest
from std_msgs.msg import Bool, Float64, String
from telex_msgs.msg import ActiveMalfunction, ComponentDoses, InstructorAction, Malfunctions
from training_truth import PERIOD, Trial, exercise, serialized

from telex_training.command_lines.score import sheet_report
from telex_training.judging.judge import Judge

PAIR = """
title: Pair
robots: [{name: second, x: 0, y: -1}]
zones: {goal: {center: [3, 0, 0], size: [1, 4, 1]}}
begin: {event: {name: command}}
steps:
  - name: both there
    until:
      all:
        - {inside: {what: robot, zone: goal}}
        - {inside: {what: robot, zone: goal}, robot: second}
faults: [{name: second went off, when: {moved: {what: robot, distance: 5}, robot: second}}]
metrics:
  base_path: {}
  second_path: {kind: base_path, robot: second, pass: 3.5}
  second_contacts: {kind: contacts, robot: second, pass: 0}
repetitions: {most: 2, least: 1}
"""

LASERS = '<robot name="r"><link name="left_laser_link"/></robot>'


class PairTrial(Trial):
    """Feeds the judge with the truth of two robots; `other` is what the second one's says."""

    def __init__(self, of, **options):
        super().__init__(of, **options)
        self.other = Trial(of)
        self.heard = True

    def names(self):
        super().names()
        entry = self.entries[-1]
        self.feed(f"second/{entry.channel}", entry.kind, entry.data)

    def sample(self, count=1):
        found = []
        for _ in range(count):
            found += super().sample()
            self.other.time, self.other.resets = self.time - PERIOD, self.resets
            data = serialized(self.other.message())
            if self.heard:
                found += self.feed("second/sim/truth", "telex_msgs/TruthSample", data)
        return found

    def second_at(self, x, y=-1.0):
        self.other.robot = ((x, y, 0.112), self.other.robot[1])
        return self.sample()


@pytest.fixture
def trial():
    made = PairTrial(exercise(PAIR))
    made.second_at(0.0)
    return made.begin()


def finish(trial):
    trial.command(0.3)
    trial.at(3.0)
    trial.second_at(3.0)
    trial.sample()
    return trial.judge.sheet()


def test_both_have_to_be_there_and_each_has_its_own_figures(trial):
    trial.command(0.3)
    trial.at(3.0)
    trial.seconds(0.1)
    assert trial.judge.phase == "running"
    sheet = finish(trial)
    (repetition,) = sheet["repetitions"]
    assert repetition["completed"]
    assert repetition["metrics"]["second_path"] == pytest.approx(3.0, abs=0.1)
    assert repetition["robots"]["second"]["metrics"]["base_path"] == pytest.approx(3.0, abs=0.1)
    assert sheet["valid"]


def test_the_sheet_is_the_same_from_the_entries(trial):
    finish(trial)
    again = Judge(trial.judge.exercise)
    for entry in trial.entries:
        again.feed(entry)
    assert again.text() == trial.judge.text()


def test_what_the_second_robot_commands_begins_it_and_what_it_touches_is_its_own(trial):
    trial.command(0.3)
    command = trial.entries[-1]
    fresh = PairTrial(exercise(PAIR))
    fresh.begin()
    fresh.feed("second/track_teleop/cmd_vel", command.kind, command.data)
    fresh.sample()
    assert fresh.judge.phase == "running"
    fresh.other.contacts = [("arm", "wall", 50.0)]
    events = fresh.sample()
    assert [(event.event, event.detail["robot"]) for event in events] == [("contact", "second")]
    fresh.other.contacts = []
    metrics = finish(fresh)["repetitions"][0]["metrics"]
    assert (metrics["contacts"], metrics["second_contacts"]) == (0.0, 1.0)


def test_the_sheet_says_which_aids_each_operator_had(trial):
    told = serialized(String(json.dumps({"view": "front", "aids": {"range": False}})))
    trial.feed("second/console/telemetry", "std_msgs/String", told)
    trial.seconds(1.0)
    (aid,) = trial.judge.sheet()["aids"]
    assert (aid["robot"], aid["name"], aid["training"]) == ("second", "range", False)
    assert aid["seconds"] == pytest.approx(1.0, abs=0.05)
    assert "aid on: range to what the tool points at, 1.0 s, robot second" in sheet_report(
        trial.judge.sheet(), "t1", []
    )
    lit = serialized(Float64(1.0))
    trial.feed("second/lamps/laser_left/command", "std_msgs/Float64", lit)
    trial.feed("console/telemetry", "std_msgs/String", told)
    trial.seconds(0.5)
    found = [(aid.get("robot"), aid["name"]) for aid in trial.judge.sheet()["aids"]]
    assert found == [(None, "range"), ("second", "range")]  # without lasers a switch is no aid
    armed = PairTrial(exercise(PAIR))
    armed.judge = Judge(armed.judge.exercise, urdfs={"second": LASERS})
    armed.begin()
    armed.feed("second/lamps/laser_left/command", "std_msgs/Float64", lit)
    armed.seconds(0.5)
    assert [aid["name"] for aid in armed.judge.sheet()["aids"]] == ["laser dots"]


def test_what_is_done_through_the_second_robots_bridge_counts_in_an_exam():
    made = PairTrial(exercise(PAIR))
    made.second_at(0.0)
    exam = made.begin("exam")
    acted = InstructorAction(by="Bob", service="sim/delete", request='{"name": "cube"}')
    exam.feed("second/bridge/actions", "telex_msgs/InstructorAction", serialized(acted))
    assert [note["text"] for note in exam.judge.sheet()["notes"]] == ["took out 'cube'"]
    assert exam.judge.state()["invalid_because"] == ["Bob has changed the scene"]


def test_a_fault_of_the_second_robot_goes_by_its_own_start(trial):
    trial.command(0.3)
    trial.sample()
    trial.second_at(0.0, -7.0)
    trial.sample()
    assert trial.judge.sheet()["repetitions"][0]["fault"] == "second went off"


def test_a_repetition_waits_until_the_second_robot_is_heard():
    deaf = PairTrial(exercise(PAIR))
    deaf.heard = False
    deaf.begin()
    deaf.command(0.3)
    deaf.seconds(0.5)
    assert deaf.judge.phase == "waiting"
    assert deaf.judge.state()["message"] == "nothing is heard of the robot 'second'"
    deaf.heard = True
    deaf.sample()
    deaf.command(0.3)
    deaf.seconds(0.1)
    assert deaf.judge.phase == "running"
    assert deaf.judge.state()["message"] == ""


def test_a_trial_whose_second_robot_falls_silent_is_invalid(trial):
    trial.command(0.3)
    trial.sample()
    trial.heard = False
    trial.seconds(0.9)
    assert trial.judge.sheet()["valid"]
    trial.seconds(0.3)
    assert trial.judge.sheet()["invalid_because"] == ["nothing is heard of the robot 'second'"]


def test_lost_samples_of_the_second_robot_are_noticed(trial):
    trial.command(0.3)
    trial.sample()
    trial.other.message()
    trial.sample()
    reasons = trial.judge.sheet()["invalid_because"]
    assert reasons == ["second: samples of the truth are missing"]


HOT = f"""{PAIR}
limits: {{dose: {{robot: 3}}}}
malfunctions:
  - when: {{dose: {{what: robot, above: 1}}, robot: second}}
    what: left_belt
    kind: thrown
    robot: second
""".replace("metrics:", "metrics:\n  dose: {}\n  second_dose: {kind: dose, robot: second, pass: 2}")


class HotTrial(PairTrial):
    """A trial in which robots are exposed, and fail."""

    def exposed(self, robot, dose):
        message = ComponentDoses(names=["robot"], dose=[dose])
        return self.tell(robot, "sim/doses", message)

    def fails(self, robot, announced=False):
        since = genpy.Time.from_sec(self.time)
        active = ActiveMalfunction("left_belt", "belt", "thrown", 0.0, announced, since)
        return self.tell(robot, "sim/malfunctions", Malfunctions(active=[active]))

    def tell(self, robot, channel, message):
        channel = f"{robot}/{channel}" if robot else channel
        return self.feed(channel, message._type, serialized(message))


@pytest.fixture
def hot():
    made = HotTrial(exercise(HOT))
    made.exposed("", 0.0)
    made.exposed("second", 7.0)
    made.begin()
    made.command(0.3)
    made.sample()
    return made


def test_each_robot_has_its_own_dose_and_what_it_lets_fail_is_its_own(hot):
    hot.exposed("", 1.5)
    hot.sample()
    assert hot.judge.take_due() == []
    hot.exposed("second", 8.5)
    hot.sample()
    (due,) = hot.judge.take_due()
    assert (due.robot, due.what) == ("second", "left_belt")
    (repetition,) = finish(hot)["repetitions"]
    metrics = repetition["metrics"]
    assert (metrics["dose"], metrics["second_dose"]) == (1.5, 1.5)
    assert repetition["robots"]["second"]["metrics"]["dose"] == 1.5


@pytest.mark.parametrize("robot", ["", "second"])
def test_a_limit_of_the_dose_holds_for_each_robot(hot, robot):
    hot.exposed(robot, 11.0)
    hot.sample()
    hot.exposed(robot, 15.0)
    hot.sample()
    assert hot.judge.sheet()["repetitions"][0]["fault"] == "dose of robot"


def test_a_malfunction_of_the_second_robot_waits_for_the_reaction_of_its_own_operator(hot):
    (event,) = hot.fails("second", announced=True)
    assert (event.event, event.detail["robot"]) == ("malfunction", "second")
    assert hot.judge.state()["malfunctions"] == ["second: left_belt: the belt is off its wheels"]
    hot.command(-0.3)
    hot.tell("", "e_stop", Bool(True))
    hot.seconds(0.5)
    assert [event.event for event in hot.events].count("reaction") == 0
    hot.tell("second", "e_stop", Bool(True))
    command = next(each for each in hot.entries if each.channel.endswith("cmd_vel"))
    hot.feed("second/track_teleop/cmd_vel", command.kind, command.data)
    (told,) = hot.judge.sheet()["malfunctions"]
    assert (told["robot"], told["what"]) == ("second", "left_belt")
    assert told["e_stop"] == told["command"] == pytest.approx(0.5)
    again = Judge(hot.judge.exercise)
    for entry in hot.entries:
        again.feed(entry)
    assert again.text() == hot.judge.text()


def test_what_fails_of_both_is_told_apart(hot):
    hot.fails("second")
    hot.fails("")
    assert [each.get("robot", "") for each in hot.judge.sheet()["malfunctions"]] == ["", "second"]
