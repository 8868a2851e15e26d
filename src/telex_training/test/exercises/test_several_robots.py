"""Exercises for several robots: their key, what is refused, what a seed moves."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from telex_sim.scene.files.scene_file import SceneError, parse_scene
from telex_sim.scene.model import Start
from telex_training.briefing.words import condition_words
from telex_training.exercises.exercise_file import ExerciseError, parse_exercise
from telex_training.exercises.seeds import scene_of, scene_text

PATH = Path("/exercises/pair.yaml")
PAIR = """
scene:
  start: {x: 1.0}
  objects: [{type: cube, name: cube, position: [2, 0, 0]}]
robots:
  - {name: second, x: 0.5, y: -1.0, yaw: 0.1, pose: ready}
steps:
  - name: both
    until:
      all:
        - {held: {object: cube}}
        - {held: {object: cube}, robot: second}
        - {not: {tilted: {what: robot, angle: 0.2}}, robot: second}
metrics: {far: {kind: base_path, robot: second}}
"""
FAILING = "malfunctions: [{when: {elapsed: 1}, what: front, kind: dark, robot: third}]"
THREE = "".join(f"- {{name: r{i}, x: 0, y: {i}}}\n  " for i in range(3))


def made(text: str = PAIR):
    return parse_exercise(text, PATH).first


def test_further_robots_start_where_the_exercise_says():
    scene = scene_of(made(), scene_text(made(), 1))
    assert scene.start == Start(x=1.0)
    assert scene.robots == (Start(0.5, -1.0, 0.0, 0.1, "ready"),)


def test_a_seed_moves_the_start_of_a_further_robot_alone():
    moved = made(PAIR + "vary: [{object: second, position: [0.3, 0, 0]}]")
    starts = [yaml.safe_load(scene_text(moved, seed))["robots"][0] for seed in (1, 2)]
    assert starts[0]["x"] != starts[1]["x"]
    assert all(abs(start["x"] - 0.5) <= 0.3 for start in starts)
    assert yaml.safe_load(scene_text(moved, 1))["start"] == {"x": 1.0}


def test_an_exercise_of_one_robot_makes_the_scene_that_it_made():
    alone = PAIR[: PAIR.index("robots:")] + "steps: [{name: held, until: {held: {object: cube}}}]"
    assert "robots" not in yaml.safe_load(scene_text(made(alone), 1))


def test_parts_of_a_condition_are_of_its_robot_unless_they_say_otherwise():
    (step,) = made().steps
    assert [part.robot for part in step.until.walk() if not part.parts] == ["", "second", "second"]
    assert str(condition_words(step.until)) == (
        "the gripper holds the cube, the gripper holds the cube (robot 'second') and the robot "
        "leans by no more than 11° (robot 'second')"
    )


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        (("robot: second}", "robot: third}"), r"held/robot is 'third'; .* there are: second"),
        (("name: second", "name: robot"), r"robots\[0\].* name is 'robot'|name is 'robot'"),
        (("x: 0.5", "x: .nan"), r"robots\[0\]/x is nan; it must be finite"),
        (("y: -1.0, ", ""), r"robots\[0\].*y"),
        (("kind: base_path", "kind: time"), r"robot does not belong to time"),
        (("metrics:", f"{FAILING}\nmetrics:"), r"malfunctions\[0\]/robot is 'third'; .* second"),
        (("- {held: {object: cube}}", "- {elapsed: 3, robot: second}"), r"/robot does not belong"),
        (("- {name: second", "- {name: second, x: 0, y: 0}\n  - {name: second"), r"'second'"),
        (("- {name: second", f"{THREE}- {{name: second"), r"robots has 4 entries; at most 3"),
    ],
)
def test_what_is_wrong_is_named(change, wrong):
    with pytest.raises(ExerciseError, match=wrong):
        made(PAIR.replace(*change))


def test_a_scene_refuses_more_starts_than_robots_can_be():
    starts = "[" + ", ".join(f"{{y: {i}}}" for i in range(4)) + "]"
    with pytest.raises(SceneError, match="robots has 4 starts; at most 3"):
        parse_scene(f"robots: {starts}", PATH)
