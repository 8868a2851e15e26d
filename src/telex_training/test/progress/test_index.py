"""The index: made of the recordings alone, again each time, whatever happens to file or index."""

import fcntl
import json
import os
import sqlite3
import stat

import pytest
from recorded_trials import record, sheet

from telex_training.progress import importing
from telex_training.progress.importing import KNOWN, NEW, NEWER, REFUSED, import_files
from telex_training.progress.index import ProgressIndex, ProgressIndexError
from telex_training.progress.trial_facts import MarkFacts, read_trial
from telex_training.recording import signature, writer
from telex_training.recording.amending import amend
from telex_training.recording.writer import RecordingError

OTHER = "2026-03-02_101500"


@pytest.fixture
def index(tmp_path):
    return ProgressIndex(tmp_path / "recordings")


def content(index):
    return index.people(), index.trials()


def repetition(**changes):
    """Changes of a sheet: its first repetition is another one."""
    first, *others = sheet("t")["repetitions"]
    return {"repetitions": [{**first, **changes}, *others]}


class Late(writer.Writer):
    """Writes messages of a time that no clock has come to."""

    def add_message(self, *arguments, log_time, **others):
        super().add_message(*arguments, log_time=2**64 - 1, **others)


class TestReading:
    def test_a_trial_is_read_back_as_its_sheet_has_it(self, index):
        path = record(index.folder, times=[(20.0, True), (0.0, False)], mode="exam")
        assert index.refresh() == []
        (trial,) = index.trials()
        assert trial == read_trial(path)
        assert (trial.operator, trial.exercise, trial.mode) == ("ann", "drill", "exam")
        assert trial.began == pytest.approx(1772360100.0)
        assert [each.completed for each in trial.repetitions] == [True, False]
        assert trial.repetitions[1].fault == "dropped"
        assert trial.repetitions[0].metrics == {"time": 20.0, "contacts": 0.0, "margin": 0.5}
        assert [(each.name, each.bound, each.expert) for each in trial.metrics] == [
            ("time", 30.0, 10.0),
            ("contacts", 0.0, None),
            ("margin", 0.4, None),
        ]
        assert (trial.faults, trial.passed) == (1, True)

    def test_marks_and_the_workload_are_read_with_it_and_anew_when_they_come_later(self, index):
        marks = [{"verdict": "failed", "reason": "too fast", "by": "instructor", "time": 3.0}]
        path = record(index.folder, marks=marks)
        index.refresh()
        (trial,) = index.trials()
        assert (trial.marks, trial.workload) == (
            (MarkFacts("failed", "too fast", "instructor"),),
            (),
        )
        amend(path, [{"input": "tlx", "values": [10, 20, 30, 40, 50, 60]}], 1)
        index.refresh()
        (trial,) = index.trials()
        assert trial == read_trial(path)
        assert trial.workload == (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
        assert trial.raw_workload == 35.0
        index.rebuild()
        assert index.trials() == [trial]
        record(index.folder, "bob", marks=[{"verdict": "failed"}])
        (problem,) = index.refresh()
        assert "marks[0]/reason is missing" in problem

    def test_people_and_their_trials_are_told_apart(self, index):
        record(index.folder)
        record(index.folder, stamp=OTHER)
        record(index.folder, "bob", exercise="valve")
        index.refresh()
        assert [(each.name, each.trials) for each in index.people()] == [("ann", 2), ("bob", 1)]
        assert [each.exercise for each in index.trials("bob")] == ["valve"]
        assert len(index.trials(exercise="drill")) == 2
        assert index.trials("bob", "drill") == []

    def test_a_name_cannot_be_a_command(self, index):
        name = "x'; DROP TABLE trials; --"
        record(index.folder, name)
        index.refresh()
        assert [each.operator for each in index.trials(name)] == [name]
        assert index.trials("x") == []

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"format": 2}, "format is 2; 1 is read"),
            ({"valid": "yes"}, "valid is 'yes'; true or false is needed"),
            ({"trial_seconds": float("inf")}, "trial_seconds is inf; it must be finite"),
            ({"trial": "../../etc/passwd"}, "trial is '../../etc/passwd'; letters"),
            ({"repetitions": [3]}, "repetitions[0]: a struct is needed"),
            ({"metrics": None}, "metrics: a list of at most"),
            ({"operator": "\ud800"}, "surrogates not allowed"),
            (repetition(seconds=1e300), "repetitions[0]/seconds is 1e+300; at most 1e+06"),
            (repetition(penalty=1e7), "repetitions[0]/penalty is 1e+07; at most 1e+06"),
            (repetition(began=5e9), "repetitions[0]/began is 5e+09; at most"),
            (repetition(metrics={"time": -1e300}), "metrics/time is -1e+300; at most 1e+12"),
        ],
    )
    def test_a_wrong_sheet_is_told_by_file_key_and_value(
        self, tmp_path, change, message, monkeypatch
    ):
        made = {**sheet("t"), **change}
        monkeypatch.setattr("recorded_trials.sheet_text", json.dumps)
        path = record(tmp_path, made=made)
        with pytest.raises(RecordingError) as caught:
            read_trial(path)
        assert message in str(caught.value)
        assert str(path) in str(caught.value)

    def test_a_time_has_the_digits_of_a_sheet(self, tmp_path):
        made = {**sheet("t"), **repetition(seconds=1e-300)}
        assert read_trial(record(tmp_path, made=made)).repetitions[0].seconds == 0.0

    def test_entries_of_an_exam_beyond_all_times_are_none(self, tmp_path, monkeypatch):
        monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
        assert read_trial(record(tmp_path, mode="exam", signed=True)).flaw == ""
        monkeypatch.setattr(writer, "Writer", Late)
        path = record(tmp_path, "bob", mode="exam", signed=True)
        assert read_trial(path).flaw == "changed: its entries are others"

    def test_a_signature_with_a_text_that_is_none_is_none(self, tmp_path, monkeypatch):
        monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
        monkeypatch.setattr(signature, "_hashes", lambda attached: {"\ud800": ""})
        path = record(tmp_path, mode="exam", signed=True)
        monkeypatch.undo()
        assert read_trial(path).flaw == "changed: its signature.json is no signature"


