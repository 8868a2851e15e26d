"""Every kind of condition over a synthetic truth stream."""

from __future__ import annotations

import math

import pytest
from training_truth import LEVEL, SCENE, Trial, exercise

GO = "zones:\n  goal: {center: [3, 0, 0], radius: 0.5}\n  cup: {of: cube, size: [1, 1, 1]}\n"


def trial(condition, more=""):
    """A trial whose only step is done by the condition, and whose clock runs at once."""
    text = f"{GO}begin: {{elapsed: 0}}\nsteps: [{{name: go, until: {condition}}}]\n{more}"
    text = text.replace("{elapsed: 0}", "{not: {inside: {what: robot, zone: goal}}}")
    return Trial(exercise(text), scene=SCENE).begin()


def done(made):
    return "step" in made.kinds()


def test_inside_a_cylinder_that_has_no_end():
    made = trial("{inside: {what: robot, zone: goal}}")
    made.at(2.4, 0.0, 5.0)
    assert not done(made)
    made.at(2.6, 0.0, 5.0)
    assert done(made)


def test_inside_a_zone_that_moves_with_an_object():
    made = trial("{inside: {what: robot, zone: cup}}")
    made.sample()
    assert not done(made)
    quarter = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    made.bodies["cube/cube"] = ((0.4, 0.0, 0.0), quarter)
    made.sample()
    assert done(made)


def test_inside_a_box_that_is_turned():
    more = "".replace("", "")
    text = "zones: {goal: {center: [0, 0, 0], size: [4, 0.2, 1], yaw: 1.5708}}\n"
    text += "begin: {event: {name: command}}\n"
    text += "steps: [{name: go, until: {inside: {what: robot, zone: goal}}}]\n" + more
    made = Trial(exercise(text)).begin()
    made.robot = ((1.5, 0.0, 0.0), LEVEL)
    made.command(0.1)
    made.sample(2)
    assert not done(made)
    made.at(0.0, 1.5, 0.0)
    assert done(made)


def test_for_needs_the_whole_time_without_a_break():
    made = trial("{inside: {what: robot, zone: goal}, for: 0.5}")
    made.robot = ((3.0, 0.0, 0.0), LEVEL)
    made.seconds(0.4)
    made.at(0.0)
    made.robot = ((3.0, 0.0, 0.0), LEVEL)
    made.seconds(0.5)
    assert not done(made)
    made.sample()
    assert done(made)
    assert made.events[-1].event == "repetition"


def test_joints_and_latches():
    made = trial("{joint: {object: door, joint: hinge, above: 0.5, below: 1.0}}")
    for hinge, wanted in ((0.5, False), (1.2, False), (0.7, True)):
        made.hinge = hinge
        made.sample()
        assert done(made) is wanted
    made = trial("{joint: {object: robot, joint: elbow_joint, below: -0.2}}")
    made.sample()
    made.joints[3] = -0.3
    assert not done(made)
    made.sample()
    assert done(made)
    made = trial("{latch: {object: plug, joint: latch, held: false}}")
    made.sample()
    assert not done(made)
    made.latched = False
    made.sample()
    assert done(made)


def test_held_by_more_than_a_force():
    made = trial("{held: {object: cube, above: 20}}")
    made.held, made.grip = "plug", 50.0
    made.sample()
    made.held, made.grip = "cube", 10.0
    made.sample()
    assert not done(made)
    made.grip = 30.0
    made.sample()
    assert done(made)


def test_dropped_is_a_fall_outside_of_the_zones():
    made = trial("{dropped: {object: cube, height: 0.1, outside: [goal]}}")
    for x in (3.0, 2.0):
        made.bodies["cube/cube"] = ((x, 0.0, 0.5), LEVEL)
        made.held = "cube"
        made.sample()
        made.held = None
        made.sample()
        made.bodies["cube/cube"] = ((x, 0.0, 0.45), LEVEL)
        made.sample()
        assert not done(made)
        made.bodies["cube/cube"] = ((x, 0.0, 0.3), LEVEL)
        made.sample()
    assert done(made)
    assert made.kinds().count("step") == 1


