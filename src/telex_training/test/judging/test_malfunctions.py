"""Malfunctions in a trial: when they are due, and how soon the operator reacts."""

from __future__ import annotations

import math

import genpy
import pytest
from control_msgs.msg import JointJog
from std_msgs.msg import Bool
from telex_msgs.msg import ActiveMalfunction, Malfunctions
from training_truth import Trial, exercise, serialized

from telex_training.judging.judge import Judge

DRILL = """
title: Drill
zones:
  start: {center: [0, 0, 0], size: [1, 2, 1]}
  goal: {center: [3, 0, 0], size: [1, 2, 1]}
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: there, until: {inside: {what: robot, zone: goal}}}]
repetitions: {most: 3, trial_time: 600, time: 60}
malfunctions:
  - {when: {all: [{moved: {what: robot, distance: 1.5}}], for: 0.1}, what: left_belt, kind: thrown}
"""


class Breaking(Trial):
    """A trial in which things fail."""

    def fail(self, *names, announced=False, value=0.0, since=None):
        active = [
            ActiveMalfunction(
                what=what,
                group=group,
                kind=kind,
                value=value,
                announced=announced,
                since=genpy.Time.from_sec(self.time if since is None else since),
            )
            for what, group, kind in names
        ]
        message = serialized(Malfunctions(active=active))
        return self.feed("sim/malfunctions", "telex_msgs/Malfunctions", message)

    def e_stop(self, on):
        return self.feed("e_stop", "std_msgs/Bool", serialized(Bool(on)))

    def jog(self, **rates):
        jog = JointJog(joint_names=list(rates), velocities=list(rates.values()))
        return self.feed("arm_teleop/delta_joint_cmds", "control_msgs/JointJog", serialized(jog))

    def hold(self, speed, seconds):
        """Hold a key; returns the events."""
        found = []
        for _ in range(round(seconds / 0.02)):
            found += self.command(speed)
            found += self.sample()
        return found

    @property
    def record(self):
        return self.judge.sheet()["malfunctions"]


BELT, CAMERA = ("left_belt", "belt", "thrown"), ("arm", "camera", "frozen")


@pytest.fixture
def trial():
    return Breaking(exercise(DRILL)).begin()


def reactions(events):
    return [(event.name, event.detail) for event in events if event.event == "reaction"]


def test_it_is_due_once_in_a_repetition_when_its_condition_has_held(trial):
    trial.drive(1.4)
    assert trial.judge.take_due() == []
    trial.at(1.7)
    assert trial.judge.take_due() == []
    trial.seconds(0.2)
    due = trial.judge.take_due()
    assert [(each.what, each.kind) for each in due] == [("left_belt", "thrown")]
    trial.drive(1.0)
    trial.at(1.9)
    trial.seconds(0.2)
    assert trial.judge.take_due() == []
    trial.robot = ((0.0, 0.0, 0.112), trial.robot[1])
    trial.again()
    trial.drive(1.9)
    trial.seconds(0.2)
    assert len(trial.judge.take_due()) == 1


def test_a_key_that_is_held_on_is_no_reaction_and_its_release_is_one(trial):
    trial.hold(0.5, 0.5)
    began = trial.fail(BELT)
    assert [event.event for event in began] == ["malfunction"]
    assert reactions(trial.hold(0.5, 0.6)) == []
    assert reactions(trial.hold(0.45, 0.2)) == []
    ((name, detail),) = reactions(trial.command(0.0))
    assert name == "left_belt thrown"
    assert detail == {"by": "command", "seconds": pytest.approx(0.8)}
    assert reactions(trial.hold(-0.5, 0.2)) == []
    assert trial.record[0]["command"] == pytest.approx(0.8)
    assert trial.record[0]["e_stop"] is None


def test_a_stream_that_falls_silent_is_a_key_that_was_released(trial):
    trial.hold(0.5, 0.5)
    trial.fail(BELT)
    trial.hold(0.5, 0.3)
    ((_, detail),) = reactions(trial.seconds(0.5))
    assert detail["seconds"] == pytest.approx(0.28, abs=0.03)


def test_whoever_rests_reacts_with_his_first_command(trial):
    trial.seconds(1.0)
    trial.fail(CAMERA)
    assert reactions(trial.seconds(1.0)) == []
    ((_, detail),) = reactions(trial.jog(turret_joint=0.2))
    assert detail["seconds"] == pytest.approx(1.0)


def test_another_joint_is_another_command(trial):
    trial.jog(turret_joint=0.2)
    trial.fail(CAMERA)
    trial.sample(5)
    assert reactions(trial.jog(turret_joint=0.2)) == []
    assert len(reactions(trial.jog(elbow_joint=0.2))) == 1


def test_the_first_emergency_stop_counts_beside_the_first_command(trial):
    trial.e_stop(False)
    trial.hold(0.5, 0.2)
    trial.fail(BELT)
    trial.sample(10)
    ((_, detail),) = reactions(trial.e_stop(True))
    assert detail == {"by": "e_stop", "seconds": pytest.approx(0.2)}
    trial.e_stop(False)
    assert reactions(trial.e_stop(True)) == []
    trial.seconds(0.5)
    assert trial.record[0]["e_stop"] == pytest.approx(0.2)
    assert trial.record[0]["command"] is not None


def test_what_works_again_waits_for_no_reaction(trial):
    trial.fail(BELT, CAMERA)
    trial.seconds(0.5)
    ended = trial.fail(CAMERA)
    assert (ended[0].event, ended[0].name) == ("mended", "left_belt thrown")
    found = reactions(trial.command(0.5))
    assert [name for name, _ in found] == ["arm frozen"]
    assert trial.record[0]["ended"] == pytest.approx(trial.time)


def test_one_that_is_told_again_is_still_the_same(trial):
    since = trial.time + 0.01  # as the simulator's clock may be a little ahead
    trial.fail(BELT, since=since)
    trial.seconds(0.5)
    assert [e.name for e in trial.fail(BELT, CAMERA, since=since)] == ["arm frozen"]
    trial.seconds(0.5)
    again = trial.fail(BELT, CAMERA)
    assert [e.event for e in again] == ["mended", "malfunction"] * 2
    assert len(trial.record) == 4


def test_what_is_announced_is_shown_until_it_works_again_and_what_is_silent_never(trial):
    (event,) = trial.fail(BELT)
    assert event.secret
    assert trial.judge.state()["malfunctions"] == []
    trial.fail()
    (event,) = trial.fail(BELT, announced=True)
    assert not event.secret
    assert trial.judge.state()["malfunctions"] == ["left_belt: the belt is off its wheels"]
    trial.fail()
    assert trial.judge.state()["malfunctions"] == []


def test_the_recording_makes_the_same_sheet(trial):
    trial.hold(0.5, 0.3)
    trial.fail(BELT)
    trial.hold(-0.5, 0.3)
    trial.e_stop(True)
    again = Judge(trial.judge.exercise)
    for entry in trial.entries:
        again.feed(entry)
    assert again.text() == trial.judge.text()
    assert len(trial.record) == 1


def test_what_makes_no_sense_is_said_and_ends_nothing(trial):
    trial.fail(BELT, value=math.nan)
    trial.feed("e_stop", "std_msgs/Bool", b"")
    trial.feed("sim/malfunctions", "telex_msgs/Malfunctions", b"\x01")
    assert len([event for event in trial.events if event.event == "invalid"]) == 3
    assert trial.record == []
