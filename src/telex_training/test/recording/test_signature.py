"""Signatures of exams: what is valid, what has changed, whose key it is, and what keeps one."""

from __future__ import annotations

import json
import os
import stat

import pytest
from recorded_trials import judged_trial, record

from telex_training.command_lines.score import main as score
from telex_training.progress.index import ProgressIndex
from telex_training.progress.reports.person_report import person_report
from telex_training.progress.trial_facts import read_trial
from telex_training.recording import station_keys
from telex_training.recording.amending import amend
from telex_training.recording.pseudonym import rename_person
from telex_training.recording.reader import Recording, read_recording
from telex_training.recording.signature import (
    CHANGED,
    NONE,
    OTHER,
    SIGNATURE,
    VALID,
    sealing,
    verified,
)
from telex_training.recording.station_keys import (
    PRIVATE,
    PUBLIC,
    TRUSTED,
    StationKeyError,
    known_keys,
    read_public_key,
    station_key,
)
from telex_training.recording.trial_file import SHEET, input_entry, signature_of
from telex_training.recording.writer import Attachment, RecordingWriter
from telex_training.ros.library import Library

NOTE = {"input": "note", "text": "looks back too late", "by": "instructor"}
RATING = {"input": "tlx", "values": [10.0] * 6}


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    folder = tmp_path / "home"
    monkeypatch.setenv("ROS_HOME", str(folder))
    return folder


@pytest.fixture
def exam(tmp_path):
    return record(tmp_path / "trials", mode="exam", signed=True)


def state(path):
    return signature_of(path, known_keys()).state


# Keys


def test_a_key_is_made_at_first_use_and_stays(home):
    assert known_keys() == {}
    key = station_key()
    assert station_key().public == key.public
    assert known_keys() == {key.public: "this station"}
    assert stat.S_IMODE((home / PRIVATE).stat().st_mode) == 0o600
    assert stat.S_IMODE((home / PUBLIC).stat().st_mode) == 0o644
    assert read_public_key(home / PUBLIC) == key.public
    assert key.public not in (home / PRIVATE).read_text()
    assert sorted(path.name for path in home.iterdir()) == [PRIVATE, PUBLIC]


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660])
def test_a_key_that_others_may_read_is_refused(home, mode):
    station_key()
    (home / PRIVATE).chmod(mode)
    with pytest.raises(StationKeyError, match=rf"others may read .*{PRIVATE}' \(mode {mode:04o}\)"):
        station_key()


def test_what_is_no_key_is_refused(home, tmp_path, monkeypatch):
    station_key()
    (home / PRIVATE).write_text("sesame")
    with pytest.raises(StationKeyError, match="holds no key; 64 digits in hexadecimal are needed"):
        station_key()
    with pytest.raises(StationKeyError, match="No such file"):
        read_public_key(tmp_path / "none.pub")
    monkeypatch.setattr(station_keys.os, "geteuid", lambda: os.getuid() + 1, raising=False)
    with pytest.raises(StationKeyError, match="belongs to another user"):
        station_key()


def test_keys_of_trusted_stations_stand_in_a_folder(home, tmp_path):
    other = station_key(tmp_path / "other").public
    (home / TRUSTED).mkdir(parents=True)
    (home / TRUSTED / "hall_2.pub").write_text(f"{other}\n")
    (home / TRUSTED / "broken.pub").write_text("no key")
    assert known_keys() == {other: "hall_2"}


# Signatures


def test_a_signature_is_valid_until_anything_changes(exam):
    assert state(exam) == VALID
    recording = read_recording(exam)
    keys = known_keys()

    def changed(**changes):
        made = {**vars(recording), **changes}
        found = verified(Recording(**made), keys)
        assert found.key == ""
        assert found.state == CHANGED
        return found.reason

    entries, walls, attached = recording.entries, recording.walls, recording.attachments
    first = entries[0]
    assert changed(entries=[], walls=[]) == "its entries are others"
    more = {"entries": [*entries, first], "walls": [*walls, walls[-1]]}
    assert changed(**more) == "its entries are others"
    for other in (
        [first._replace(time=first.time + 0.001), *entries[1:]],
        [first._replace(number=first.number + 1), *entries[1:]],
        [first._replace(channel="x"), *entries[1:]],
        [first._replace(kind="std_msgs/Empty"), *entries[1:]],
        [first._replace(data=first.data + b"x"), *entries[1:]],
    ):
        assert changed(entries=other) == "its entries are others"
    assert changed(walls=[walls[0] + 1, *walls[1:]]) == "its entries are others"
    better = Attachment("application/json", attached[SHEET].data.replace(b"passed", b"PASSED"))
    assert changed(attachments={**attached, SHEET: better}) == f"'{SHEET}' is another"
    added = {**attached, "more.json": better}
    assert changed(attachments=added) == "'more.json' has been added"
    without = {name: each for name, each in attached.items() if name != SHEET}
    assert changed(attachments=without) == f"'{SHEET}' is missing"
    assert changed(repeated=[SHEET]) == f"'{SHEET}' is there twice"


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: b"[" * 100000,
        lambda content: b"null",
        lambda content: json.dumps({**content, "signature": "zz"}).encode(),
        lambda content: json.dumps({**content, "signature": "00" * 64}).encode(),
        lambda content: json.dumps({**content, "key": "00"}).encode(),
        lambda content: json.dumps({**content, "key": None}).encode(),
        lambda content: json.dumps({**content, "signed": {}}).encode(),
        lambda content: json.dumps(
            {**content, "signed": {**content["signed"], "attachments": [[1, 2], ["a", 3]]}}
        ).encode(),
        lambda content: json.dumps(
            {**content, "signed": {**content["signed"], "format": 2}}
        ).encode(),
    ],
)
def test_what_is_no_signature_is_none(exam, damage):
    recording = read_recording(exam)
    content = json.loads(recording.attachments[SIGNATURE].data)
    made = Attachment("application/json", damage(content))
    attached = {**recording.attachments, SIGNATURE: made}
    found = verified(Recording(**{**vars(recording), "attachments": attached}), known_keys())
    assert (found.state, found.key) == (CHANGED, "")


