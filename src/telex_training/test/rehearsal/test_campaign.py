"""Campaigns of rehearsed trials: their folder, their summary, the command."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, Optional

import pytest

from telex_control.common.file_catalog import package_file
from telex_training.command_lines import rehearse
from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.recording.reader import read_recording
from telex_training.recording.trial_file import trial_of
from telex_training.rehearsal import jobs
from telex_training.rehearsal.jobs import Job, OperatorError, Rehearsed, find_operator
from telex_training.rehearsal.outcomes import change, provisional, run_of, summarised, worst
from telex_training.rehearsal.store import About, Store, StoreError

pytestmark = pytest.mark.slow

MINE = """
scene: room.yaml
description: Drive a metre.
steps: [{name: a metre, until: {moved: {what: robot, distance: 1}}}]
"""
ABOUT = About("slalom", "a" * 64, "scripted", "b" * 64)


def outcome(
    seconds: Optional[float] = 40.0,
    verdict: str = "passed",
    fault: Optional[str] = None,
    gave_up: str = "",
    time: Optional[float] = None,
) -> Rehearsed:
    """An outcome, with no more of a sheet than is read."""
    repetition = {
        "completed": seconds is not None,
        "seconds": seconds or 0.0,
        "penalty": 5.0,
        "fault": fault,
    }
    metrics = [
        {"name": "time", "over": "median", "value": time or seconds, "pass": 50, "within": True},
        {"name": "rate", "over": None, "value": 1.0, "pass": None, "within": None},
    ]
    if time is not None and time > 50:
        metrics[0]["within"] = False
    sheet = {"verdict": verdict, "repetitions": [repetition], "metrics": metrics}
    return Rehearsed(json.dumps(sheet), gave_up)


class TestStore:
    def test_what_is_put_is_found_again(self, tmp_path: Path) -> None:
        store = Store.begin(tmp_path / "new" / "folder", ABOUT)
        assert store.get("cones_3", "perfect", 7) is None
        store.put("cones_3", "perfect", 7, outcome(gave_up="tired"))
        store.put("cones_3", "perfect", 10, outcome())
        again = Store.begin(tmp_path / "new" / "folder", ABOUT)
        found = again.get("cones_3", "perfect", 7)
        assert found is not None
        assert found.gave_up == "tired"
        assert json.loads(found.sheet) == json.loads(outcome().sheet)
        assert [(s, line, seed) for s, line, seed, _ in again.all()] == [
            ("cones_3", "perfect", 7),
            ("cones_3", "perfect", 10),
        ]

    @pytest.mark.parametrize(
        ("other", "why"),
        [
            (About("gap", "a" * 64, "scripted", "b" * 64), r"another exercise \(slalom, not gap\)"),
            (
                About("slalom", "c" * 64, "scripted", "b" * 64),
                "another sha256 .aaaaaaaaaaaa, not c",
            ),
            (About("slalom", "a" * 64, "m:f", "b" * 64), r"another operator \(scripted, not m:f\)"),
            (About("slalom", "a" * 64, "scripted", "d" * 64), "another software"),
        ],
    )
    def test_outcomes_of_different_things_are_not_mixed(
        self, tmp_path: Path, other: About, why: str
    ) -> None:
        Store.begin(tmp_path, ABOUT)
        with pytest.raises(StoreError, match=why):
            Store.begin(tmp_path, other)

    def test_somebody_elses_folder_is_left_alone(self, tmp_path: Path) -> None:
        (tmp_path / "thesis.txt").write_text("years of work")
        with pytest.raises(StoreError, match="neither empty nor of a campaign"):
            Store.begin(tmp_path, ABOUT)
        assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]

    @pytest.mark.parametrize("text", ["", "[]", "{}", '{"sheet": 3, "gave_up": ""}', "[" * 10_000])
    def test_a_damaged_outcome_is_named(self, tmp_path: Path, text: str) -> None:
        store = Store.begin(tmp_path, ABOUT)
        store.put("a", "perfect", 1, outcome())
        (tmp_path / "a" / "perfect" / "1.json").write_text(text)
        with pytest.raises(StoreError, match=r"a/perfect/1\.json"):
            store.get("a", "perfect", 1)

    def test_a_folder_without_a_campaign_cannot_be_compared(self, tmp_path: Path) -> None:
        with pytest.raises(StoreError, match=r"campaign\.json"):
            Store.open(tmp_path / "nothing")
        (tmp_path / "campaign.json").write_text('{"format": 9}')
        with pytest.raises(StoreError, match="format 1"):
            Store.open(tmp_path)


class TestSummary:
    def runs(self, outcomes: Dict[int, Rehearsed]) -> Any:
        return [run_of(seed, each) for seed, each in outcomes.items()]

    def test_passes_have_bounds_and_metrics_a_spread(self) -> None:
        found = self.runs({n: outcome(40.0 + n) for n in range(1, 10)})
        found += self.runs({10: outcome(None, "failed", "tipped")})
        row = summarised(("hard", "perfect"), found)
        assert (row["trials"], row["passed"]) == (10, 9)
        # training.md: ten repetitions with one fault, at 80 % confidence
        assert row["at_least"] == pytest.approx(0.729, abs=5e-4)
        assert row["at_most"] == pytest.approx(0.978, abs=5e-4)
        assert row["metrics"] == {"time": [9, 41.8, 45.0, 48.2]}
        assert row["not_passed"] == {"10": "tipped"}
        assert provisional(row["metrics"], 2.0) == {"time": 96.0}

    def test_none_and_all_have_bounds_too(self) -> None:
        nothing = summarised(("a", "perfect"), self.runs({1: outcome(None, "failed")}))
        assert (nothing["at_least"], nothing["metrics"]["time"]) == (0.0, None)
        assert provisional(nothing["metrics"], 1.5) == {}
        everything = summarised(("a", "perfect"), self.runs({1: outcome()}))
        assert everything["at_most"] == 1.0

    def test_the_reason_is_the_first_that_holds(self) -> None:
        assert run_of(1, outcome()).why == ""
        lost = outcome(None, "failed", gave_up="no way")
        assert run_of(1, lost).why == "gave up: no way"
        assert run_of(1, outcome(60.0, "failed")).why == "not completed"
        assert run_of(1, outcome(60.0, "failed", time=60.0)).why == "time 60.0 (pass 50)"

    def test_the_worst_are_failures_then_the_slowest(self) -> None:
        found = self.runs(
            {1: outcome(40.0), 2: outcome(None, "failed"), 3: outcome(44.0), 4: outcome(42.0)}
        )
        assert [run.seed for run in worst(found, 3)] == [2, 3, 4]

    def test_a_change_is_told_by_seeds_and_groups(self) -> None:
        before = {n: outcome(40.0 + 0.1 * n) for n in range(1, 9)}
        after = {**before, 3: outcome(None, "failed"), 9: outcome(39.0)}
        told = change(("hard", "perfect"), before, after)
        assert (told.passed, told.trials) == ((8, 8), (8, 9))
        assert (told.differing, told.sheets) == ((3,), 1)
        assert told.chance == pytest.approx(1.0)
        assert told.seconds is not None
        assert change(("hard", "perfect"), before, before).sheets == 0


class TestOperators:
    def test_names_that_are_none_are_refused(self) -> None:
        assert find_operator("scripted", "slalom") is not None
        with pytest.raises(OperatorError, match="swimming has no scripted operator.*slalom"):
            find_operator("scripted", "swimming")
        with pytest.raises(OperatorError, match="'bob'; scripted or MODULE:FUNCTION"):
            find_operator("bob", "slalom")
        with pytest.raises(OperatorError, match="no_such_module_of_ours:f.*ModuleNotFoundError"):
            find_operator("no_such_module_of_ours:f", "slalom")
        with pytest.raises(OperatorError, match="it is no function"):
            find_operator("rehearsal_jobs:NO_FUNCTION", "slalom")

    def test_the_sources_digest_stays_and_leaves_tests_out(self) -> None:
        assert jobs.software_digest() == jobs.software_digest()

    def test_an_exercises_digest_is_the_same_wherever_the_checkout_stands(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        file = load_exercise(find_exercise("slalom"))
        digest = jobs.exercise_digest(file)
        described = jobs.robot_description
        monkeypatch.setattr(
            jobs,
            "robot_description",
            lambda variant: described(variant).replace("telex_description/", "elsewhere/", 1),
        )
        assert jobs.exercise_digest(file) == digest


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs are done in this process; each process of its own would take seconds to start."""

    def do(todo: Any, work: Any, workers: int, done: Any) -> None:
        for job in todo:
            try:
                result = work(job)
            except Exception as error:
                done(job, None, error)
            else:
                done(job, result, None)

    monkeypatch.setattr(rehearse, "do_here", do)


