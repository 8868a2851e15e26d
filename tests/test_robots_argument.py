"""What `run.sh robots:=...` takes, and what it says of the rest."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[1] / "launch_scripts" / "robots.py"


def read(text, first="telex", variant="standard", folder=None):
    return subprocess.run(
        [sys.executable, str(SCRIPT), text, first, variant],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )


@pytest.mark.parametrize(
    ("given", "first", "others"),
    [
        (("1",), "telex=standard", ""),
        (("2",), "telex=standard", "telex_b=standard"),
        (("3", "ann", "carrier"), "ann=carrier", "ann_b=carrier,ann_c=carrier"),
        (("telex,telex_six_axis",), "telex=standard", "telex_six_axis=six_axis"),
        (("telex, six_axis",), "telex=standard", "telex_six_axis=six_axis"),
        (("left,right", "telex", "carrier"), "left=carrier", "right=carrier"),
        (("a=six_axis,b=six_axis",), "a=six_axis", "b=six_axis"),
    ],
)
def test_robots_are_named_by_number_name_or_variant(given, first, others):
    done = read(*given)
    name, variant = first.split("=")
    names = [name, *(each.split("=")[0] for each in others.split(",") if each)]
    assert done.stdout.splitlines() == [
        *(f"ns:={name}", f"variant:={variant}", f"others:={others}"),
        " ".join(names),
    ]
    assert (done.returncode, done.stderr) == (0, "")


def test_a_variant_may_be_a_file(tmp_path):
    (tmp_path / "mine.yaml").write_text("tool: probe\n")
    done = read("2", variant="mine.yaml", folder=tmp_path)
    assert f"others:=telex_b={tmp_path}/mine.yaml" in done.stdout
    assert "there is no file" in read("a=other.yaml,b", folder=tmp_path).stderr


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (("0",), "1 to 4 robots are possible"),
        (("-1",), "1 to 4 robots are possible"),
        (("99999999999",), "1 to 4 robots are possible"),
        (("a,b,c,d,e",), "it names 5 robots; at most 4"),
        (("",), "a number, or names with one comma"),
        (("a,,b",), "a number, or names with one comma"),
        (("a,a",), "'a' stands there twice"),
        (("six_axis,six_axis",), "'telex_six_axis' stands there twice"),
        (("1.5",), "'1.5' is no name of a robot"),
        (("nan,b",), None),
        (("a b,c",), "'a b' is no name of a robot"),
        (("a,true",), "'true' is no name of a robot"),
        (("a=seven_axis,b",), "'seven_axis' is no variant; there are standard, six_axis"),
        (("a=,b",), "'' is no variant"),
        (("a,telex",), "'telex' can only be the first"),
        (("2", "a/b"), "ns:=a/b must be a letter"),
        (("2", "telex", "seven_axis"), "'seven_axis' is no variant"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(given, why):
    done = read(*given)
    if why is None:  # a name like any other
        assert done.returncode == 0
        return
    assert done.returncode != 0
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"run.sh: robots:={given[0]}: ")
    assert why in line
    assert line.endswith("robots:=ann=standard,bob=six_axis")