class TestRefreshing:
    def test_whatever_one_file_leads_to_the_others_are_taken_in(self, index, monkeypatch):
        record(index.folder)
        broken = record(index.folder, "bob")

        def read(path):
            if path == broken:
                raise KeyError("nobody has thought of this")
            return read_trial(path)

        monkeypatch.setattr("telex_training.progress.index.read_trial", read)
        (problem,) = index.refresh()
        assert problem == f"{broken}: KeyError: 'nobody has thought of this'"
        assert [each.operator for each in index.trials()] == ["ann"]

    def test_others_may_write_while_files_are_read(self, index, monkeypatch):
        record(index.folder)

        def read(path):
            with sqlite3.connect(index.path, timeout=0.0) as other:
                other.execute("BEGIN IMMEDIATE")
            other.close()
            return read_trial(path)

        monkeypatch.setattr("telex_training.progress.index.read_trial", read)
        assert index.refresh() == []
        assert len(index.trials()) == 1

    def test_who_is_forgotten_while_files_are_read_does_not_come_back(self, index, monkeypatch):
        gone = record(index.folder)
        record(index.folder, "bob")

        def read(path):
            found = read_trial(path)
            gone.unlink(missing_ok=True)
            return found

        monkeypatch.setattr("telex_training.progress.index.read_trial", read)
        assert index.refresh() == []
        assert [each.operator for each in index.trials()] == ["bob"]

    def test_a_damaged_file_that_has_gone_is_told_no_more(self, index):
        damaged = record(index.folder)
        damaged.write_bytes(b"no recording")
        assert len(index.refresh()) == 1
        damaged.unlink()
        assert index.refresh() == []

    def test_deleted_it_is_made_anew(self, index):
        record(index.folder)
        record(index.folder, "bob")
        index.refresh()
        before = content(index)
        index.path.unlink()
        index.refresh()
        assert content(index) == before

    @pytest.mark.parametrize("nonsense", [b"no database" * 1000, b"", b"SQLite format 3\0" * 50])
    def test_damaged_it_is_made_anew(self, index, nonsense):
        record(index.folder)
        index.refresh()
        before = content(index)
        index.path.write_bytes(nonsense)
        index.refresh()
        assert content(index) == before

    def test_of_another_version_it_is_made_anew(self, index):
        record(index.folder)
        index.refresh()
        before = content(index)
        base = sqlite3.connect(str(index.path))
        base.execute("PRAGMA user_version = 99")
        base.execute("DROP TABLE metrics")
        base.close()
        index.refresh()
        assert content(index) == before

    def test_files_that_change_or_go_are_followed(self, index):
        path = record(index.folder)
        other = record(index.folder, "bob")
        index.refresh()
        path.unlink()
        record(index.folder, times=[(12.0, True)])
        other.unlink()
        index.refresh()
        (trial,) = index.trials()
        assert [each.time for each in trial.repetitions] == [12.0]
        base = sqlite3.connect(str(index.path))
        counts = [
            base.execute(f"SELECT count(*) FROM {table}").fetchone()[0]
            for table in ("files", "trials", "repetitions", "figures", "metrics")
        ]
        base.close()
        assert counts == [1, 1, 1, 3, 3]

    def test_a_damaged_file_is_told_each_time_and_skipped(self, index):
        record(index.folder)
        damaged = record(index.folder, "bob")
        damaged.write_bytes(damaged.read_bytes()[:600])
        (index.folder / "nonsense.mcap").write_text("nonsense")
        running = record(index.folder, "eve", closed=False)
        for _ in range(2):
            problems = index.refresh()
            assert len(problems) == 3
            assert any(f"{damaged}: it is damaged, was cut off" in each for each in problems)
            assert any(f"{running}: it has no sheet.json" in each for each in problems)
            assert [each.name for each in index.people()] == ["ann"]

    def test_a_trial_that_stands_in_two_files_counts_once(self, index):
        path = record(index.folder)
        copied = index.folder / f"{path.stem} (1).mcap"
        copied.write_bytes(path.read_bytes())
        (problem,) = index.refresh()
        assert "stands in" in problem
        assert len(index.trials()) == 1
        index.file_of(path.stem).unlink()
        assert index.refresh() == []
        assert len(index.trials()) == 1

    def test_its_views_say_how_far_everybody_is(self, index):
        record(index.folder, times=[(20.0, True), (15.0, False), (0.0, False)])
        record(index.folder, stamp=OTHER, valid=False)
        index.refresh()
        base = sqlite3.connect(str(index.path))
        row = base.execute(
            "SELECT operator, trials, repetitions, completed, passed, best FROM progress"
        ).fetchall()
        base.close()
        assert row == [("ann", 1, 3, 2, 1, 15.0)]

    def test_only_its_owner_may_read_it(self, index):
        index.refresh()
        assert stat.S_IMODE(os.stat(index.path).st_mode) == 0o600

    def test_a_folder_that_cannot_be_written_is_named(self, tmp_path):
        (tmp_path / "file").write_text("")
        with pytest.raises(ProgressIndexError, match="file"):
            ProgressIndex(tmp_path / "file").refresh()