def test_keys_that_are_not_known_do_not_count(exam, home, tmp_path, capsys):
    public = tmp_path / "hall_1.pub"
    (home / PUBLIC).rename(public)
    (home / PRIVATE).unlink()
    assert state(exam) == OTHER
    assert score(["--verify", str(exam)]) == 1
    assert "another key: signed with" in capsys.readouterr().out
    assert score(["--verify", str(exam), "--key", str(public)]) == 0
    assert capsys.readouterr().out == f"{exam}: valid, signed by hall_1.pub\n"
    index = ProgressIndex(exam.parent)
    assert index.refresh() == []
    (facts,) = index.trials()
    assert not facts.in_exam
    assert facts.flaw.startswith("another key")
    # As soon as it is trusted the exam counts, and its file need not change for that.
    (home / TRUSTED).mkdir()
    public.rename(home / TRUSTED / "hall_1.pub")
    assert index.trials()[0].in_exam
    assert score(["--verify", str(exam)]) == 0
    assert score(["--verify", "--key", str(public), str(exam)]) == 1
    assert "No such file" in capsys.readouterr().err


def test_an_exam_without_a_signature_is_none(tmp_path, capsys):
    path = record(tmp_path / "trials", mode="exam")
    assert state(path) == NONE
    assert not read_trial(path).in_exam
    assert score(["--verify", str(path)]) == 1
    assert capsys.readouterr().out == f"{path}: no signature\n"
    practised = record(tmp_path / "trials", "bob")
    assert read_trial(practised).flaw == ""
    with pytest.raises(SystemExit):
        score(["--key", "x.pub", str(path)])
    capsys.readouterr()
    assert score(["--verify", str(tmp_path / "none.mcap")]) == 1
    assert "No such file" in capsys.readouterr().err


def test_reports_and_sheets_say_what_a_signature_is_worth(exam):
    unsigned = record(exam.parent, "bob", mode="exam")
    library = Library(exam.parent)
    assert library.signature(exam.stem) == "valid, signed by this station"
    assert library.signature(unsigned.stem) == "no signature"
    assert library.signature("none") is None
    index = ProgressIndex(exam.parent)
    index.refresh()
    for name, shown in (("ann", "<td>exam</td>"), ("bob", "<td>exam, no signature</td>")):
        assert shown in person_report(name, index.trials(name), [], 0.0)


def test_marks_ratings_and_pseudonyms_keep_a_valid_signature_and_make_none(tmp_path):
    path = judged_trial(tmp_path / "trials")
    amend(path, [NOTE], 1)
    assert state(path) == NONE
    signed = resigned(path)
    for addition in (NOTE, RATING):
        amend(path, [addition], 1)
        assert state(path) == VALID
    amended = read_recording(path)
    assert len(amended.entries) == len(signed.entries) + 2
    renamed = rename_person(path, "ann", "p1").path
    assert state(renamed) == VALID
    # What was changed meanwhile is not vouched for by a note.
    forge(renamed)
    assert state(renamed) == CHANGED
    amend(renamed, [NOTE], 1)
    assert state(renamed) == NONE


def resigned(path):
    """Sign a recording as the station does at its close."""
    return rewritten(path, lambda recording: recording.entries, sealing(station_key()))


def forge(path):
    """Take the last entry out of a recording, and leave the rest, its signature included."""
    rewritten(path, lambda recording: recording.entries[:-1], None)


def rewritten(path, entries_of, seal):
    recording = read_recording(path)
    path.unlink()
    writer = RecordingWriter(path, recording.attachments)
    for entry, wall in zip(entries_of(recording), recording.walls):
        writer.put(entry, wall)
    writer.close({}, seal)
    return recording


def test_a_second_sheet_is_found(exam):
    recording = read_recording(exam)
    exam.unlink()
    writer = RecordingWriter(exam, recording.attachments)
    writer.put(input_entry(1, 0, {"input": "open"}), 1)
    writer.close({SHEET: recording.attachments[SHEET]})
    found = signature_of(exam, known_keys())
    assert (found.state, found.reason) == (CHANGED, f"'{SHEET}' is there twice")
