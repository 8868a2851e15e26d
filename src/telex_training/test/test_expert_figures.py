"""Figures of experts: where a file has them, and how new ones are put there."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

import pytest
import yaml

from telex_training.command_lines.expert import main
from telex_training.exercises.exercise_file import ExerciseFile, load_exercise
from telex_training.exercises.seeds import scene_text
from telex_training.operators.port import NotManagedError
from telex_training.rehearsal import figures

TEXT = """
name: walk
scene: {start: {x: 0.0, y: 0.0}}
settings:
  - {name: near, metrics: {time: {pass: 60}}}   # its own pass value, the figure of all
  - name: far
    metrics: {time: {pass: 90, expert: [30.0, 0.0]}, base_path: {expert: [7.5, 0.0]}}
  - {name: dark}
begin: {moved: {what: robot, distance: 0.1}}
steps: [{name: go, until: {moved: {what: robot, distance: 2.0}}}]
metrics:
  time: {pass: 50, expert: [12, 0]}
  base_path: {}
  idle: {}
expert: {by: script, repetitions: 1}   # provisional
"""


@pytest.fixture
def file(tmp_path: Path) -> ExerciseFile:
    path = tmp_path / "walk.yaml"
    path.write_text(TEXT)
    return load_exercise(path)


def sheet(**values: float) -> Dict[str, Any]:
    metrics = [
        {"name": name, "value": value, "pass": 100.0, "within": value < 100.0}
        for name, value in values.items()
    ]
    return {
        "verdict": "passed" if all(each["within"] for each in metrics) else "failed",
        "repetitions": [{"fault": None, "seconds": values["time"]}],
        "metrics": metrics,
        "exercise": {"seed": 1},
    }


def test_a_figure_is_measured_in_the_first_setting_that_it_holds_for(file: ExerciseFile) -> None:
    found = [(each.setting, each.metric) for each in figures.places(file)]
    assert found == [("far", "time"), ("far", "base_path"), ("near", "time")]


def test_new_figures_change_nothing_else(file: ExerciseFile) -> None:
    new = {
        "far": {"time": (33.333333, 1.256), "base_path": (7.61, 0.0)},
        "near": {"time": (14.0, 0.5)},
    }
    text = figures.with_figures(file.text, figures.places(file), new, 5)
    for old, put in (
        ("[30.0, 0.0]", "[33.33, 1.3]"),
        ("[7.5, 0.0]", "[7.61, 0.0]"),
        ("[12, 0]", "[14.0, 0.5]"),
        ("repetitions: 1}", "repetitions: 5}"),
    ):
        assert TEXT.count(old) == text.count(put) == 1
        text = text.replace(put, old)
    assert text == TEXT


def test_a_figure_without_a_value_is_refused(file: ExerciseFile) -> None:
    with pytest.raises(figures.FiguresError, match="base_path has no value in setting 'far'"):
        figures.with_figures(file.text, figures.places(file), {"far": {"time": (1.0, 0.1)}}, 5)


def test_a_file_that_says_nothing_of_repetitions_is_refused(file: ExerciseFile) -> None:
    with pytest.raises(figures.FiguresError, match="expert/repetitions is missing"):
        figures.with_figures(file.text.replace(", repetitions: 1", ""), [], {}, 5)


def test_where_a_seed_moves_nothing_it_moves_the_start(file: ExerciseFile) -> None:
    exercise = figures.spread(file.first)
    starts = [yaml.safe_load(scene_text(exercise, seed))["start"] for seed in (1, 2)]
    assert starts[0] != starts[1]
    for start in starts:
        assert max(abs(start["x"]), abs(start["y"]), abs(start["yaw"])) <= 0.02
    assert figures.spread(exercise) is exercise


def test_mean_and_deviation_are_of_the_runs(file: ExerciseFile, monkeypatch: Any) -> None:
    runs = {1: sheet(time=10.0, path=4.0), 2: sheet(time=14.0, path=4.0)}
    monkeypatch.setattr(figures, "rehearse", lambda exercise, expert, seed: runs[seed])
    seen: List[float] = []
    found = figures.measured(
        file.first, lambda hand, brief: None, (1, 2), lambda made: seen.append(made["verdict"])
    )
    assert found == {"time": (12.0, pytest.approx(8.0**0.5)), "path": (4.0, 0.0)}
    assert seen == ["passed", "passed"]


def test_an_expert_that_does_not_pass_has_no_figures(file: ExerciseFile, monkeypatch: Any) -> None:
    def gives_up(*given: Any) -> None:
        raise NotManagedError("stuck")

    with pytest.raises(figures.FiguresError, match="1 runs; at least 2"):
        figures.measured(file.first, lambda hand, brief: None, (1,))
    monkeypatch.setattr(figures, "rehearse", lambda *given: sheet(time=120.0))
    with pytest.raises(figures.FiguresError, match=r"walk, .* seed 1: .* time 120\.0"):
        figures.measured(file.first, lambda hand, brief: None, (1, 2))
    monkeypatch.setattr(figures, "rehearse", gives_up)
    with pytest.raises(figures.FiguresError, match="seed 1: the expert gave up: stuck"):
        figures.measured(file.first, lambda hand, brief: None, (1, 2))


def test_what_has_no_expert_is_said(capsys: Any) -> None:
    assert main(["nothing"]) == 1
    assert "nothing has no scripted expert; these have: acuity" in capsys.readouterr().err