@pytest.mark.usefixtures("here")
class TestCommand:
    def run(self, folder: Path, *more: str, operator: str = "gives_up") -> int:
        return rehearse.main(
            [
                "slalom",
                *("--settings", "cones_3"),
                *("--operator", f"rehearsal_jobs:{operator}"),
                *("--out", str(folder), *more),
            ]
        )

    def test_a_campaign_goes_on_where_it_was(
        self, tmp_path: Path, capsys: pytest.CaptureFixture
    ) -> None:
        assert self.run(tmp_path, "--seeds", "1") == 0
        sheet = tmp_path / "cones_3" / "own" / "1.json"
        before, made = sheet.read_bytes(), sheet.stat().st_mtime_ns
        capsys.readouterr()
        assert self.run(tmp_path, "--seeds", "2", "--record", "1") == 0
        printed = capsys.readouterr()
        assert "1 of 2 trials are there already" in printed.err
        assert "0 of 2 passed" in printed.out
        assert "gave up: setting cones_3: no way through" in printed.out
        assert (sheet.read_bytes(), sheet.stat().st_mtime_ns) == (before, made)
        recording = tmp_path / "rehearsal_slalom_cones_3_own_1.mcap"
        assert trial_of(read_recording(recording))[0].seed == 1
        # The same trial in another folder is the same bytes.
        other = tmp_path / "other"
        more = ("--compare", str(tmp_path), "--record", "1", "--json")
        assert self.run(other, "--seeds", "1-1", *more) == 0
        printed = capsys.readouterr()
        assert json.loads(printed.out)["rows"][0]["trials"] == 1
        assert f"compared with {tmp_path}" in printed.err
        assert "own_1.mcap" in printed.err
        assert (other / "cones_3" / "own" / "1.json").read_bytes() == before

    def test_outcomes_of_an_operator_or_a_scene_as_it_was_are_not_kept(
        self,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture,
    ) -> None:
        operator, scene = tmp_path / "own_operator_of_test.py", tmp_path / "room.yaml"
        operator.write_text("def work(hand, brief):\n    hand.station.tick()\n")
        scene.write_text("objects: []\n")
        (tmp_path / "mine.yaml").write_text(MINE)
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.chdir(tmp_path)

        def again() -> int:
            own = ("--operator", "own_operator_of_test:work", "--out", "out", "--seeds", "1")
            return rehearse.main(["mine.yaml", *own])

        assert again() == 0
        assert again() == 0
        with operator.open("a") as file:
            file.write("# changed\n")
        assert again() == 2
        assert "out: it is of another software" in capsys.readouterr().err
        operator.write_text(operator.read_text().replace("# changed\n", ""))
        assert again() == 0
        scene.write_text("objects: [{name: post, type: box, position: [3, 0, 0.5]}]\n")
        assert again() == 2
        assert "out: it is of another sha256" in capsys.readouterr().err

    def test_an_operator_that_breaks_is_named_and_tried_again(
        self, tmp_path: Path, capsys: pytest.CaptureFixture
    ) -> None:
        assert self.run(tmp_path, "--seeds", "1", operator="breaks") == 1
        assert "seed 1: ZeroDivisionError: of the operator's own" in capsys.readouterr().err
        assert not (tmp_path / "cones_3").exists()

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (("--seeds", "0"), "N from 1"),
            (("--seeds", "5-2"), "1 <= A <= B"),
            (("--seeds", "9999999"), "at most 100000"),
            (("--seeds", "1-" + 30 * "9"), "at most 100000"),
            (("--workers", "0"), "a whole number from 1"),
            (("--factor", "nan"), "0.1 to 100"),
        ],
    )
    def test_bad_arguments_are_refused(
        self, tmp_path: Path, arguments: Any, said: str, capsys: pytest.CaptureFixture
    ) -> None:
        with pytest.raises(SystemExit):
            self.run(tmp_path / "x", *arguments)
        assert said in capsys.readouterr().err
        assert not (tmp_path / "x").exists()

    def test_unknown_names_are_refused(self, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
        assert rehearse.main(["swimming"]) == 2
        assert self.run(tmp_path, "--settings", "cones_99") == 2
        assert self.run(tmp_path, "--lines", "perfect,string") == 2
        said = capsys.readouterr().err
        for word in ("cones_99", "'string'; known are perfect"):
            assert word in said


def test_an_operator_of_the_working_folder_is_found(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("objects: []\n")
    (tmp_path / "mine.yaml").write_text(MINE)
    (tmp_path / "my_module.py").write_text("def mine(hand, brief):\n    hand.station.tick()\n")
    node = package_file("telex_training", "nodes", "rehearse")
    own = ("--operator", "my_module:mine", "--out", "out", "--seeds", "1")
    done = subprocess.run(
        [sys.executable, str(node), "mine.yaml", *own],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr.count("Error")) == (0, 0), done.stderr
    assert "0 of 1 passed" in done.stdout


def test_a_job_travels_as_plain_data() -> None:
    assert Job("p", "t", "s", 1).operator == "scripted"
