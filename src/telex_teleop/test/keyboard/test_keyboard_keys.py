"""Held keys, the key map, the commands they make and the screen that shows them."""

import re
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError, read_config
from telex_teleop.actions.grammar import (
    PAGE_ONLY,
    Command,
    Drive,
    Jog,
    Lamps,
    Preset,
    Side,
    Tool,
    ToPose,
    Zoom,
    parse_action,
    parse_axis,
)
from telex_teleop.actions.vocabulary import Vocabulary
from telex_teleop.keyboard.decoding import KeyEvent, KeyKind
from telex_teleop.keyboard.held import HeldKeys
from telex_teleop.keyboard.map import KeyboardSettings, KeyMap
from telex_teleop.keyboard.screen import (
    JointView,
    NodeView,
    ScreenState,
    Style,
    ToolView,
    render,
)
from telex_teleop.operating.commander import Commander, FixedRates, PresetCommand
from telex_teleop.operating.zoom import ZoomFactor
from telex_teleop.tracks.track_drive import Velocity

FILE = Path(__file__).parents[2] / "config" / "keyboard_teleop.yaml"
PRESETS = FILE.with_name("flipper_presets.yaml")


def event(name, kind=KeyKind.TYPED):
    return KeyEvent(name, name, kind)


class TestTypedKeys:
    @pytest.fixture
    def held(self):
        return HeldKeys(tap_time=0.15, key_timeout=0.2)

    def test_first_press_is_a_nudge(self, held):
        assert held.take(event("w"), 1.0)
        assert held.names(1.14) == ["w"]
        assert held.names(1.16) == []

    def test_repeats_bridge_to_the_next(self, held):
        held.take(event("w"), 1.0)
        assert held.names(1.4) == []  # the keyboard's repeat delay
        for tick in range(20):
            now = 1.5 + 0.033 * tick
            held.take(event("w"), now)
            assert held.names(now + 0.03) == ["w"]
        assert held.names(now + 0.19) == ["w"]
        assert held.names(now + 0.21) == []

    def test_only_the_first_of_a_burst_went_down(self, held):
        assert held.take(event("w"), 1.0)
        assert not held.take(event("w"), 1.1)
        assert held.take(event("w"), 2.0)

    def test_repetition_that_goes_on_after_release_all_is_ignored(self, held):
        held.take(event("w"), 1.0)
        held.release_all(1.05)
        assert held.names(1.05) == []
        for tick in range(10):
            assert not held.take(event("w"), 1.08 + 0.03 * tick)
        assert held.names(1.36) == []
        assert held.take(event("w"), 1.7)
        assert held.names(1.7) == ["w"]


class TestExactKeys:
    @pytest.fixture
    def held(self):
        return HeldKeys(tap_time=0.15, key_timeout=0.2)

    def press(self, held, name, now=0.0):
        return held.take(event(name, KeyKind.PRESSED), now)

    def test_key_is_held_until_released(self, held):
        assert self.press(held, "w")
        assert self.press(held, "a")
        assert not held.take(event("w", KeyKind.REPEATED), 5.0)
        assert held.names(60.0) == ["w", "a"]
        assert not held.take(event("w", KeyKind.RELEASED), 61.0)
        assert held.names(61.0) == ["a"]

    def test_release_all_needs_a_new_press(self, held):
        self.press(held, "w")
        held.release_all(1.0)
        held.take(event("w", KeyKind.REPEATED), 1.1)
        assert held.names(1.1) == []
        held.take(event("w", KeyKind.RELEASED), 1.2)
        self.press(held, "w", 1.3)
        assert held.names(1.3) == ["w"]

    def test_press_after_a_lost_release_counts(self, held):
        self.press(held, "w")
        held.release_all(1.0)
        self.press(held, "w", 2.0)
        assert held.names(2.0) == ["w"]

    def test_release_is_found_although_shift_changed_the_name(self, held):
        held.take(KeyEvent("w", "119", KeyKind.PRESSED), 0.0)
        held.take(KeyEvent("W", "119", KeyKind.RELEASED), 1.0)
        assert held.names(1.0) == []


