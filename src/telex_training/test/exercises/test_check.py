"""Checks of exercises against their scene and the robot, the command, and the preview's camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from telex_training.command_lines.exercise import main
from telex_training.exercises import preview
from telex_training.exercises.catalog import exercises
from telex_training.exercises.check import check_file
from telex_training.exercises.exercise_file import load_exercise, parse_exercise
from telex_training.exercises.seeds import scene_of, scene_text

pytestmark = pytest.mark.slow

SCENE = """
scene:
  floor: {size: 20}
  objects:
    - {type: cube, name: cube, position: [2, 0, 0]}
    - {type: wall, name: wall, position: [4, 0, 0]}
    - {type: door, name: door, position: [0, 5, 0]}
    - {type: connector, name: plug, position: [0, -5, 0]}
    - {type: gap, name: gap, position: [0, 8, 0], gap: 0.6}
zones: {start: {size: [2, 2, 2]}, goal: {center: [3, 0, 0], radius: 1}}
"""
BEGIN = "begin: {not: {inside: {what: robot, zone: start}}}\n"
STEPS = "steps: [{name: go, until: {inside: {what: robot, zone: goal}}}]\n"


def findings(more, with_robot=False):
    file = parse_exercise(SCENE + more, Path("/exercises/drill.yaml"))
    return [str(finding) for finding in check_file(file, with_robot)]


def step(condition):
    return BEGIN + f"steps: [{{name: go, until: {condition}}}]\n"


def test_nothing_is_found_where_all_is_well_but_what_is_beyond_the_robots_reach():
    assert findings(BEGIN + STEPS) == [
        "note: scene (gap): gap is 0.6; beyond the robot's reach, which is shown up to 0.4"
    ]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (step("{inside: {what: cub, zone: goal}}"), "what is 'cub'; object is 'cub'; there are: c"),
        (step("{inside: {what: door/top, zone: goal}}"), "of door, the truth has the poses of: "),
        (step("{moved: {what: wall, distance: 1}}"), "what is 'wall', which stands fast"),
        (step("{held: {object: wall}}"), "object is 'wall', which stands fast"),
        (step("{joint: {object: door, joint: top, above: 0}}"), "door has the joints: "),
        (step("{joint: {object: cube, joint: top, above: 0}}"), "cube has the joints: none"),
        (step("{latch: {object: plug, joint: top}}"), "plug has the latches: latch"),
        (step("{touches: {object: door, group: nose}}"), "group is 'nose'; base, tracks, arm"),
        (step("{answered: {question: ring}}"), "question is 'ring'; there are: none"),
        (step("{dose: {what: robot, above: 1}}"), "until/dose: the scene has no source"),
        (BEGIN + STEPS + "metrics: {dose: {}}", "metrics/dose: the scene has no source; `sources`"),
        (
            BEGIN + STEPS + "sources: [{object: rock, nuclide: Co-60, activity: 1}]",
            "sources[0]/object: the scene has no entry of the name 'rock'",
        ),
        (BEGIN + STEPS + "vary: [{object: rock}]", "scene: vary[0]/object: the scene has no entry"),
        (BEGIN + STEPS + "contacts: {allowed: [[nose, cube]]}", "contacts/allowed: group is 'n"),
        (BEGIN + STEPS + "contacts: {allowed: [[any, rock]]}", "contacts/allowed: object is 'r"),
        (BEGIN + STEPS + "put_back: {objects: [rock]}", "put_back/objects: object is 'rock'"),
        (BEGIN + STEPS + "metrics: {drops: {object: rock}}", "metrics/drops/object: object is "),
        (BEGIN + STEPS + "metrics: {proficiency: {pass: 1}}", "metrics/time/expert is missing"),
        (BEGIN + STEPS + "metrics: {answers: {}}", "metrics/answers: the exercise asks no quest"),
        (BEGIN + STEPS + "hints: [{on: gone, text: x}]", "hints[0]/on: it is 'gone'; possible"),
        (BEGIN + STEPS + "questions: [{name: a, ask: b, of: rock}]", "questions (a)/of: object"),
        (BEGIN + STEPS + "questions: [{name: a, ask: b, of: cube}]", "type is 'cube'; chart, "),
        (STEPS + "begin: {inside: {what: robot, zone: start}}", "begin: it holds already where"),
    ],
)
def test_what_nothing_could_measure_is_named(more, said):
    found = findings(more)
    assert any(said in finding for finding in found), found
    assert not any(said in finding for finding in found if finding.startswith("note"))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("questions: [{name: a, ask: b}]\n", "note: questions (a): neither of nor answer"),
        ("put_back: {robot: false}\n", "note: put_back: this version puts everything back"),
        ("metrics: {time: {pass: 0.00001}}\n", "note: metrics/time/pass: it is 1e-05; figures are"),
    ],
)
def test_what_is_only_worth_knowing_is_a_note(more, said):
    assert any(finding.startswith(said) for finding in findings(BEGIN + STEPS + more))


@pytest.mark.parametrize(
    ("zone", "said"),
    [
        ("{center: [30, 0, 0], radius: 1}", "outside of the scene's floor, which goes to 10 m"),
        ("{center: [3, 0, -3], size: [1, 1, 1]}", "all of it is below the floor"),
        ("{of: rock, radius: 1}", "object is 'rock'; there are: cube, wall"),
    ],
)
def test_a_zone_outside_of_the_scene_is_named(zone, said):
    text = SCENE.replace("{center: [3, 0, 0], radius: 1}", zone) + BEGIN + STEPS
    file = parse_exercise(text, Path("/exercises/drill.yaml"))
    assert any(said in str(finding) for finding in check_file(file, False))


def test_what_holds_in_some_settings_alone_is_said_with_them():
    settings = "{name: a}, {name: b, objects: {gap: {gap: 0.2}}}, {name: c}"
    more = f"settings: [{settings}]\n"
    found = findings(BEGIN + STEPS + more)
    assert any(finding.startswith("note: setting a, c: scene (gap)") for finding in found)


def test_what_the_variant_lacks_and_a_robot_without_room_are_named():
    more = step("{all: [{held: {object: cube}}, {joint: {object: robot, joint: j, above: 0}}]}")
    found = findings(more + "variant: carrier\nhistory: {arm: 3}\n", with_robot=True)
    assert any(x.startswith("history/arm: it is 'arm', and there are robot, ") for x in found)
    assert any("held: it needs a gripper, which the variant 'carrier' lacks" in x for x in found)
    assert any("joint: it needs the joint 'j'" in x for x in found)
    found = findings(BEGIN + STEPS + "start: {x: 3.9}\n", with_robot=True)
    assert any(x.startswith("scene: ") and "wall" in x for x in found)
    found = findings(BEGIN + STEPS + "start: {pose: dance}\n", with_robot=True)
    assert any("dance" in x for x in found)
    found = findings(BEGIN + STEPS + "variant: giant\n", with_robot=True)
    assert any(x.startswith("variant: ") for x in found)


@pytest.mark.parametrize("name", sorted(exercises()))
def test_shipped_exercises_are_right(name):
    found = check_file(load_exercise(exercises()[name]))
    assert not [str(finding) for finding in found if finding.wrong]


def test_the_command_lists_and_checks(tmp_path, capsys):
    assert main(["list"]) == 0
    assert "slalom: Slalom" in capsys.readouterr().out
    assert main(["check", "--no-robot", "slalom"]) == 0
    assert "slalom.yaml: OK, 5 settings, 14 steps, 14 zones, 9 metrics" in capsys.readouterr().out
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(SCENE + step("{inside: {what: robot, zone: gaol}}"))
    assert main(["check", "--no-robot", str(wrong), "slalon"]) == 1
    said = capsys.readouterr().err
    assert f"{wrong}: steps[0] (go)/until/inside: zone is 'gaol'" in said
    assert "there is no exercise 'slalon'" in said
    assert main(["preview", "slalom", "-o", str(tmp_path / "x.what")]) == 1
    assert "unknown kind of picture" in capsys.readouterr().err


def test_the_preview_shows_every_zone():
    made = load_exercise(exercises()["slalom"]).first
    scene = scene_of(made, scene_text(made, 1))
    for top in (False, True):
        camera = preview.framed(made, scene, (640, 360), top)
        for zone in made.zones.values():
            for line in preview.outline(zone, preview.frame_of(zone, scene)):
                for x, y in camera.segment(*line):
                    assert 0 <= x < 640
                    assert 0 <= y < 360
        picture = np.zeros((360, 640, 3), np.uint8)
        preview.annotate(picture, made, scene, camera)
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20


def test_what_is_behind_the_camera_is_not_drawn():
    camera = preview.Camera(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0, 100, 100)
    assert camera.segment((-1.0, 0.0, 0.0), (-2.0, 0.0, 0.0)) == []
    assert camera.segment((2.0, 0.0, 0.0), (-2.0, 0.0, 0.0))[0] is not None
    assert camera.segment((2.0, 0.0, 0.0), (4.0, 0.0, 0.0)) == [(50, 50), (50, 50)]


def test_the_example_of_the_documents_is_right():
    root = Path(__file__).resolve().parents[4]
    text = (root / "docs" / "instructor" / "exercises.md").read_text()
    example = text.split("```yaml\n")[1].split("```")[0]
    file = parse_exercise(example, Path("/exercises/fetch.yaml"))
    assert list(file.settings) == ["day", "night"]
    assert [str(finding) for finding in check_file(file, with_robot=False)] == [
        "note: zones/beside: no condition names it"
    ]
