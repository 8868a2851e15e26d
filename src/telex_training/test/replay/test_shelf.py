"""Whose recordings are opened for whom, and that others' are not even read."""

from __future__ import annotations

import threading
import time

import pytest
from replay_drill import drill, record

from telex_training.judging.moments import moment_note
from telex_training.recording.amending import alone, amend_alone
from telex_training.replay.replay import Replay
from telex_training.ros.library import Library
from telex_training.ros.replay.shelf import NotHereError, Shelf


@pytest.fixture
def shelf(tmp_path):
    """With a recording of ann's that has no sheet."""
    record(tmp_path / "t1.mcap", drill().entries)
    return Shelf(Library(tmp_path), "", {})


def test_a_recording_without_a_sheet_is_opened_for_its_operator_and_instructors(shelf):
    assert shelf.permitted("t1", "ann", False).replay.trial.trial == "t1"
    assert shelf.permitted("t1", "", True).replay.trial.trial == "t1"


@pytest.mark.parametrize("trial", ["t1", "t2"])
def test_what_others_may_not_see_is_not_read(shelf, trial, monkeypatch):
    def read(*_):
        raise AssertionError("it is read")

    monkeypatch.setattr(Replay, "open", read)
    with pytest.raises(NotHereError):
        shelf.permitted(trial, "bob", False)


def test_a_note_that_waits_for_another_hides_none(shelf):
    replay = shelf.open("t1").replay
    folder = replay.path.parent

    def note(text, at=1.0):
        return moment_note({"at": at, "text": text, "by": "ann", "instructor": False})

    waiting = threading.Thread(target=shelf.note, args=(replay, note("mine")))
    with alone(folder):
        waiting.start()
        time.sleep(0.2)
        amend_alone(replay.path, [note("another's", 0.5).content()], time.time_ns())
    waiting.join()
    assert {each.text for each in shelf.open("t1").replay.notes} == {"mine", "another's"}