@pytest.mark.parametrize(
    ("text", "action"),
    [
        ("tracks forward", Drive(1, 0)),
        ("tracks right", Drive(0, -1)),
        ("arm turret_joint +", Jog("arm", ("turret_joint",), 1)),
        ("flipper a_joint b_joint -", Jog("flipper", ("a_joint", "b_joint"), -1)),
        ("preset climb", Preset("climb")),
        ("tool pitch -", Tool(4, -1)),
        ("pose ready", ToPose("ready")),
        ("side left", Side("left")),
        ("zoom -", Zoom(-1)),
        ("lamps front_left gripper", Lamps(("front_left", "gripper"))),
        ("proximity guard", Command.GUARD),
        ("release  e-stop", Command.RELEASE_E_STOP),
    ],
)
def test_actions(text, action):
    assert parse_action(text) == action


@pytest.mark.parametrize(
    "text",
    [
        "",
        "tracks",
        "tracks up",
        "arm +",
        "arm turret_joint",
        "leg a +",
        "arm a a +",
        "jump",
        "preset",
        "preset a b",
        "pose",
        "tool up +",
        "tool x",
        "side",
        "side up",
        "zoom",
        "zoom in",
        "lamps",
        "lamps a a",
    ],
)
def test_unknown_actions_are_refused(text):
    with pytest.raises(ValueError):
        parse_action(text)


BASE = {"space": "stop", "escape": "e-stop", "ctrl+c": "quit"}


def key_map(**keys):
    return KeyMap.from_texts({**BASE, **keys})


def test_bad_action_is_refused_with_key_value_and_remedy():
    with pytest.raises(ConfigError, match="file: keys/w is 'fly'.*'tracks DIRECTION'"):
        read_config(KeyboardSettings, {"keys": {**BASE, "w": "fly"}}, "file")


@pytest.mark.parametrize("missing", BASE)
def test_keys_that_must_be_there(missing):
    keys = {key: action for key, action in BASE.items() if key != missing}
    with pytest.raises(ConfigError, match="no key has the action"):
        KeyMap.from_texts(keys)


def test_caps_lock_does_not_matter_unless_the_capital_is_bound():
    keys = key_map(w="tracks forward", x="tracks back", X="help")
    assert keys.action("W") == Drive(1, 0)
    assert keys.action("X") is Command.HELP
    assert keys.action("ctrl+w") is None


@pytest.fixture
def settings():
    return KeyboardSettings.read(yaml.safe_load(FILE.read_text()), Vocabulary.read(), str(FILE))


def test_file_of_the_package_moves_everything_both_ways(settings):
    actions = list(settings.key_map.actions.values())
    for node, count in (("arm", 9), ("gripper", 1), ("flipper", 6)):
        axes = {action.joints for action in actions if getattr(action, "node", "") == node}
        assert len(axes) == count
        for joints in axes:
            assert {Jog(node, joints, 1), Jog(node, joints, -1)} <= set(actions)
    commands = set(Command) - set(PAGE_ONLY)
    assert {Drive(1, 0), Drive(-1, 0), Drive(0, 1), Drive(0, -1), *commands} <= set(actions)


def test_the_digits_are_the_shipped_presets_in_their_order(settings):
    presets = [preset["name"] for preset in yaml.safe_load(PRESETS.read_text())["presets"]]
    assert len(presets) == 7
    for digit, name in enumerate(presets, start=1):
        assert settings.key_map.action(str(digit)) == Preset(name)


def test_unknown_setting_is_refused():
    values = yaml.safe_load(FILE.read_text())
    with pytest.raises(ConfigError, match="f/tap is unknown"):
        KeyboardSettings.read({**values, "tap": 1.0}, Vocabulary.read(), "f")


