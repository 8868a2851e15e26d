"""The shipped exercises: what is in their files, and that each has its picture."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from telex_training.command_lines.exercise import main
from telex_training.exercises.catalog import (
    exercise_folders,
    exercises,
    find_exercise,
    known_exercise,
)
from telex_training.exercises.check import check_file
from telex_training.exercises.exercise_file import ExerciseError, load_exercise
from telex_training.exercises.preview_sheet import sheet_of
from telex_training.operators.experts.catalog import EXPERTS

SHIPPED = exercise_folders()[-1]
PICTURES = SHIPPED / "previews"
LARGEST = 45_000
FILES = sorted(SHIPPED.glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
class TestShipped:
    def test_its_name_is_that_of_its_file(self, path: Path) -> None:
        assert load_exercise(path).first.name == path.stem

    def test_it_has_a_small_picture(self, path: Path) -> None:
        picture = PICTURES / f"{path.stem}.jpg"
        assert picture.stat().st_size <= LARGEST
        assert cv2.imread(str(picture)).shape == (270, 480, 3)

    def test_time_has_a_pass_value_above_what_the_expert_needs(self, path: Path) -> None:
        for exercise in load_exercise(path).settings.values():
            time = next(metric for metric in exercise.metrics if metric.kind == "time")
            assert time.bound is not None
            if time.expert is not None:
                assert time.bound > time.expert[0]


def test_every_expert_has_an_exercise() -> None:
    assert set(EXPERTS) <= set(exercises())


@pytest.mark.parametrize(
    ("name", "marked"), [("gap", {"gap_50", "gap_60"}), ("hurdle", set()), ("stairs", set())]
)
def test_what_no_operator_has_shown_is_marked(name: str, marked: set) -> None:
    file = load_exercise(SHIPPED / f"{name}.yaml")
    found = set()
    for finding in check_file(file, False):
        if "beyond the robot's reach" in finding.text:
            found |= set(file.settings) & set(
                finding.where.replace(",", " ").replace(":", " ").split()
            )
    assert found == marked


def test_a_sheet_has_its_pictures_in_rows_over_their_titles() -> None:
    pictures = [
        (f"no {level}", np.full((30, 40, 3), level, np.uint8)) for level in (10, 20, 30, 40)
    ]
    sheet = sheet_of(pictures)
    assert sheet.shape[1] == 120
    assert sheet.shape[0] % 2 == 0
    second_row = sheet.shape[0] // 2
    assert sheet[15, 60].tolist() == [20, 20, 20]
    assert sheet[second_row + 15, 20].tolist() == [40, 40, 40]


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (["--all", "x", "--top"], "--all takes no"),
        (["--all", "x", "--seed", "0"], "--all takes no"),
        (["slalom", "--sheet", "x.jpg"], "--sheet belongs to --all"),
        (["--all", "x", "--sheet", "x.nothing"], "unknown kind of picture"),
    ],
)
def test_options_that_do_not_go_together_are_refused(given: list, reason: str, capsys) -> None:
    assert main(["preview", *given]) == 1
    assert reason in capsys.readouterr().err


@pytest.mark.parametrize("name", [str(FILES[0]), f"./{FILES[0].stem}", FILES[0].name, ""])
def test_a_path_is_no_name(name: str) -> None:
    with pytest.raises(ExerciseError, match="there is no exercise '.*'; there are: "):
        known_exercise(name)


def test_a_name_and_the_path_find_the_same_file() -> None:
    path = FILES[0]
    assert known_exercise(path.stem) == find_exercise(path.stem) == find_exercise(str(path)) == path
