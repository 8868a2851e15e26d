"""Forgetting people: nothing of a name is left, and nothing else is lost."""

import fcntl
import json
import os
import re

import pytest
from recorded_trials import judged_trial, record, wall_of
from telex_msgs.msg import BridgeClient, BridgeClients, InstructorAction
from training_truth import serialized

from telex_training.judging.entries import Entry
from telex_training.progress.exports import trials_csv
from telex_training.progress.index import ProgressIndex
from telex_training.progress.people import EXPORTS, PeopleError, expire, forget, new_pseudonym
from telex_training.progress.trial_facts import read_trial
from telex_training.recording import pseudonym
from telex_training.recording.amending import amend
from telex_training.recording.pseudonym import MARK, operator_of, rename_person
from telex_training.recording.reader import read_recording
from telex_training.recording.writer import RecordingError


@pytest.fixture
def index(tmp_path):
    return ProgressIndex(tmp_path / "recordings")


def everything(path):
    """All that can be read of a recording, with its name."""
    recording = read_recording(path)
    parts = [path.name.encode(), *(each.data for each in recording.attachments.values())]
    return b"\n".join([*parts, *(entry.data for entry in recording.entries)])


class TestRename:
    def test_the_name_is_gone_and_the_sheet_fits_the_new_log(self, tmp_path, judged):
        path = judged(tmp_path)
        before = read_trial(path)
        renamed = rename_person(path, "ann", "person-1")
        assert renamed.own
        assert renamed.left == []
        assert not path.exists()
        assert renamed.path.name == "2026-03-01_101500_person-1_drill.mcap"
        assert not re.search(rb"\bann\b", everything(renamed.path))
        recording = read_recording(renamed.path)
        assert recording.whole
        assert MARK in recording.attachments
        after = read_trial(renamed.path, verify=True)
        assert after.operator == "person-1"
        assert after.trial == renamed.path.stem
        assert after.log != before.log
        assert (after.verdict, after.repetitions, after.metrics, after.began_ns) == (
            before.verdict,
            before.repetitions,
            before.metrics,
            before.began_ns,
        )

    def test_notes_are_kept_but_for_the_name(self, tmp_path, judged):
        renamed = rename_person(judged(tmp_path), "ann", "person-1")
        sheet = json.loads(read_recording(renamed.path).attachments["sheet.json"].data)
        assert sheet["notes"][0]["by"] == "person-1"
        assert sheet["notes"][0]["text"] == "person-1 was faster than anns brother"
        assert sheet["marks"][0]["reason"] == "well done, person-1!"
        assert sheet["marks"][0]["by"] == "instructor"

    def test_the_path_of_the_exercise_goes_with_it(self, tmp_path, judged):
        renamed = rename_person(judged(tmp_path), "ann", "person-1")
        trial = json.loads(read_recording(renamed.path).attachments["trial.json"].data)
        assert trial["exercise"] == "drill.yaml"

    def test_somebody_at_the_bridge_is_renamed_in_others_recordings(self, tmp_path, judged):
        path = judged(tmp_path)
        before = read_trial(path)
        assert b"192.0.2.7" in everything(path)
        renamed = rename_person(path, "bob", "person-2")
        assert (renamed.own, renamed.path) == (False, path)
        assert b"bob" not in everything(path)
        after = read_trial(path, verify=True)
        assert (after.operator, after.trial, after.verdict) == ("ann", path.stem, before.verdict)

    @pytest.mark.parametrize(
        "name", ["bob", "Jörg O'Brien", "moved", "1", "post", "name", 30 * "ab"]
    )
    def test_an_instructor_who_changed_the_scene_is_renamed_and_the_sheet_fits(
        self, tmp_path, name
    ):
        place = {"position": {"x": 1.0, "y": 2.0, "z": 0.0}}
        moved = {"name": "post", "pose": place}
        put_in = {"object": f"what is of {name}", "pose": place}
        path = judged_trial(
            tmp_path,
            others=[name],
            actions=[
                InstructorAction(by=name, service="sim/move", request=json.dumps(moved)),
                InstructorAction(by=name, service="sim/spawn", request=json.dumps(put_in)),
            ],
        )
        assert rename_person(path, name, "person-2").path == path
        sheet = json.loads(read_recording(path).attachments["sheet.json"].data)
        assert sheet["invalid_because"] == ["person-2 has changed the scene"]
        assert {note["by"] for note in sheet["notes"]} == {"ann", "person-2"}
        assert sheet["notes"][1]["text"] == "put in: what is of person-2"
        read_trial(path, verify=True)
        if name == "bob":
            assert b"bob" not in everything(path)

    def test_an_instructor_of_a_further_robot_is_renamed(self, tmp_path, judged):
        action = InstructorAction(by="bob", service="sim/delete", request="cut")
        clients = BridgeClients(clients=[BridgeClient(id="1", name="bob")])
        entries = read_recording(judged(tmp_path / "a")).entries
        for channel, message in (
            ("second/bridge/actions", action),
            ("second/bridge/clients", clients),
        ):
            number = entries[-1].number + 1
            entries.append(Entry(number, 1.0, channel, message._type, serialized(message)))
        path = record(tmp_path / "b", entries=entries)
        assert rename_person(path, "bob", "person-2").left == []
        assert b"bob" not in everything(path)

    def test_a_recording_without_the_name_is_left_alone(self, tmp_path, judged):
        path = judged(tmp_path)
        before = path.read_bytes()
        assert rename_person(path, "eve", "person-3") is None
        assert path.read_bytes() == before

    @pytest.mark.parametrize("name", ["goal", "1", "drill", "Jörg O'Brien", "there", "true"])
    def test_a_name_that_is_a_word_of_the_exercise_changes_no_verdict(self, tmp_path, name):
        path = judged_trial(tmp_path, name)
        before = read_trial(path)
        renamed = rename_person(path, name, "person-4")
        after = read_trial(renamed.path, verify=True)
        assert (after.verdict, after.repetitions) == (before.verdict, before.repetitions)
        assert after.exercise == "drill"

    def test_a_recording_that_was_cut_off_is_renamed_as_far_as_it_goes(self, tmp_path, judged):
        path = judged(tmp_path)
        path.write_bytes(path.read_bytes()[:-2000])
        os.utime(path, (0, 0))
        assert operator_of(path) == "ann"
        renamed = rename_person(path, "ann", "person-1")
        assert operator_of(renamed.path) == "person-1"
        assert not re.search(rb"\bann\b", everything(renamed.path))

    def test_a_recording_that_is_being_written_is_left_alone(self, tmp_path, judged):
        path = judged(tmp_path)
        path.write_bytes(path.read_bytes()[:-2000])
        before = path.stat().st_ino, path.read_bytes()
        for name in ("ann", "bob"):
            with pytest.raises(RecordingError, match="this trial runs"):
                rename_person(path, name, "person-1")
        assert (path.stat().st_ino, path.read_bytes()) == before

    def test_who_amends_a_recording_waits_meanwhile(self, tmp_path, judged, monkeypatch):
        folder = os.open(tmp_path, os.O_RDONLY)

        def rename(*_):
            with pytest.raises(BlockingIOError):
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)

        monkeypatch.setattr(pseudonym, "_rename", rename)
        rename_person(judged(tmp_path), "bob", "person-2")
        os.close(folder)

    def test_where_a_name_is_still_written_is_told(self, tmp_path, judged):
        text = (
            "# by ann\n"
            + read_recording(judged(tmp_path / "a")).attachments["exercise.yaml"].data.decode()
        )
        path = record(
            tmp_path / "b", entries=read_recording(judged(tmp_path / "a")).entries, text=text
        )
        assert rename_person(path, "ann", "person-1").left == ["exercise.yaml"]