def test_keys_of_ones_own_replace_the_shipped_ones():
    settings = KeyboardSettings.read({"keys": BASE}, Vocabulary.read(), "f")
    assert settings.key_map.actions == settings.cartesian_map.actions
    assert set(settings.keys) == set(BASE)
    only = {"cartesian_keys": {"w": "tool x +"}}
    settings = KeyboardSettings.read(only, Vocabulary.read(), "f")
    assert settings.cartesian_map.action("w") == Tool(0, 1)
    assert settings.cartesian_map.action("s") == settings.key_map.action("s") == Drive(-1, 0)


@pytest.mark.parametrize("text", ["drive mode", "camera mode", "next camera"])
def test_what_only_the_page_has_is_refused(text):
    with pytest.raises(ConfigError, match=f"keys/w is '{text}', which only the console's page has"):
        KeyMap.from_texts({**BASE, "w": text})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"tap_time": 2.0}, "f: tap_time is 2.0; it must be at least 0.02 and at most 1"),
        ({"jog_rate": 0.0}, "f: jog_rate is 0.0; it must be above 0"),
        ({"linear": float("nan")}, "f/linear is nan"),
        ({"lengths": ["a", "a"]}, "lengths is .*distinct names"),
        ({"keys": {**BASE, "w": 3}}, "f/keys/w is 3; a string is needed"),
    ],
)
def test_bad_settings_are_refused(changes, says):
    with pytest.raises(ConfigError, match=says):
        read_config(KeyboardSettings, {"keys": BASE, **changes}, "f")


def test_bare_numbers_are_keys():
    settings = read_config(KeyboardSettings, {"keys": {**BASE, 1: "tracks back"}}, "f")
    assert settings.key_map.action("1") == Drive(-1, 0)