class TestImport:
    def test_a_trial_is_taken_in_once(self, index, tmp_path):
        theirs = tmp_path / "usb"
        record(theirs)
        record(theirs, "bob")
        record(index.folder, "eve")
        index.refresh()
        assert [each.what for each in import_files(index, [theirs])] == [NEW, NEW]
        before = content(index)
        assert [each.what for each in import_files(index, [theirs])] == [KNOWN, KNOWN]
        assert content(index) == before
        assert [each.name for each in before[0]] == ["ann", "bob", "eve"]
        index.rebuild()
        assert content(index) == before

    def test_its_own_folder_brings_nothing_new(self, index):
        record(index.folder)
        index.refresh()
        assert [each.what for each in import_files(index, [index.folder])] == [KNOWN]

    def test_a_damaged_file_is_told_and_skipped(self, index, tmp_path):
        theirs = tmp_path / "usb"
        good, bad = record(theirs), record(theirs, "bob")
        bad.write_bytes(b"nonsense")
        found = {each.path: each for each in import_files(index, [good, bad, theirs / "none"])}
        assert found[good].what == NEW
        assert found[bad].what == REFUSED
        assert str(bad) in found[bad].reason
        assert "No such file" in found[theirs / "none"].reason
        assert len(index.trials()) == 1

    def test_marks_that_were_added_later_are_taken_over(self, index, tmp_path, judged):
        theirs = tmp_path / "usb"
        ours = judged(index.folder)
        theirs.mkdir()
        copied = theirs / ours.name
        copied.write_bytes(ours.read_bytes())
        amend(copied, [{"input": "note", "text": "good", "by": "eve"}], 1)
        index.refresh()
        assert import_files(index, [copied])[0].what == NEWER
        assert index.trials()[0].log == read_trial(copied).log
        # The older one brings nothing.
        older = theirs / "older.mcap"
        copied.replace(older)
        judged(theirs)
        assert import_files(index, [theirs / ours.name])[0].what == KNOWN

    def test_a_workload_that_was_rated_later_is_taken_over(self, index, tmp_path, judged):
        ours, copied = judged(index.folder), judged(tmp_path / "usb")
        amend(copied, [{"input": "tlx", "values": [10, 20, 30, 40, 50, 60]}], 1)
        index.refresh()
        assert import_files(index, [copied])[0].what == NEWER
        assert ours.read_bytes() == copied.read_bytes()
        assert import_files(index, [copied])[0].what == KNOWN

    def test_marks_of_both_sides_are_no_reason_to_lose_one(self, index, tmp_path, judged):
        theirs = tmp_path / "usb"
        ours, other = judged(index.folder), judged(theirs)
        amend(ours, [{"input": "note", "text": "good", "by": "eve"}], 1)
        amend(other, [{"input": "note", "text": "bad", "by": "eve"}], 1)
        before = ours.read_bytes()
        index.refresh()
        (found,) = import_files(index, [other])
        assert found.what == REFUSED
        assert "the one that is here is kept" in found.reason
        assert ours.read_bytes() == before

    def test_what_nobody_vouches_for_takes_no_signed_exams_place(
        self, index, tmp_path, monkeypatch
    ):
        monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
        ours = record(index.folder, mode="exam", signed=True)
        other = tmp_path / "usb" / ours.name
        other.parent.mkdir()
        other.write_bytes(ours.read_bytes())
        note = {"input": "tlx", "values": [10, 20, 30, 40, 50, 60]}
        amend(other, [note], 1)
        signed = other.read_bytes()
        with monkeypatch.context() as elsewhere:  # where no key of this station is known
            elsewhere.setenv("ROS_HOME", str(tmp_path / "other home"))
            other.write_bytes(ours.read_bytes())
            amend(other, [note], 1)
        before = ours.read_bytes()
        index.refresh()
        (found,) = import_files(index, [other])
        assert found.what == REFUSED
        assert found.reason == (
            f"{other}: its signature is: no signature; that of {ours.name} is valid, so the one "
            "that is here is kept"
        )
        assert ours.read_bytes() == before
        assert index.trials()[0].in_exam
        other.write_bytes(signed)
        assert import_files(index, [other])[0].what == NEWER
        assert index.trials()[0].in_exam

    def test_who_amends_a_recording_waits_while_it_is_taken_in(
        self, index, tmp_path, judged, monkeypatch
    ):
        index.folder.mkdir()
        folder = os.open(index.folder, os.O_RDONLY)

        def copy(*_):
            with pytest.raises(BlockingIOError):
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)

        monkeypatch.setattr(importing, "_copy", copy)
        assert import_files(index, [judged(tmp_path / "usb")])[0].what == NEW
        os.close(folder)

    def test_another_trial_of_the_same_name_is_refused(self, index, tmp_path):
        ours = record(index.folder)
        other = record(tmp_path / "usb", stamp=OTHER, made=sheet(ours.stem, log={"sha256": "x"}))
        index.refresh()
        (found,) = import_files(index, [other])
        assert found.what == REFUSED
        assert f"another trial is called {ours.stem} here" in found.reason

    def test_what_is_judged_otherwise_is_refused_on_demand(self, index, tmp_path, judged):
        theirs = tmp_path / "usb"
        good = judged(theirs)
        assert import_files(index, [good], verify=True)[0].what == NEW
        forged = record(theirs, "bob")
        (found,) = import_files(index, [forged], verify=True)
        assert found.what == REFUSED
        assert "bob" in found.reason
        assert [each.name for each in index.people()] == ["ann"]


def test_a_file_whose_name_is_no_text_keeps_nobody_else_out(index):
    record(index.folder, "bob")
    os.close(os.open(os.fsencode(index.folder) + b"/\xff.mcap", os.O_CREAT))
    assert index.refresh() == []
    assert [person.name for person in index.people()] == ["bob"]
