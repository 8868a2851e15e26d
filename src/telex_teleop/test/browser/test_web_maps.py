"""The actions and the gamepad's map as the browser gets them."""

from __future__ import annotations

import json

import aiohttp
import pytest
from aiohttp import web
from web_fakes import on_loop, served

from telex_control.common.params import ConfigError
from telex_teleop.actions.vocabulary import Vocabulary
from telex_teleop.web.map_documents import add_maps


async def nothing_known(_request):
    return None


async def fetch(name):
    app = web.Application()
    add_maps(app, actions="", joy_map="", ask=nothing_known)
    async with served(app) as url, aiohttp.request("GET", f"{url}/{name}") as reply:
        assert reply.status == 200
        assert reply.headers["Access-Control-Allow-Origin"] == "*"
        return await reply.json()


@on_loop
async def test_the_shipped_actions_are_served():
    told = await fetch("actions.json")
    assert told == json.loads(json.dumps(Vocabulary.read().as_json()))
    actions = {action.pop("name"): action for action in told["actions"]}
    assert actions["tool_x:ahead"] == {
        "does": {"kind": "tool", "axis": "x", "sign": 1},
        "title": "tool ahead",
        "label": "ahead",
        "row": "x ahead",
        "group": "Arm, CARTESIAN",
        "modes": ["CARTESIAN"],
        "code": "KeyO",
        "button": True,
        "cap": "O",
        "more_codes": [],
    }
    assert actions["faster"]["more_codes"] == ["NumpadAdd"]
    assert actions["release"]["code"] is None
    assert "quit" not in actions


@on_loop
async def test_the_shipped_map_is_served_as_the_robot_obeys_it():
    served_map = await fetch("joy_map.json")
    assert (served_map["enable"], served_map["shift"]) == ("left_bumper", "right_bumper")
    modes = {mode["name"]: mode for mode in served_map["modes"]}
    assert list(modes) == ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"]
    # A scale below 0 is gone: up is the negative end of a stick, and ahead.
    assert modes["DRIVE"]["plain"]["left_stick_y"] == {
        "positive": {"kind": "drive", "linear": -1, "angular": 0},
        "negative": {"kind": "drive", "linear": 1, "angular": 0},
        "deadzone": 0.12,
        "expo": 0.4,
        "scale": 1.0,
    }
    approach = {"kind": "preset", "name": "approach"}
    assert modes["DRIVE"]["shifted"]["dpad_up"]["action"] == approach
    up = modes["CARTESIAN"]["plain"]["right_stick_y"]["negative"]
    assert up == {"kind": "tool", "axis": "z", "sign": 1}
    for mode in modes.values():
        for layer in (mode["plain"], mode["shifted"]):
            assert layer["left_stick"]["action"] == {"kind": "command", "name": "e-stop"}


def test_wrong_actions_are_refused_with_their_file(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("{modes: {}, groups: []}")
    with pytest.raises(ConfigError, match="mine.yaml: modes are ; they must be DRIVE, JOINT"):
        add_maps(web.Application(), actions=str(path), joy_map="", ask=nothing_known)


def test_a_wrong_map_is_refused_with_its_name(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("{description: x, enable: left_bumper, modes: [{name: DRIVE}]}")
    with pytest.raises(ConfigError, match="mine.yaml: common/buttons: no button has .*'e-stop'"):
        add_maps(web.Application(), actions="", joy_map=str(path), ask=nothing_known)