class TestCommander:
    turret = Jog("arm", ("turret_joint",), 1)
    turret_back = Jog("arm", ("turret_joint",), -1)
    pair = Jog("flipper", ("left", "right"), 1)

    @pytest.fixture
    def commander(self):
        return Commander(FixedRates(jog=100.0, linear=1.2, angular=1.0))

    def test_held_keys_move_and_released_ones_stop_once(self, commander):
        assert commander.update([self.turret]).jogs == {"arm": {"turret_joint": 100.0}}
        assert commander.busy
        assert commander.update([]).jogs == {"arm": {"turret_joint": 0.0}}
        assert not commander.busy
        assert commander.update([]).jogs == {}

    def test_several_joints_and_nodes_at_once(self, commander):
        commands = commander.update([self.turret_back, self.pair])
        assert commands.jogs == {
            "arm": {"turret_joint": -100.0},
            "flipper": {"left": 100.0, "right": 100.0},
        }

    def test_opposite_keys_stand_still(self, commander):
        assert commander.update([self.turret, self.turret_back]).jogs == {
            "arm": {"turret_joint": 0.0}
        }
        assert not commander.busy

    def test_two_keys_for_one_joint_are_not_faster(self, commander):
        left = Jog("flipper", ("left",), 1)
        assert commander.update([self.pair, left]).jogs["flipper"]["left"] == 100.0

    def test_driving(self, commander):
        both = commander.update([Drive(1, 0), Drive(0, -1)])
        assert both.drive == (Velocity(1.2, -1.0),)
        assert commander.update([]).drive == (Velocity(0.0, 0.0),)
        assert commander.update([]).drive == ()

    def test_a_held_preset_is_repeated_and_stopped_once(self, commander):
        assert commander.update([Preset("flat")]).preset == (PresetCommand("flat"),)
        assert commander.busy
        assert commander.update([Preset("flat")]).preset == (PresetCommand("flat"),)
        assert commander.update([]).preset == (PresetCommand(""),)
        assert not commander.busy
        assert commander.update([]).preset == ()

    def test_two_presets_at_once_stand_still(self, commander):
        commander.update([Preset("flat")])
        assert commander.update([Preset("flat"), Preset("high")]).preset == (PresetCommand(""),)
        assert commander.update([Preset("flat"), Preset("high")]).preset == ()
        assert commander.update([Preset("high")]).preset == (PresetCommand("high"),)

    def test_two_poses_at_once_stand_still(self, commander):
        assert commander.update([ToPose("stow")]).pose == ("stow",)
        assert commander.update([ToPose("stow"), ToPose("ready")]).pose == ("",)
        assert not commander.busy
        assert commander.update([ToPose("ready")]).pose == ("ready",)

    def test_a_preset_is_sent_beside_a_flipper_key(self, commander):
        # which of them wins is for the robot's side to say
        commands = commander.update([Preset("flat"), self.pair])
        assert commands.preset == (PresetCommand("flat"),)
        assert commands.jogs == {"flipper": {"left": 100.0, "right": 100.0}}

    def test_stop_tells_everything(self, commander):
        commander.update([self.turret, Drive(1, 0)])
        commands = commander.stop([self.turret, self.turret_back, self.pair, Command.HELP])
        assert commands.jogs == {
            "arm": {"turret_joint": 0.0},
            "flipper": {"left": 0.0, "right": 0.0},
        }
        assert commands.drive == (Velocity(0.0, 0.0),)
        assert commands.preset == (PresetCommand(""),)
        assert commander.update([]).jogs == {}

    @pytest.mark.parametrize("name", ["front_{}_joint", "{}_front_flipper_joint", "flipper_{}"])
    def test_a_side_key_restricts_flippers_and_presets(self, commander, name):
        joints = name.format("left"), name.format("right")
        flippers = Jog("flipper", joints, 1)
        left, right = Side("left"), Side("right")
        assert commander.update([flippers]).jogs["flipper"][joints[1]] == 100.0
        one = commander.update([flippers, left, Preset("flat")])
        assert one.jogs["flipper"] == {joints[0]: 100.0, joints[1]: 0.0}
        assert one.preset == (PresetCommand("flat", "left"),)
        # both of them are no restriction, as on the console
        both = commander.update([flippers, left, right, Preset("flat")])
        assert both.jogs["flipper"] == {joints[0]: 100.0, joints[1]: 100.0}
        assert both.preset == (PresetCommand("flat"),)
        assert commander.update([left]).preset == (PresetCommand(""),)

    def test_zoom_ends_with_a_zero(self, commander):
        assert commander.update([Zoom(1)]).zoom == (1.0,)
        assert commander.busy
        assert commander.update([]).zoom == (0.0,)
        assert commander.update([]).zoom == ()

    def test_half_a_demand_is_half_the_rate(self, commander):
        half = commander.update({self.turret: 0.5, Drive(1, 0): 0.25, Tool(0, -1): 0.5})
        assert half.jogs == {"arm": {"turret_joint": 50.0}}
        assert half.drive == (Velocity(0.3, 0.0),)
        assert half.tool == ((-0.5, 0.0, 0.0, 0.0, 0.0, 0.0),)

    def test_two_demands_add_up_to_the_full_rate_at_most(self, commander):
        commands = commander.update({self.turret: 0.8, Jog("arm", ("turret_joint",), 1): 0.8})
        assert commands.jogs == {"arm": {"turret_joint": 80.0}}
        both = {self.pair: 0.8, Jog("flipper", ("left",), 1): 0.8}
        assert commander.update(both).jogs["flipper"] == {"left": 100.0, "right": 80.0}

    def test_what_has_no_known_rate_is_told_and_not_sent(self):
        class Unknown:
            def joint(self, node, joint):
                return 2.0 if joint == "left" else None

            def drive(self):
                return None

            def tool_speed(self):
                return None

        commander = Commander(Unknown())
        commands = commander.update([self.pair, Drive(1, 0), Tool(0, 1)])
        assert commands.jogs == {"flipper": {"left": 2.0}}
        assert (commands.drive, commands.tool) == ((), ())
        assert commands.unknown == ("right", "tracks", "tool")
        assert commander.update([]).unknown == ()


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("tracks linear", (Drive(1, 0), Drive(-1, 0))),
        ("tracks angular", (Drive(0, 1), Drive(0, -1))),
        ("arm turret_joint", (Jog("arm", ("turret_joint",), 1), Jog("arm", ("turret_joint",), -1))),
        ("tool yaw", (Tool(5, 1), Tool(5, -1))),
        ("zoom", (Zoom(1), Zoom(-1))),
    ],
)
def test_axes(text, ends):
    assert parse_axis(text) == ends


