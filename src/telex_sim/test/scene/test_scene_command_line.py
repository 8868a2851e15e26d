"""The command ``scene``."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

import pytest

from telex_control.common.params import parameter, required
from telex_sim.scene.command_line import main
from telex_sim.scene.library import object_types
from telex_sim.scene.library.object_type import ObjectType
from telex_sim.scene.type_texts import parameters, summary

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path, monkeypatch):
    # Longer than a line.
    path = tmp_path / f"scenes{10 * '-of-mine'}"
    path.mkdir()
    monkeypatch.setenv("TELEX_SCENE_PATH", str(path))
    (path / "good.yaml").write_text(
        "description: Two things to look at.\n"
        "lights: {lamps: [{position: [0, 0, 2]}]}\n"
        "objects:\n  - {type: crate, position: [2, 0, 0]}\n  - {type: valve, position: [3, 0, 0]}\n"
    )
    (path / "bad.yaml").write_text("objects: [{type: crate, mass: -1}]\n")
    return path


def test_check_says_ok_and_how_much_there_is(folder, capsys):
    assert main(["check", str(folder / "good.yaml"), "floor"]) == 0
    said = capsys.readouterr()
    assert f"{folder}/good.yaml: OK, 1 static and 1 movable objects, " in said.out
    assert "1 lamps" in said.out
    assert "floor.yaml: OK, 0 static and 0 movable objects\n" in said.out
    assert said.err == ""


def test_check_names_every_broken_file(folder, capsys):
    assert main(["check", "good", str(folder / "bad.yaml"), "/no/such.yaml"]) == 1
    said = capsys.readouterr()
    assert "good.yaml: OK" in said.out
    first, second = said.err.splitlines()
    assert first == f"{folder}/bad.yaml: objects[0] (crate): mass is -1.0; it must be above 0"
    assert second == "/no/such.yaml: there is no such file"


def test_check_puts_the_robot_there(folder, capsys):
    """What only the robot makes wrong: its name, its pose, what stands where it starts."""
    wrong = {
        "named": ("objects: [{type: cone, name: telex, position: [3, 0, 0]}]", "name is 'telex'"),
        "posed": ("start: {pose: redy}", "start/pose is 'redy'; there are: "),
        "blocked": (
            "objects: [{type: platform, name: brick, position: [0, 0, 0.05], length: 0.3}]",
            "mm deep in 'brick'",
        ),
    }
    for name, (text, _) in wrong.items():
        (folder / f"{name}.yaml").write_text(f"{text}\n")
    paths = [str(folder / f"{name}.yaml") for name in wrong]
    assert main(["check", *paths]) == 1
    said = capsys.readouterr()
    lines = said.err.splitlines()
    assert (said.out, len(lines)) == ("", len(wrong))
    for line, path, (_, reason) in zip(lines, paths, wrong.values()):
        assert line.startswith(f"{path}: ")
        assert reason in line
    assert main(["check", "--no-robot", *paths]) == 0
    assert main(["check", "--pose", "redy", "floor"]) == 1
    assert "pose is 'redy'; there are: " in capsys.readouterr().err
    assert main(["check", "--variant", "seven_axes", "floor"]) == 1
    assert "no variant 'seven_axes'" in capsys.readouterr().err


def test_list_shows_scenes_and_what_is_broken(folder, capsys):
    assert main(["list"]) == 1
    said = capsys.readouterr().out
    assert "good\n    Two things to look at.\n    1 static and 1 movable objects" in said
    # However long a path is, it stays in one piece.
    assert f"    {folder}/good.yaml\n" in said
    assert f"bad broken: {folder}/bad.yaml: objects[0]" in " ".join(said.split())
    assert "floor\n" in said


def test_types_lists_all_and_explains_one(capsys):
    assert main(["types"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(object_types())
    assert main(["types", "mesh"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("mesh: An OBJ or STL file.")
    assert "  mesh: required\n      str. Address: relative to the scene file" in said
    assert "  scale: [1, 1, 1]\n" in said
    assert main(["types", "dragon"]) == 1
    assert "there is no type 'dragon'; there are: " in capsys.readouterr().err


@dataclass(frozen=True)
class Inner:
    a: float = 1.0


@dataclass(frozen=True)
class Base(ObjectType):
    mass: float = parameter(2.5, "kg.")


@dataclass(frozen=True)
class Derived(Base):
    """Derived.

    And more of it.
    """

    wide: float = parameter(required, "Of the thing (m).")
    tags: Tuple[str, ...] = parameter(("a", "b"), "Names.")
    inner: Inner = parameter(Inner, "More.")


def test_texts_of_types_come_from_their_declarations():
    assert summary(Derived) == "Derived."
    assert parameters(Derived) == [
        ("mass", "2.5", "float. kg."),
        ("wide", "required", "float. Of the thing (m)."),
        ("tags", "[a, b]", "tuple of str. Names."),
        ("inner", "{a: 1}", "Inner. More."),
    ]


def test_it_runs_without_a_ros_master():
    script = Path(__file__).parents[2] / "nodes" / "scene"
    result = subprocess.run(
        [sys.executable, str(script), "check", "--no-robot", "floor"],
        env={**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"},
        check=False,
        capture_output=True,
        text=True,
    )
    said = [line for line in result.stderr.splitlines() if not line.startswith("pybullet build")]
    assert (result.returncode, said) == (0, [])
    assert result.stdout.endswith("floor.yaml: OK, 0 static and 0 movable objects\n")
