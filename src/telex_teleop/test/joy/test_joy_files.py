"""Pads and maps: the shipped files, and what wrong ones are told."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError
from telex_teleop.actions.grammar import Command, Drive, Jog, Lamps, Preset, ToPose
from telex_teleop.joy.maps import ButtonBinding, JoyMap, StickBinding
from telex_teleop.joy.pads import BUTTONS, STICKS, ControlSource, InvalidJoy, Pads

PACKAGE = Path(__file__).parents[2]
JOY = PACKAGE / "config" / "joy"
DESCRIPTION = PACKAGE.parent / "telex_description" / "config"


@pytest.fixture(scope="module")
def pads():
    return Pads.read(str(JOY / "pads.yaml"))


@pytest.fixture(scope="module")
def shipped():
    return JoyMap.read(str(JOY / "twin_stick.yaml"))


def written(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return str(path)


class TestShippedPads:
    @pytest.mark.parametrize(
        ("device", "name"),
        [
            ("Microsoft X-Box 360 pad", "xbox"),
            ("Microsoft Xbox Series S|X Controller", "xbox"),
            ("Logitech Gamepad F310", "xbox"),
            ("Xbox Wireless Controller", "xbox_bluetooth"),
            ("Wireless Controller", "playstation"),
            ("Sony Interactive Entertainment Wireless Controller", "playstation"),
            ("Sony Interactive Entertainment DualSense Wireless Controller", "playstation"),
            ("Logitech Dual Action", "directinput"),
        ],
    )
    def test_devices_are_recognized(self, pads, device, name):
        assert pads.recognized(device)[0] == name

    def test_an_unknown_device_is_told(self, pads):
        with pytest.raises(ConfigError, match=r"'Flight Yoke' is no known pad.*~pad: xbox, "):
            pads.recognized("Flight Yoke")
        with pytest.raises(ConfigError, match=r"pad is 'xbux'; known are xbox, "):
            pads.called("xbux")

    def test_every_control_has_a_place_of_its_own(self, pads):
        for pad in pads.pads.values():
            places = [
                (s.axis, s.button, s.full if n.startswith("dpad") else 0)
                for n, s in pad.controls.items()
            ]
            assert len(set(places)) == len(places)
            assert set(STICKS) <= set(pad.controls)

    def test_standard_is_the_order_of_the_specification(self, pads):
        controls = pads.pads["standard"].controls
        assert [controls[name] for name in STICKS] == [ControlSource(axis=i) for i in range(4)]
        assert [controls[name] for name in BUTTONS] == [ControlSource(button=i) for i in range(17)]

    def test_xbox_at_rest_and_in_use(self, pads):
        pad = pads.pads["xbox"]
        rest = pad.read([0, 0, 1, 0, 0, 1, 0, 0], [0] * 11)
        assert set(rest.values()) == {0.0}
        used = pad.read([1, -1, -1, 0.5, 0, 0, -1, 1], [0, 0, 1, 0, 1] + [0] * 6)
        held = {name: value for name, value in used.items() if value}
        assert held == {
            "left_stick_x": -1.0,  # left
            "left_stick_y": 1.0,  # down
            "left_trigger": 1.0,
            "right_stick_x": -0.5,
            "right_trigger": 0.5,
            "dpad_right": 1.0,
            "dpad_up": 1.0,
            "west": 1.0,
            "left_bumper": 1.0,
        }

    @pytest.mark.parametrize(
        ("axes", "buttons", "says"),
        [
            ([], [0] * 11, "axes has 0 values; this pad .* at least 8"),
            ([0.0] * 8, [0] * 10, "buttons has 10 values"),
            ([0.0] * 7 + [float("nan")], [0] * 11, r"axes\[7\] is nan"),
            ([float("-inf")] + [0.0] * 7, [0] * 11, r"axes\[0\] is -inf"),
        ],
    )
    def test_wrong_messages_are_refused(self, pads, axes, buttons, says):
        with pytest.raises(InvalidJoy, match=says):
            pads.pads["xbox"].read(axes, buttons)

    def test_more_than_needed_is_taken(self, pads):
        assert pads.pads["xbox"].read([9.0] * 20, [7] * 30)["left_stick_x"] == -1.0


class TestShippedMap:
    def test_serves_every_shipped_pad(self, shipped, pads):
        for pad in pads.pads.values():
            shipped.require_on(pad)
            assert shipped.missing_on(pad) == []

    def test_modes(self, shipped):
        assert [(mode.name, mode.arm_mode) for mode in shipped.modes] == [
            ("DRIVE", ""),
            ("JOINT", "JOINT"),
            ("CARTESIAN", "CARTESIAN"),
            ("CAMERA", ""),
        ]

    def test_names_what_the_robot_has(self, shipped):
        robot = {
            node: yaml.safe_load((PACKAGE / "config" / f"{node}_teleop.yaml").read_text())["joints"]
            for node in ("arm", "gripper", "flipper")
        }
        robot["gripper"].append("gripper")
        presets = yaml.safe_load((PACKAGE / "config" / "flipper_presets.yaml").read_text())
        poses = yaml.safe_load((DESCRIPTION / "poses.yaml").read_text())["poses"]
        lamps = yaml.safe_load((DESCRIPTION / "lamps.yaml").read_text())["lamps"]
        for action in shipped.actions:
            if isinstance(action, Jog):
                assert set(action.joints) <= set(robot[action.node])
        named = {
            kind: {a.name for a in shipped.actions if isinstance(a, kind)}
            for kind in (Preset, ToPose)
        }
        assert named[Preset] == {preset["name"] for preset in presets["presets"]}
        assert named[ToPose] == set(poses)
        # Laser dots have a key of the page alone.
        light = {name for name, lamp in lamps.items() if not lamp.get("beam")}
        assert set(shipped.lamps) == light

    def test_reaches_every_joint_of_arm_and_flippers_both_ways(self, shipped):
        reached = {
            (joint, action.sign)
            for action in shipped.actions
            if isinstance(action, Jog)
            for joint in action.joints
        }
        for node in ("arm", "flipper"):
            config = yaml.safe_load((PACKAGE / "config" / f"{node}_teleop.yaml").read_text())
            assert {(joint, sign) for joint in config["joints"] for sign in (1, -1)} <= reached

    def test_sticks_push_where_they_point(self, shipped):
        drive = shipped.bindings(shipped.modes[0], False)
        stick = drive["left_stick_y"]
        assert isinstance(stick, StickBinding)
        assert stick.demand(-1.0) == (Drive(1, 0), 1.0)  # up is ahead
        assert stick.demand(1.0) == (Drive(-1, 0), 1.0)
        assert drive["left_stick_x"].demand(-1.0)[0] == Drive(0, 1)  # left turns left

    def test_layers(self, shipped):
        drive = shipped.modes[0]
        assert isinstance(shipped.bindings(drive, False)["dpad_up"].action, Jog)
        assert shipped.bindings(drive, True)["dpad_up"].action == Preset("approach")
        assert shipped.bindings(drive, True)["south"].action is Command.SLOWER
        camera = shipped.bindings(shipped.modes[3], False)
        assert camera["dpad_left"].action == Lamps(("gripper",))


class TestShape:
    binding = StickBinding(Drive(1, 0), Drive(-1, 0), deadzone=0.2, expo=0.5, scale=0.8)

    def test_ends_and_centre(self):
        assert self.binding.shaped(0.2) == 0.0
        assert self.binding.shaped(-0.1) == 0.0
        assert self.binding.shaped(1.0) == pytest.approx(0.8)
        assert self.binding.shaped(-1.0) == pytest.approx(-0.8)

    def test_rises_without_a_jump_and_finer_near_the_centre(self):
        values = [self.binding.shaped(0.2 + 0.8 * step / 100) for step in range(101)]
        steps = [after - before for before, after in zip(values, values[1:])]
        assert steps == sorted(steps)
        assert steps[0] == pytest.approx(0.004, rel=0.01)
        assert values[50] == pytest.approx(0.8 * (0.5 * 0.5 + 0.5 * 0.125))

    def test_trigger(self):
        binding = ButtonBinding(Preset("flat"), deadzone=0.2)
        assert binding.demand(0.6) == (Preset("flat"), pytest.approx(0.5))


MAP = """
description: mine
enable: left_bumper
common: {{buttons: {{east: e-stop}}}}
modes:
  - name: DRIVE
    sticks: {{left_stick_y: {{moves: tracks linear{stick}}}}}
    buttons: {{{buttons}}}
{more}
"""


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"more": "enabel: back"}, "enabel is unknown"),
        ({"more": "shift: left_bumper"}, "shift is 'left_bumper', as enable"),
        ({"more": "deadzone: .nan"}, "deadzone is nan; it must be finite"),
        ({"more": "expo: 2"}, "expo is 2.0; it must be at least 0 and at most 1"),
        ({"stick": ", scale: 0"}, r"modes\[0\]/sticks/left_stick_y: scale is 0"),
        ({"stick": ", scale: fast"}, "scale is 'fast'; a number is needed"),
        ({"stick": " up"}, "moves is 'tracks linear up'; it must be 'tracks linear'"),
        ({"buttons": "nort: mode"}, "buttons/nort is unknown; known are south, east"),
        ({"buttons": "north: jump"}, "buttons/north is 'jump'; it must be 'tracks DIRECTION'"),
        ({"buttons": "north: quit"}, "which a gamepad does not have"),
        ({"buttons": "left_bumper: stop"}, "left_bumper does 'stop', and is enable or shift"),
        ({"buttons": "north: tool x +"}, "arm_mode is ''; it must be CARTESIAN"),
        ({"buttons": "east: slower"}, "DRIVE takes the last button from 'e-stop'"),
        ({"more": "  - {name: ARM}"}, "no button has the action 'mode'"),
        ({"more": "  - {name: DRIVE}"}, "their names must differ"),
        ({"more": "  - {name: ARM, arm_mode: joint}"}, "arm_mode is 'joint'; , JOINT"),
        ({"more": "]"}, "cannot be read"),
        ({"more": "x: &x {y: *x}"}, "cannot be read: 'y' is an alias"),
    ],
)
def test_a_wrong_map_is_refused_with_file_key_and_value(tmp_path, change, says):
    path = written(tmp_path, MAP.format(**{"stick": "", "buttons": "", "more": "", **change}))
    with pytest.raises(ConfigError, match=says) as refusal:
        JoyMap.read(path)
    assert str(refusal.value).startswith(path)


def test_the_map_of_that_test_is_right_without_the_change(tmp_path):
    text = MAP.format(stick="", buttons="", more="")
    assert JoyMap.read(written(tmp_path, text)).modes[0].name == "DRIVE"


PAD = "pads: {{mine: {{description: mine, {more}controls: {{south: {{{source}}}}}}}}}"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (PAD.format(more="", source="axis: 1, button: 2"), "one of them must be given"),
        (PAD.format(more="", source=""), "one of them must be given"),
        (PAD.format(more="", source="axis: -1"), "axis is -1; it must be at least 0"),
        (PAD.format(more="", source="axis: 1.5"), "axis is 1.5; an integer is needed"),
        (PAD.format(more="", source="axis: 1, rest: 1"), "at least 0.5 apart"),
        (PAD.format(more="match: '(', ", source="axis: 1"), "regular expression is needed"),
        ("pads: {}", "pads is empty"),
        ("pads: {a: {description: a, controls: {}}}", "pads/a: controls is empty"),
        ("pads: {a: {description: a, controls: {nose: {button: 1}}}}", "controls/nose is unknown"),
    ],
)
def test_a_wrong_file_of_pads_is_refused(tmp_path, text, says):
    path = written(tmp_path, text)
    with pytest.raises(ConfigError, match=says) as refusal:
        Pads.read(path)
    assert str(refusal.value).startswith(path)


def test_a_pad_without_the_needed_buttons_is_refused(tmp_path, shipped):
    text = PAD.format(more="", source="button: 0")
    pad = Pads.read(written(tmp_path, text)).pads["mine"]
    with pytest.raises(ConfigError, match="mine has no left_bumper, which the map has as enable"):
        shipped.require_on(pad)


def test_a_file_that_is_not_there_is_told():
    with pytest.raises(ConfigError, match="/nowhere.yaml: cannot be read"):
        JoyMap.read("/nowhere.yaml")