@pytest.mark.parametrize(
    "text", ["", "tracks", "tracks forward", "preset", "lamps", "lamps a", "stop"]
)
def test_unknown_axes_are_refused(text):
    with pytest.raises(ValueError):
        parse_axis(text)


class TestZoomFactor:
    def test_turns_as_long_as_it_is_told(self):
        zoom = ZoomFactor(6.0)
        assert zoom.turn(1.0, 5.0) == 1.0
        assert zoom.turn(1.0, 5.1) == pytest.approx(1.10517, rel=1e-4)
        assert zoom.turn(0.0, 5.2) == pytest.approx(1.10517, rel=1e-4)
        zoom.turn(1.0, 50.0)
        assert zoom.turn(1.0, 50.1) == pytest.approx(1.2214, rel=1e-4)

    def test_stays_within_its_bounds(self):
        zoom = ZoomFactor(1.05)
        zoom.turn(9.0, 1.0)
        assert zoom.turn(9.0, 1.1) == 1.05
        assert zoom.turn(-9.0, 1.2) == 1.0

    def test_a_pause_is_no_time_that_it_was_held(self):
        zoom = ZoomFactor(6.0)
        zoom.turn(1.0, 1.0)
        assert zoom.turn(1.0, 9.0) == pytest.approx(1.10517, rel=1e-4)

    def test_what_somebody_else_has_set_is_where_it_begins(self):
        zoom = ZoomFactor(6.0)
        for value, held in ((3.0, 3.0), (float("nan"), 3.0), (99.0, 6.0), (0.1, 1.0)):
            zoom.take(value)
            assert zoom.value == held