class TestForget:
    def test_removing_takes_recordings_exports_and_rows(self, index, judged):
        path = judged(index.folder)
        record(index.folder, "eve")
        (index.folder / f"{path.stem}.csv").write_text("of the trial")
        (index.folder / f".{path.name}.repaired").write_text("a draft")
        exports = index.folder / EXPORTS
        exports.mkdir()
        (exports / "class.html").write_text("<td>ann</td>")
        (exports / "eve.html").write_text("<h1>eve</h1>")
        index.refresh()
        done = forget(index, "ann")
        assert done.removed == [path]
        assert done.left == []
        assert sorted(each.name for each in done.exports) == sorted(
            [f"{path.stem}.csv", f".{path.name}.repaired", "class.html"]
        )
        assert [each.name for each in index.people()] == ["eve"]
        assert (exports / "eve.html").exists()
        assert b"ann" not in index.path.read_bytes()

    def test_a_pseudonym_keeps_progress_together(self, index, judged):
        judged(index.folder)
        record(index.folder, stamp="2026-03-05_080000", mode="exam")
        index.refresh()
        pseudonym = new_pseudonym()
        done = forget(index, "ann", pseudonym)
        assert len(done.renamed) == 2
        assert [(each.name, each.trials) for each in index.people()] == [(pseudonym, 2)]
        assert not any(b"ann" in path.read_bytes() for path in index.folder.glob("*.sqlite*"))

    def test_marks_and_notes_of_others_forget_the_name_in_files_index_and_exports(self, index):
        path = judged_trial(index.folder, "eve")
        said = {"input": "mark", "verdict": "failed", "reason": "slower than ann", "by": "ann"}
        noted = {"input": "note", "text": "ann helped", "by": "instructor"}
        rated = {"input": "tlx", "values": [10, 20, 30, 40, 50, 60]}
        amend(path, [said, noted, rated], 1)
        record(index.folder, "ann", stamp="2026-03-05_080000")
        index.refresh()
        assert index.trials("eve")[0].marks[-1].reason == "slower than ann"
        export = index.folder / EXPORTS / "trials.csv"
        export.parent.mkdir()
        export.write_text(trials_csv(index.trials("eve")))
        assert "slower than ann" in export.read_text()
        done = forget(index, "ann")
        assert (done.mentioned, done.exports) == ([path], [export])
        assert not re.search(rb"\bann\b", everything(path))
        assert not re.search(rb"\bann\b", index.path.read_bytes())
        (trial,) = index.trials()
        assert re.fullmatch("slower than person-[0-9a-f]{8}", trial.marks[-1].reason)
        assert trial.raw_workload == 35.0
        assert trial == read_trial(path, verify=True)

    @pytest.mark.parametrize("pseudonym", ["", "person-1"])
    def test_names_that_are_spelt_alike_are_told_apart(self, index, pseudonym):
        record(index.folder, "李雷")
        record(index.folder, "韩梅梅", stamp="2026-03-05_080000")
        record(index.folder, "nobody", stamp="2026-03-06_080000")
        exports = index.folder / EXPORTS
        exports.mkdir()
        index.refresh()
        for name in ("李雷", "韩梅梅", "nobody"):
            (exports / f"{name}.csv").write_text(trials_csv(index.trials(name)))
        assert forget(index, "李雷", pseudonym).exports == [exports / "李雷.csv"]
        # Hers has it in the name of her trial; it can be made anew.
        forgotten = forget(index, "nobody", pseudonym).exports
        assert sorted(forgotten) == sorted(exports / f"{name}.csv" for name in ("nobody", "韩梅梅"))

    def test_others_keep_their_trials(self, index, judged):
        path = judged(index.folder)
        done = forget(index, "bob")
        assert (done.removed, done.mentioned) == ([], [path])
        assert [each.name for each in index.people()] == ["ann"]

    @pytest.mark.parametrize("name", ["Ann", "nobody at all"])
    def test_an_unknown_name_is_refused_with_the_known_ones(self, index, name):
        record(index.folder)
        with pytest.raises(PeopleError, match=f"name is '{name}'; .* trials of: ann"):
            forget(index, name)
        assert len(index.trials()) == 1

    def test_trials_under_no_name_are_nobodys(self, index):
        record(index.folder, "")
        with pytest.raises(PeopleError, match="belong to nobody"):
            forget(index, "")

    def test_a_trial_that_runs_is_left_alone(self, index, judged):
        path = judged(index.folder)
        path.write_bytes(path.read_bytes()[:-2000])
        with pytest.raises(PeopleError, match="this trial runs"):
            forget(index, "ann")
        os.utime(path, (0, 0))
        assert forget(index, "ann").removed == [path]

    def test_nothing_is_touched_while_the_trial_of_somebody_else_runs(self, index, judged):
        own = record(index.folder, "bob", stamp="2026-03-05_080000")
        running = judged(index.folder)  # ann's, with bob at the bridge
        running.write_bytes(running.read_bytes()[:-2000])
        before = running.stat().st_ino
        with pytest.raises(PeopleError, match=f"{running.name}: this trial runs"):
            forget(index, "bob")
        assert own.exists()
        assert running.stat().st_ino == before
        assert b"bob" in everything(running)

    def test_a_file_that_cannot_be_searched_is_told(self, index):
        record(index.folder)
        (index.folder / "bad.mcap").write_text("nonsense")
        done = forget(index, "ann")
        assert len(done.removed) == 1
        assert len(done.left) == 1
        assert "bad.mcap" in done.left[0]


class TestExpire:
    def test_what_is_older_goes_by_the_trials_beginning(self, index):
        old, new = record(index.folder), record(index.folder, stamp="2026-03-05_101500")
        (index.folder / EXPORTS).mkdir()
        export = index.folder / EXPORTS / "class.html"
        export.write_text("")
        os.utime(export, (wall_of("2026-03-01_101500"),) * 2)
        now = wall_of("2026-03-06_101500")
        assert expire(index, 30.0, now) == []
        assert expire(index, 3.0, now) == [old, export]
        assert new.exists()
        assert len(index.trials()) == 1

    def test_a_damaged_file_goes_by_its_last_change(self, index):
        index.folder.mkdir()
        bad = index.folder / "bad.mcap"
        bad.write_text("nonsense")
        assert expire(index, 1.0) == []
        assert expire(index, 1.0, bad.stat().st_mtime + 2 * 86400.0) == [bad]
