"""Briefs: conditions in words, what an exercise needs, and pictures of goals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from telex_training.briefing import goal
from telex_training.briefing.brief import exercise_brief, needed_controls
from telex_training.briefing.goal import GoalPictures
from telex_training.briefing.words import condition_words
from telex_training.exercises.catalog import exercises, find_exercise
from telex_training.exercises.conditions import ATOMS, EVENTS, read_condition
from telex_training.exercises.exercise_file import ExerciseError, load_exercise, parse_exercise


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"not": {"inside": {"what": "robot", "zone": "start"}}}, "the robot is outside 'start'"),
        (
            {"inside": {"what": "panel/cap_1", "zone": "left_1"}, "for": 2},
            "cap 1 of the panel is in 'left 1' for 2 s",
        ),
        (
            {"held": {"object": "cube", "above": 20}},
            "the gripper holds the cube with more than 20 N",
        ),
        ({"not": {"held": {}}}, "the gripper does not hold anything"),
        (
            {"any": [{"touches": {"object": f"cone_{i}"}} for i in (1, 2, 3)]},
            "the robot touches cone 1, cone 2 or cone 3",
        ),
        (
            {"any": [{"touches": {"object": "box", "zone": f"dot_{i}"}} for i in (1, 2)]},
            "the robot touches the box in 'dot 1' or the robot touches the box in 'dot 2'",
        ),
        (
            {"all": [{"touches": {"object": "a"}}, {"not": {"held": {}}}]},
            "the robot touches the a and the gripper does not hold anything",
        ),
        (
            {"not": {"any": [{"touches": {"object": f"cone_{i}"}} for i in (1, 2)]}},
            "the robot does not touch cone 1 or cone 2",
        ),
        (
            {"not": {"all": [{"touches": {"object": f"cone_{i}"}} for i in (1, 2)]}},
            "the robot does not touch cone 1 or the robot does not touch cone 2",
        ),
        (
            {"any": [{"touches": {"object": "box", "group": g}} for g in ("arm", "gripper")]},
            "the arm or the gripper touches the box",
        ),
        (
            {"any": [{"touches": {"object": "a"}}, {"force": {"object": "a", "above": 5}}]},
            "the robot touches the a or the robot pushes the a with more than 5 N",
        ),
        ({"touches": {"object": "floor", "group": "tracks"}}, "the tracks touch the floor"),
        ({"tilted": {"what": "robot", "angle": 1.2}}, "the robot leans by more than 69°"),
        ({"tilted": {"what": "robot", "angle": 0.1}}, "the robot leans by more than 5.7°"),
        (
            {"joint": {"object": "valve", "joint": "wheel_hinge", "above": 3.1416}},
            "the wheel hinge of the valve stands beyond 180°",
        ),
        (
            {"joint": {"object": "tray", "joint": "tray_slide", "below": 0.1}},
            "the tray slide of the tray stands below 0.1 m",
        ),
        (
            {"dropped": {"object": "cube", "outside": ["bin"]}},
            "the cube falls from the gripper by more than 5 cm outside 'bin'",
        ),
        ({"latch": {"object": "plug", "joint": "l", "held": False}}, "the plug is unlatched"),
        ({"answered": {"question": "q", "right": True}}, "the question 'q' is answered rightly"),
        ({"event": {"name": "command", "count": 3}}, "a command is given (3 times)"),
        ({"elapsed": 60}, "60 s have passed"),
        (
            {"all": [{"elapsed": 1}, {"any": [{"elapsed": 2}, {"held": {}}]}]},
            "1 s have passed and (2 s have passed or the gripper holds something)",
        ),
        (
            {"not": {"all": [{"elapsed": 1}, {"held": {}}]}},
            "1 s have not passed or the gripper does not hold anything",
        ),
    ],
)
def test_a_condition_in_words(given, words):
    assert str(condition_words(read_condition(given, "c"))) == words


def test_every_kind_of_condition_has_words_for_both_ways():
    some = {
        "what": "robot", "zone": "z", "object": "o", "joint": "j", "above": 1.0, "angle": 1.0,
        "distance": 1.0, "question": "q",
    }  # fmt: skip
    for kind, fields in ATOMS.items():
        given = {key: some[key] for key in fields.__dataclass_fields__ if key in some}
        atoms = [{kind: given}] if kind not in ("event", "elapsed") else [{"elapsed": 1.0}]
        if kind == "event":
            atoms = [{"event": {"name": name}} for name in EVENTS]
        for atom in atoms:
            yes = str(condition_words(read_condition(atom, "c")))
            no = str(condition_words(read_condition({"not": atom}, "c")))
            assert yes
            assert no not in ("", yes)


@pytest.mark.parametrize("name", sorted(exercises()))
def test_each_shipped_exercise_has_a_brief_in_all_settings(name):
    for exercise in load_exercise(find_exercise(name)).settings.values():
        brief = exercise_brief(exercise)
        assert [step["name"] for step in brief["steps"]] == [s.name for s in exercise.steps]
        bounded = [metric for metric in exercise.metrics if metric.bound is not None]
        assert [metric["pass"] for metric in brief["metrics"]] == [m.bound for m in bounded]
        assert brief["controls"]


def test_what_the_steps_show_is_needed_unless_the_file_says_so():
    def needed(text):
        return needed_controls(
            parse_exercise(f"scene: {{objects: []}}\n{text}", Path("/x.yaml")).first
        )

    assert needed("steps: [{name: a, until: {elapsed: 1}}]") == ("tracks",)
    assert needed("steps: [{name: a, until: {held: {}}}]") == ("tracks", "arm", "gripper")
    read = "steps: [{name: a, until: {answered: {question: q}}}]\n"
    asked = "questions: [{name: q, ask: Where, of: chart}]"
    assert needed(read + asked) == ("tracks", "camera")
    given = "controls: [flippers]\nsteps: [{name: a, until: {held: {}}}]"
    assert needed(given) == ("flippers",)
    with pytest.raises(ExerciseError, match=r"controls is \['wings'\]; tracks, flippers"):
        needed("controls: [wings]\nsteps: [{name: a, until: {held: {}}}]")


class TestGoals:
    def test_the_shipped_picture_is_that_of_the_first_setting(self, tmp_path):
        exercise = load_exercise(find_exercise("slalom")).first
        path = GoalPictures(tmp_path).picture(exercise)
        assert path.name == "slalom.jpg"
        assert not list(tmp_path.iterdir())

    def test_another_is_drawn_once_and_kept(self, tmp_path, monkeypatch):
        exercise = load_exercise(find_exercise("slalom")).setting("cones_3")
        commands = []

        def run(command, **options):
            commands.append(command)
            (output,) = [part[9:] for part in command if part.startswith("--output=")]
            cv2.imwrite(output, np.zeros((4, 4, 3), np.uint8))
            return goal.subprocess.CompletedProcess(command, 0, "", "")

        monkeypatch.setattr(goal.subprocess, "run", run)
        pictures = GoalPictures(tmp_path / "kept")
        first = pictures.picture(exercise)
        assert pictures.picture(exercise) == first
        assert first.is_file()
        assert len(commands) == 1
        assert "--setting=cones_3" in commands[0]
        # Another seed is another scene, and another picture.
        moved = replace(exercise, seeds=replace(exercise.seeds, practice=2))
        varied = replace(moved, scene=replace(moved.scene, changes={"start": {"x": 0.1}}))
        assert pictures.picture(varied) != first
        assert [path.suffix for path in (tmp_path / "kept").iterdir()] == [".jpg", ".jpg"]

    def test_what_cannot_be_drawn_is_said(self, tmp_path, monkeypatch):
        exercise = load_exercise(find_exercise("slalom")).setting("night")
        failed = goal.subprocess.CompletedProcess([], 1, "", "first\nx.yaml: scene: no such mesh\n")
        monkeypatch.setattr(goal.subprocess, "run", lambda *_, **__: failed)
        with pytest.raises(ExerciseError, match=r"x.yaml: scene: no such mesh"):
            GoalPictures(tmp_path).picture(exercise)
        assert not list(tmp_path.iterdir())