class TestScreen:
    nodes = {name: NodeView(0.1, False, "") for name in ("tracks", "arm", "gripper", "flipper")}

    def show(self, settings, columns=80, lines=24, show_help=False, **state):
        values = {"nodes": self.nodes, "mode": "JOINT", "speed_scale": 0.5, **state}
        screen = ScreenState("/telex", **values)
        return render(settings.key_map, settings.lengths, screen, columns, lines, show_help)

    def text(self, *arguments, **state):
        return "\n".join(line.text for line in self.show(*arguments, **state))

    @pytest.mark.parametrize("show_help", [False, True])
    @pytest.mark.parametrize(("columns", "lines"), [(80, 24), (200, 60), (40, 60), (60, 8), (1, 1)])
    def test_fits_any_terminal(self, settings, columns, lines, show_help):
        picture = self.show(settings, columns, lines, show_help)
        assert len(picture) <= lines
        assert all(len(line.text) <= columns for line in picture)

    def test_a_usual_terminal_shows_everything(self, settings):
        text = self.text(settings)
        assert text.splitlines() == self.text(settings, 80, 60).splitlines()
        for word in (
            "mode JOINT",
            "speed 50 %",
            "elbow",
            "camera tilt",
            "rear right",
            "1 flat",
            "7 folded",
            "z stow",
            "b floor_pick",
            "y: frame",
            "h: hold tool",
            "(only q left, e right)",
            "pageup pagedown zoom",
            "home front",
            "insert turret camera",
            "\\: guard",
            "space: stop",
        ):
            assert word in text

    def test_the_smallest_still_says_how_to_stop(self, settings):
        text = self.text(settings, 80, 8)
        assert "space: stop all" in text
        assert "READY" in text

    def test_values(self, settings):
        text = self.text(
            settings,
            joints={"telescope_joint": JointView(0.25, True), "elbow_joint": JointView(1.0, False)},
            drive=Velocity(0.5, 0.0),
            held=frozenset([Jog("arm", ("elbow_joint",), -1)]),
        )
        assert "!+250 mm" in text
        assert re.search(r"> p ; +elbow +\+57.3 deg", text)
        assert "+0.50 m/s" in text

    def test_the_preset_that_is_held_is_marked(self, settings):
        text = self.text(settings, held=frozenset([Preset("climb")]))
        assert "> 4 climb" in text
        assert "  5 descend" in text

    def test_zoom_lamps_and_side(self, settings):
        text = self.text(
            settings, zoom=2.5, lit=("rear_left", "rear_right"), held=frozenset([Side("left")])
        )
        assert "x2.5" in text
        assert "* end rear" in text
        assert "* home front" not in text
        assert "(only >q left, e right)" in text

    def test_obedience(self, settings):
        active = {**self.nodes, "arm": NodeView(0.1, True, "")}
        deaf = {**self.nodes, "arm": NodeView(0.1, False, "the simulation is paused")}
        gone = {**self.nodes, "arm": NodeView(3.0, False, "")}
        for state, says, style in (
            ({}, "READY", Style.NORMAL),
            ({"nodes": active}, "OBEYED by arm", Style.GOOD),
            ({"nodes": deaf}, "NOT OBEYED (arm): the simulation is paused", Style.WARNING),
            ({"nodes": gone}, "NO ANSWER from: arm", Style.WARNING),
            ({"nodes": {}}, "NO ANSWER from the robot's", Style.ALARM),
            ({"e_stop": True}, "E-STOP IS ACTIVE, nothing obeys. Release: ctrl+r", Style.ALARM),
        ):
            line = self.show(settings, **state)[1]
            assert line.text.startswith(says)
            assert line.style is style

    def test_notice(self, settings):
        assert self.show(settings, notice="no such mode")[-1].text == "no such mode"

    def test_a_usual_terminal_shows_everything_in_cartesian_mode(self, settings):
        tool = ToolView("base_link", (0.8, -0.012, 0.3), (0.0, 0.5, -1.0))
        screen = ScreenState("/telex", nodes=self.nodes, mode="CARTESIAN", tool=tool)
        shown, whole = (
            [line.text for line in render(settings.cartesian_map, (), screen, 80, lines)]
            for lines in (24, 60)
        )
        assert shown == whole
        text = "\n".join(shown)
        assert "mode CARTESIAN (base_link)" in text
        assert re.search(r"  o u +tool x +\+800 mm", text)
        assert re.search(r"  \[ ' +tool pitch +\+28.6 deg", text)
        assert "elbow" not in text
        for word in ("camera tilt", "4 climb", "c ready", "rear right"):
            assert word in text

    def test_the_pose_that_is_held_is_marked(self, settings):
        text = self.text(settings, held=frozenset([ToPose("ready")]))
        assert "> c ready" in text
        assert "  z stow" in text

    @pytest.mark.parametrize("exact_keys", [False, True])
    def test_a_usual_terminal_shows_the_whole_help(self, settings, exact_keys):
        shown, whole = (
            self.text(settings, 80, lines, show_help=True, exact_keys=exact_keys)
            for lines in (24, 60)
        )
        assert shown == whole

    def test_help_explains_the_terminal_at_hand(self, settings):
        assert "nudge" in self.text(settings, show_help=True)
        assert "exactly as long" in self.text(settings, show_help=True, exact_keys=True)