def test_the_plug_of_a_socket_that_stands_fast_can_be_dropped():
    made = trial("{dropped: {object: plug, height: 0.1}}")
    for height, held in ((0.8, "plug"), (0.8, None), (0.75, None)):
        made.bodies["plug/plug"] = ((0.0, -4.2, height), LEVEL)
        made.held = held
        made.sample()
    assert not done(made)
    made.bodies["plug/plug"] = ((0.0, -4.2, 0.6), LEVEL)
    made.sample()
    assert done(made)
    assert [event.name for event in made.events if event.event == "drop"] == ["plug/plug"]


def test_touches_and_force_by_group():
    made = trial("{touches: {object: wall, group: arm}}")
    made.contacts = [("base", "wall", 5.0), ("arm", "cube", 5.0)]
    made.sample()
    assert not done(made)
    made.contacts = [("arm", "wall", 5.0)]
    made.sample()
    assert done(made)
    made = trial("{force: {object: floor, above: 300}}")
    made.contacts = [("tracks", "floor", 290.0)]
    made.sample()
    assert not done(made)
    made.contacts = [("tracks", "floor", 310.0)]
    made.sample()
    assert done(made)


def test_touches_in_a_zone():
    zones = "zones: {dot: {of: cube, center: [-1, 0, 0.5], size: [0.1, 0.1, 0.1]}}\n"
    text = f"{zones}begin: {{event: {{name: command}}}}\nsteps: [{{name: go, until: "
    made = Trial(exercise(text + "{touches: {object: wall, zone: dot}}}]"), scene=SCENE).begin()
    made.command(0.1)
    cases = (("wall", 0.06, False), ("door", 0.04, False), ("wall", 0.04, True))
    for thing, aside, wanted in cases:
        made.contacts = [("arm", thing, 5.0)]
        made.bodies["cube/cube"] = ((2.0, aside, 0.0), LEVEL)
        made.sample()
        assert done(made) is wanted


def test_tilted_and_moved():
    made = trial("{tilted: {what: cube, angle: 0.5}}")
    for angle, wanted in ((0.45, False), (0.55, True)):
        made.bodies["cube/cube"] = (
            (2.0, 0.0, 0.0),
            (math.sin(angle / 2), 0.0, 0.0, math.cos(angle / 2)),
        )
        made.sample()
        assert done(made) is wanted
    made = trial("{moved: {what: cube, distance: 0.2}}")
    for x, wanted in ((2.15, False), (2.25, True)):
        made.bodies["cube/cube"] = ((x, 0.0, 0.0), LEVEL)
        made.sample()
        assert done(made) is wanted


ASK = "questions: [{name: ring, ask: Where?, answer: Up Left}]\n"


@pytest.mark.parametrize(
    ("right", "given", "wanted"),
    [
        ("", "down", True),
        (", right: true", "down", False),
        (", right: true", " up  LEFT ", True),
        (", right: false", "down", True),
    ],
)
def test_answered(right, given, wanted):
    made = trial(f"{{answered: {{question: ring{right}}}}}", ASK)
    made.sample()
    assert not done(made)
    made.input("answer", question="ring", answer=given)
    made.sample()
    assert done(made) is wanted


def test_elapsed_counts_from_the_begin():
    made = trial("{elapsed: 1.0}")
    made.seconds(0.98)
    assert not done(made)
    made.sample(2)
    assert done(made)


def test_events_are_counted_in_this_repetition():
    made = trial("{event: {name: e_stop, count: 2}}")
    for _ in range(2):
        assert not done(made)
        made.status(e_stop=True)
        made.status(e_stop=False)
        made.sample()
    assert done(made)


def test_all_any_and_not():
    made = trial("{all: [{held: {}}, {not: {touches: {object: wall}}}, {any: [{elapsed: 0}]}]}")
    made.held, made.contacts = "cube", [("base", "wall", 5.0)]
    made.sample()
    assert not done(made)
    made.contacts = []
    made.sample()
    assert done(made)


def test_what_the_stream_does_not_know_does_not_hold():
    made = trial("{any: [{inside: {what: ghost, zone: goal}}, {touches: {object: ghost}}]}")
    made.sample(3)
    assert not done(made)
    made = trial("{any: [{dose: {what: robot, above: 0}}, {inside: {what: tool, zone: goal}}]}")
    made.sample(3)
    assert not done(made)


def test_dose_counts_from_the_begin_of_the_repetition():
    made = trial("{dose: {what: arm, above: 0.5}}")
    made.doses(robot=1.0, arm=40.0)
    made.sample()
    made.doses(robot=9.0, arm=40.5)
    made.sample()
    assert not done(made)
    made.doses(robot=9.0, arm=40.51)
    made.sample()
    assert done(made)


