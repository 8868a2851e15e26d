"""The sheet as text: what was measured, and what was not."""

from __future__ import annotations

from training_truth import Trial, exercise

from telex_training.command_lines.score import sheet_report

TEXT = """
name: drill
zones:
  start: {center: [0, 0, 0], size: [1, 2, 1]}
  goal: {center: [3, 0, 0], size: [1, 2, 1]}
begin: {not: {inside: {what: robot, zone: start}}}
steps: [{name: there, until: {inside: {what: robot, zone: goal}}}]
repetitions: {most: 1, least: 1}
metrics: {time: {pass: 2}}
"""


def report(distance):
    trial = Trial(exercise(TEXT)).begin()
    trial.drive(distance)
    trial.input("abort")
    return trial.judge.sheet(), sheet_report(trial.judge.sheet(), "t1", [])


def test_a_metric_without_a_repetition_has_no_figure_and_is_not_missed():
    sheet, text = report(0.2)
    assert sheet["metrics"][0]["within"] is False
    assert "no figure, <= 2\n" in text
    assert "MISSED" not in text


def test_a_figure_beyond_its_bound_is_missed():
    _, text = report(3.0)
    assert "<= 2: MISSED" in text


def test_what_would_have_passed_is_called_invalid_where_it_does_not_count():
    sheet, _ = report(3.0)
    passed = {**sheet, "verdict": "passed"}
    assert "\nPASSED: " in sheet_report(passed, "t1", [])
    text = sheet_report({**passed, "valid": False, "invalid_because": ["log: 3 gaps"]}, "t1", [])
    assert "\nINVALID: " in text
    assert "\n  not valid: log: 3 gaps\n" in text
