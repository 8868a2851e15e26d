"""The console's keys are those of the terminal, as far as both have them."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from telex_teleop.operating.actions import parse_action
from telex_teleop.web.joy_map import describe_action

PACKAGE = Path(__file__).resolve().parents[1]
CAPS = {
    "left": "←",
    "right": "→",
    "up": "↑",
    "down": "↓",
    "pageup": "PgUp",
    "pagedown": "PgDn",
    "insert": "Ins",
    "delete": "Del",
    "escape": "Esc",
}
SECOND_KEYS = ("+", "f1")
"""Of the terminal, for what has another key there already."""
SCRIPTS = ("robot", "pad_map")
NAMES = """
import { ACTIONS, COMMANDS } from %s;
import { nameOf } from %s;
import { readFileSync } from "node:fs";
const { actions, presets } = JSON.parse(readFileSync(0));
const NEXT = { next_mode: "mode" };
const known = { ...ACTIONS, ...COMMANDS };
console.log(JSON.stringify(actions.map((action) => {
  const name = nameOf(action, presets);
  return known[NEXT[name] ?? name]?.cap ?? null;
})));
"""


def caps_in_the_page(actions):
    """Caps of the keys that the page has for actions; None where it has none."""
    listed = yaml.safe_load((PACKAGE / "config" / "flipper_presets.yaml").read_text())
    presets = [preset["name"] for preset in listed["presets"]]
    scripts = [json.dumps(str(PACKAGE / "console" / "js" / f"{name}.js")) for name in SCRIPTS]
    told = subprocess.run(
        ["node", "--input-type=module", "--eval", NAMES % tuple(scripts)],
        input=json.dumps({"actions": actions, "presets": presets}),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=60.0,
    )
    return json.loads(told.stdout)


@pytest.mark.skipif(not shutil.which("node"), reason="needs node")
@pytest.mark.parametrize("table", ["keys", "cartesian_keys"])
def test_each_key_does_the_same(table):
    config = yaml.safe_load((PACKAGE / "config" / "keyboard_teleop.yaml").read_text())
    keys = {key: text for key, text in config[table].items() if text != "nothing"}
    actions = [parse_action(text) for text in keys.values()]
    caps = caps_in_the_page([describe_action(action) for action in actions])
    compared = 0
    for key, action, cap in zip(keys, actions, caps):
        if cap is None or key in SECOND_KEYS:
            continue
        compared += 1
        assert cap.lower() == CAPS.get(key, key).lower(), f"{key}: {action}"
    assert compared >= {"keys": 45, "cartesian_keys": 12}[table]
