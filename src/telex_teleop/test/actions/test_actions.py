"""The vocabulary of actions, and that page, gamepad and documents say nothing else."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError, read_struct
from telex_teleop.actions.grammar import (
    TERMINAL_ONLY,
    Command,
    Jog,
    Lamps,
    Preset,
    ToPose,
    as_json,
)
from telex_teleop.actions.keys import page_key
from telex_teleop.actions.vocabulary import MODES, Vocabulary
from telex_teleop.files import shipped_file
from telex_teleop.joy.maps import JoyMap
from telex_teleop.joy.teleop_node import JoyTeleopSettings
from telex_teleop.keyboard.map import KeyboardSettings
from telex_teleop.motion.speed import STEP

PACKAGE = Path(__file__).resolve().parents[2]
CONSOLE = PACKAGE / "console"
DESCRIPTION = PACKAGE.parent / "telex_description" / "config"


@pytest.fixture(scope="module")
def shipped():
    return Vocabulary.read()


def kinds(vocabulary, kind):
    return [each.action for each in vocabulary.actions if isinstance(each.action, kind)]


class TestShippedFile:
    def test_every_command_stands_in_it(self, shipped):
        assert set(kinds(shipped, Command)) == set(Command)

    def test_names_what_the_robot_has(self, shipped):
        robot = {
            node: yaml.safe_load((PACKAGE / "config" / f"{node}_teleop.yaml").read_text())["joints"]
            for node in ("arm", "gripper", "flipper")
        }
        robot["gripper"].append("gripper")
        for jog in kinds(shipped, Jog):
            assert set(jog.joints) <= set(robot[jog.node])
        poses = yaml.safe_load((DESCRIPTION / "poses.yaml").read_text())["poses"]
        assert {pose.name for pose in kinds(shipped, ToPose)} == set(poses)
        lamps = yaml.safe_load((DESCRIPTION / "lamps.yaml").read_text())["lamps"]
        assert {name for each in kinds(shipped, Lamps) for name in each.names} == set(lamps)

    def test_layouts_name_roles_that_the_robots_cameras_have(self, shipped):
        cameras = yaml.safe_load((DESCRIPTION / "cameras.yaml").read_text())["cameras"]
        for layout in shipped.layouts.values():
            assert {*layout.first, *layout.second} <= {each["role"] for each in cameras.values()}

    def test_presets_are_in_the_order_in_which_the_robot_announces_them(self, shipped):
        presets = yaml.safe_load((PACKAGE / "config" / "flipper_presets.yaml").read_text())
        announced = [preset["name"] for preset in presets["presets"]]
        assert [preset.name for preset in kinds(shipped, Preset)] == announced

    def test_one_speed_step_for_all(self, shipped):
        keyboard = KeyboardSettings.read({}, shipped, "f")
        steps = {keyboard.speed_step, JoyTeleopSettings().speed_step}
        assert steps == {STEP} == {shipped.as_json()["speed_step"]}
        assert "speed_step" not in yaml.safe_load(
            (PACKAGE / "config" / "keyboard_teleop.yaml").read_text()
        )


BASE = {
    "modes": dict.fromkeys(MODES, ""),
    "groups": [
        {
            "title": "all",
            "actions": {
                "estop": {"does": "e-stop", "key": "escape"},
                "stop": {"does": "stop", "key": "space"},
            },
        }
    ],
}


def with_group(**group):
    return {**BASE, "groups": [*BASE["groups"], {"title": "more", **group}]}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({**BASE, "groups": []}, "groups: no action with a key does 'e-stop'"),
        ({**BASE, "modes": {"JOINT": ""}}, "modes are JOINT; they must be DRIVE, JOINT"),
        ({**BASE, "layouts": {}}, "layouts have the modes none; each of DRIVE, JOINT, CARTESIAN"),
        (
            {**BASE, "layouts": {"A": {"modes": list(MODES)}, "B": {"modes": ["DRIVE"]}}},
            "layouts have the modes CAMERA, CARTESIAN, DRIVE, DRIVE, JOINT; each of",
        ),
        (with_group(actions={"a": {"does": "jump"}}), "groups.1./actions/a: does is 'jump'; it"),
        (with_group(actions={"a": {"does": "zoom +", "key": "ctrl+r"}}), "key is 'ctrl.r'; it"),
        (with_group(actions={"a": {"does": "zoom +", "key": "W"}}), "key is 'W'; it must be"),
        (with_group(actions={}, modes=["ARM"]), "modes has 'ARM'; known are DRIVE"),
        (with_group(actions={"a": {"does": "tool x +"}}), "actions/a moves the tool, and modes"),
        (with_group(actions={"stop": {"does": "zoom +"}}), "two actions are called 'stop'"),
        (
            with_group(actions={"a": {"does": "zoom +", "key": "space"}}, modes=["JOINT"]),
            "Space is the key of stop and of a in JOINT",
        ),
        (
            with_group(actions={"a": {"does": "zoom +", "terminal": ["space"]}}),
            "space is the key of stop and of a in DRIVE",
        ),
    ],
)
def test_a_wrong_file_is_refused(content, says):
    with pytest.raises(ConfigError, match=says):
        read_struct(Vocabulary, content)


def test_words_and_modes_that_are_not_said():
    entry = {"does": "arm  forearm_joint  +", "key": "n", "terminal": ["f2"]}
    actions = {"fore_arm:left": entry, "view": {"does": "next camera", "key": "8"}}
    *_, arm, view = read_struct(Vocabulary, with_group(actions=actions)).actions
    assert (arm.title, arm.label, arm.row) == ("fore arm left", "left", "fore arm")
    assert arm.action == Jog("arm", ("forearm_joint",), 1)
    assert (arm.modes, arm.typed) == (MODES, ("n", "f2"))
    assert (view.title, view.label, view.typed, view.codes) == ("view", "view", (), ("Digit8",))


@pytest.mark.parametrize(
    ("key", "code", "cap"),
    [
        ("w", "KeyW", "W"),
        ("0", "Digit0", "0"),
        ("\\", "Backslash", "\\"),
        ("up", "ArrowUp", "↑"),
        ("f2", "F2", "F2"),
    ],
)
def test_keys_of_a_browser(key, code, cap):
    assert page_key(key) == (code, cap)


@pytest.mark.parametrize("key", ["W", "ä", "f5", "f11", "ctrl+c", "ab", "+", "²"])
def test_keys_that_a_page_cannot_have(key):
    with pytest.raises(ValueError):
        page_key(key)


class TestPage:
    def test_carries_out_every_command(self, shipped):
        main = (CONSOLE / "js" / "main.js").read_text()
        begin = main.index("_makeCommands() {\n    return")
        commands = main[begin : main.index("// ---- what is held")]
        carried_out = set(re.findall(r'^ {6}"?([a-z -]+?)"?: \(\) =>', commands, re.MULTILINE))
        aids = (CONSOLE / "js" / "aids" / "switches.js").read_text()
        table = aids[aids.index("const AIDS = {") : aids.index("};")]
        carried_out |= set(re.findall(r'^  "?([a-z ]+?)"?: \{', table, re.MULTILINE))
        assert carried_out == {c.value for c in Command if c not in TERMINAL_ONLY}

    def test_names_only_what_there_is(self, shipped):
        names = {each.name for each in shipped.actions}
        page = (CONSOLE / "index.html").read_text()
        bound = re.findall(r'data-(?:binding|command)="([^"]+)"', page)
        assert len(bound) > 20
        assert set(bound) <= names
        modes = " ".join(re.findall(r'data-modes?="([^"]+)"', page)).split()
        assert set(modes) == set(MODES)

    def test_has_no_keys_of_its_own(self, shipped):
        codes = {code for each in shipped.actions for code in each.codes}
        # the emergency stop must have its key whatever else is missing; the cap of ? is no layout's
        codes -= {"Escape", "Slash"}
        for script in (CONSOLE / "js").glob("*.js"):
            said = set(re.findall(r'"(\w+)"', script.read_text()))
            assert not said & codes, script.name
        page = (CONSOLE / "index.html").read_text()
        assert not re.search(r"<kbd[^>]*>[^<]", page)


NAMES = """
import { Vocabulary } from %s;
import { readFileSync } from "node:fs";
const { told, wanted, presets } = JSON.parse(readFileSync(0));
const vocabulary = new Vocabulary(told);
console.log(JSON.stringify(wanted.map((does) => vocabulary.nameOf(does, presets))));
"""


@pytest.mark.skipif(not shutil.which("node"), reason="needs node")
def test_the_page_has_a_name_for_all_that_the_shipped_pad_does(shipped):
    actions = JoyMap.read(shipped_file("joy/twin_stick.yaml")).actions
    script = NAMES % json.dumps(str(CONSOLE / "js" / "vocabulary.js"))
    told = subprocess.run(
        ["node", "--input-type=module", "--eval", script],
        input=json.dumps(
            {
                "told": shipped.as_json(),
                "wanted": [as_json(action) for action in actions],
                "presets": [preset.name for preset in kinds(shipped, Preset)],
            }
        ),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=60.0,
    )
    by_name = {each.name: each.action for each in shipped.actions}
    assert [by_name.get(name) for name in json.loads(told.stdout)] == list(actions)
