"""The commands progress and people, as they are called."""

import csv
import io
import json
from pathlib import Path

import pytest
from recorded_trials import record

from telex_training.command_lines import people, progress
from telex_training.recording.amending import amend


@pytest.fixture
def run(tmp_path, capsys):
    folder = tmp_path / "recordings"
    record(folder)
    record(folder, "bob", times=[(30.0, True), (32.0, False)])

    def run(*arguments, of=progress, status=0):
        assert of.main(["--folder", str(folder), *arguments]) == status
        return capsys.readouterr()

    run.folder = folder
    return run


def test_people_and_what_they_did_are_listed(run):
    assert run("list").out == (
        "ann: 1 trial, 2026-03-01 to 2026-03-01\nbob: 1 trial, 2026-03-01 to 2026-03-01\n"
    )
    assert "drill, standard: 1 trial, 1 of 2 repetitions passed" in run("list", "ann").out


def test_an_unknown_person_is_told_with_the_known_ones(run):
    for command in (["list", "Ann"], ["csv", "--person", "Ann"], ["report", "ann", "Ann"]):
        assert run(*command, status=1).err == (
            "progress: person is 'Ann'; there are trials of: ann, bob\n"
        )


def test_the_index_is_made_anew(run):
    assert run("rebuild").out.endswith("progress.sqlite: 2 trials of 2 people\n")


def test_a_damaged_file_is_told_and_the_rest_is_done(run):
    (run.folder / "bad.mcap").write_text("nonsense")
    said = run("list")
    assert "progress: left out:" in said.err
    assert "bad.mcap" in said.err
    assert "ann: 1 trial" in said.out


def test_exports_stand_where_they_are_forgotten_with_the_person(run):
    for command, name in (
        (["csv"], "trials.csv"),
        (["csv", "--repetitions"], "repetitions.csv"),
        (["xapi"], "trials.jsonl"),
        (["report", "ann"], "ann.html"),
        (["report"], "class.html"),
    ):
        assert run(*command).out == f"{run.folder / 'exports' / name}\n"
    assert len(list((run.folder / "exports").iterdir())) == 5
    run("report", "bob")
    said = run("forget", "ann", "--pseudonymise", of=people)
    assert said.err == ""
    assert [path.name for path in (run.folder / "exports").iterdir()] == ["bob.html"]
    assert run("list").out.startswith("bob: 1 trial")
    assert "ann" not in run("csv", "-o", "-").out


def test_each_person_has_a_report_whatever_the_letters_of_the_name(run):
    names = ("李雷", "韩梅梅", "nobody", "Zoë", "Zo")
    for second, name in enumerate(names):
        record(run.folder, name, stamp=f"2026-03-01_10150{second}")
    made = [Path(run("report", name).out.rstrip()) for name in names]
    assert len(set(made)) == len(names)
    assert [made[2].name, made[4].name] == ["nobody.html", "Zo.html"]
    for name, path in zip(names, made):
        assert f"<h1>{name}</h1>" in path.read_text()
    said = run("forget", "李雷", "--remove", of=people)
    assert f"export removed: {made[0]}\n" in said.out
    assert [path.exists() for path in made] == [False, True, True, True, True]


def test_an_export_that_cannot_be_written_leaves_the_one_before(run, monkeypatch):
    run("csv")
    before = (run.folder / "exports" / "trials.csv").read_bytes()
    monkeypatch.setattr(progress, "trials_csv", lambda _: "all but the end \ud800")
    with pytest.raises(UnicodeEncodeError):
        run("csv")
    assert [path.name for path in (run.folder / "exports").iterdir()] == ["trials.csv"]
    assert (run.folder / "exports" / "trials.csv").read_bytes() == before


def test_a_table_has_one_end_of_line(run):
    run("csv")
    content = (run.folder / "exports" / "trials.csv").read_bytes()
    assert content.count(b"\r\n") == 3
    assert b"\r\r" not in content


def test_marks_and_workloads_stand_in_table_and_reports(run):
    marks = [{"verdict": "failed", "reason": "<too> fast", "by": "eve", "time": 1.0}]
    path = record(run.folder, "ida", marks=marks)
    amend(path, [{"input": "tlx", "values": [10, 20, 30, 40, 50, 60]}], 1)
    (row,) = csv.DictReader(io.StringIO(run("csv", "--person", "ida", "-o", "-").out))
    assert [row[f"mark{each}"] for each in ("", "_reason", "_by")] == [
        "failed",
        "<too> fast",
        "eve",
    ]
    assert (row["workload"], row["workload_frustration"]) == ("35.00", "60.0")
    (other,) = csv.DictReader(io.StringIO(run("csv", "--person", "bob", "-o", "-").out))
    assert (other["mark"], other["workload"], other["workload_mental"]) == ("", "", "")
    report = run("report", "ida", "-o", "-").out
    assert "failed: &lt;too&gt; fast" in report
    assert "35 (n = 1)" in report
    assert "35 (n = 1)" in run("report", "-o", "-").out


def test_statements_go_to_the_standard_output_on_demand(run):
    lines = run("xapi", "-o", "-", "--person", "bob", "--base", "https://x.example/").out
    (made,) = [json.loads(line) for line in lines.splitlines()]
    assert made["actor"]["account"] == {"homePage": "https://x.example", "name": "bob"}
    assert "an address is needed" in run("xapi", "--base", "school", status=1).err


def test_two_groups_are_compared(run, tmp_path):
    command = ["compare", "--group", "A", "ann", "--group", "B", "bob", "--exercise", "drill"]
    said = run(*command, "-o", str(tmp_path / "two.html")).out
    assert "A: median 22.5 s, n = 1 person, 2 repetitions" in said
    assert "Fisher's exact test, two-sided: p = 1 (n = 1 and 1)" in said
    assert "<svg" in (tmp_path / "two.html").read_text()
    assert run(*command, "--setting", "x", status=1).err.startswith("progress: setting is 'x'")


def test_recordings_of_another_machine_are_taken_in(run, tmp_path):
    other = record(tmp_path / "usb", "eve")
    assert run("import", str(tmp_path / "usb")).out == f"{other}: new\n"
    assert run("import", str(other)).out == f"{other}: known\n"
    assert "eve: 1 trial" in run("list").out
    (tmp_path / "empty").mkdir()
    assert "there is no recording" in run("import", str(tmp_path / "empty"), status=1).err


def test_a_folder_that_is_not_there_is_not_made(tmp_path, capsys):
    missing = tmp_path / "none"
    for command in (progress, people):
        assert command.main(["--folder", str(missing), "list"]) == 1
        assert f"{missing}: there is no such folder" in capsys.readouterr().err
    assert not missing.exists()


def test_people_are_listed_forgotten_and_expire(run):
    assert run("list", of=people).out == "ann: 1 trial\nbob: 1 trial\n"
    assert "name is 'Bob'" in run("forget", "Bob", "--remove", of=people, status=1).err
    assert run("forget", "bob", "--remove", of=people).out.startswith("removed: ")
    assert run("expire", "--days", "1", of=people).out.startswith("removed: ")
    assert run("list").out == f"{run.folder}: no trials\n"


@pytest.mark.parametrize("days", ["0", "-3", "nan", "inf", "soon"])
def test_days_are_a_number_above_0(run, days, capsys):
    with pytest.raises(SystemExit):
        people.main(["expire", "--days", days])
    assert f"'{days}'; a number of days above 0 is needed" in capsys.readouterr().err