def test_a_dose_that_was_set_back_counts_from_there():
    made = trial("{dose: {what: robot, above: 0.5}}")
    made.doses(robot=5.0)
    made.sample()
    made.doses(robot=1.0)
    made.sample()
    made.doses(robot=1.51)
    assert not done(made)
    made.sample()
    assert done(made)


def test_a_limit_of_dose_is_a_fault():
    made = trial("{elapsed: 60}", "limits: {dose: {robot: 2}}")
    made.doses(robot=5.0)
    made.sample(2)
    made.doses(robot=7.1)
    made.sample()
    assert [event.name for event in made.events if event.event == "fault"] == ["dose of robot"]


def test_dose_is_a_metric_of_a_component():
    made = trial(
        "{dose: {what: robot, above: 1}}", "metrics: {dose: {}, arm: {kind: dose, object: arm}}"
    )
    made.doses(robot=0.5, arm=40.0)
    made.sample()
    made.doses(robot=1.75, arm=40.25)
    made.sample()
    made.input("abort")
    figures = {each["name"]: each["value"] for each in made.judge.sheet()["metrics"]}
    assert figures == {"dose": 1.25, "arm": 0.25}


@pytest.mark.parametrize("received", [math.nan, -1.0, math.inf])
def test_a_dose_that_is_none_makes_the_trial_invalid(received):
    made = trial("{dose: {what: robot, above: 0}}")
    made.doses(robot=received)
    assert "sim/doses: a dose is" in made.judge.sheet()["invalid_because"][0]


def test_a_survey_counts_missed_points_and_how_uneven_the_speed_was():
    more = """survey: {points: [a, b, c], speed: 0.5, what: robot}
metrics: {missed_points: {pass: 0}, speed_error: {}}
"""
    text = (
        "zones:\n"
        + "".join(
            f"  {n}: {{center: [{x}, 0, 0], radius: 0.2}}\n" for n, x in zip("abc", (1, 2, 9))
        )
        + "begin: {not: {inside: {what: robot, zone: c}}}\n"
        + "steps: [{name: go, until: {moved: {what: robot, distance: 2.5}}}]\n"
        + more
    )
    made = Trial(exercise(text), scene=SCENE).begin()
    made.drive(1.5, speed=0.5)
    made.drive(2.6, speed=0.25)
    made.input("abort")
    figures = {each["name"]: each["value"] for each in made.judge.sheet()["metrics"]}
    assert figures["missed_points"] == 1.0
    # 0.7 m at the wanted speed, 1 m at half of it: the repetition ends there.
    assert figures["speed_error"] == pytest.approx(0.25 * 4.0 / 5.4, rel=0.02)


def test_a_surveys_map_is_off_by_what_the_odometry_has_drifted_since_the_begin():
    text = """
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: go, until: {moved: {what: robot, distance: 2.5}}}]
metrics: {missed_points: {pass: 0}, map_error: {}}
zones:
  start: {center: [0, 0, 0], radius: 0.5}
  a: {center: [1, 0, 0], radius: 0.2}
  b: {center: [3, 0, 0], radius: 0.2}
survey: {points: [a, b], speed: 0.5, what: robot}
"""
    made = Trial(exercise(text), scene=SCENE).begin()
    quarter = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))

    def error():
        return made.judge.sheet()["repetitions"][0]["metrics"]["map_error"]

    # The odometry began elsewhere, and looks along y where the robot looks along x.
    made.odometry(100.0, 0.0, quarter)
    made.at(0.6)
    made.odometry(7.0, 5.0, quarter)
    made.at(1.0)
    made.odometry(7.0, 5.4, quarter)
    made.at(2.0)
    made.odometry(7.1, 6.4, quarter)
    made.at(1.5)
    made.odometry(7.0, 5.9, quarter)
    made.at(3.0)
    # What comes after the last point is no part of the survey.
    made.odometry(50.0, 5.9, quarter)
    made.input("abort")
    assert error() == pytest.approx(0.1, abs=1e-9)
    assert made.judge.sheet()["valid"]


def test_an_odometry_that_is_no_number_is_refused():
    made = trial("{inside: {what: robot, zone: goal}}")
    made.odometry(math.nan, 0.0)
    assert not made.judge.sheet()["valid"]
