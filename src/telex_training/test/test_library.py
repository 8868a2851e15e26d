"""Recordings whose sheets lack what is read of them: they hide no other ones."""

from __future__ import annotations

import json
import urllib.request

import pytest
from recorded_trials import record, sheet

from telex_training.ros.library import Library
from telex_training.ros.pages.class_pages import ClassPages
from telex_training.ros.pages.training_pages import TrainingPages


def without(*keys):
    """A sheet that lacks some of its keys."""
    return {key: value for key, value in sheet("t2", "bob").items() if key not in keys}


def repetition(**changes):
    """A sheet whose first repetition is another one."""
    made = sheet("t2", "bob")
    made["repetitions"][0].update(changes)
    return made


WRONG = {
    "no summary": without("summary"),
    "hardly anything": {"format": 1, "operator": "bob", "mode": "practice"},
    "another format": {**sheet("t2", "bob"), "format": 2},
    "no operator's name": {**sheet("t2", "bob"), "operator": 3},
    "half a surrogate pair": {**sheet("t2", "bob"), "verdict": "\ud800"},
    "what is no JSON": {**sheet("t2", "bob"), "summary": {"rate": float("nan")}},
    "no exercise": {**sheet("t2", "bob"), "exercise": []},
    "no seed": {**sheet("t2", "bob"), "exercise": {"name": "drill", "setting": "standard"}},
    "no repetition": {**sheet("t2", "bob"), "repetitions": [None]},
    "a repetition of no time": repetition(seconds=None),
    "a repetition of too long a time": repetition(penalty=10**400),
    "a repetition without figures": repetition(metrics=[]),
}


@pytest.fixture(params=WRONG.values(), ids=WRONG)
def folder(request, tmp_path, monkeypatch):
    """Two recordings: a good one of ann's, and one of bob's with a wrong sheet."""
    record(tmp_path / "trials", "ann")
    monkeypatch.setattr("recorded_trials.sheet_text", json.dumps)
    record(tmp_path / "trials", "bob", made=request.param)
    return tmp_path / "trials"


def test_sheets_and_best_times_are_those_of_whole_sheets(folder):
    library = Library(folder)
    (found,) = library.sheets()
    assert found["operator"] == "ann"
    assert library.best("ann") == {"drill": 20.0}
    assert library.best("bob") == {}


def test_instructors_are_told_the_others(folder):
    pages = TrainingPages(Library(folder), folder, 0, print, ClassPages(dict, str, print))
    pages.start()
    try:
        headers = {"X-Telex-Role": "instructor"}
        request = urllib.request.Request(f"{pages._address}/training/api/sheets", headers=headers)
        with urllib.request.urlopen(request, timeout=20.0) as reply:
            assert [row["operator"] for row in json.loads(reply.read())] == ["ann"]
    finally:
        pages.close()
