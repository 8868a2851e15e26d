"""What a gamepad demands, message by message: layers, modes, and all that must not move."""

from __future__ import annotations

from pathlib import Path

import pytest

from telex_control.common.params import read_config
from telex_teleop.actions.grammar import (
    Command,
    Drive,
    Jog,
    Lamps,
    Preset,
    Side,
    Tool,
    ToPose,
)
from telex_teleop.joy.core import JoyTeleop
from telex_teleop.joy.maps import JoyMap
from telex_teleop.joy.pads import BUTTONS, STICKS, InvalidJoy, Pads

JOY = Path(__file__).parents[2] / "config" / "joy"
AHEAD = Drive(1, 0)
FRONT = Jog("flipper", ("front_left_flipper_joint", "front_right_flipper_joint"), 1)
TIMEOUT = 0.3
SMALL = {
    "description": "small",
    "enable": "left_bumper",
    "shift": "right_bumper",
    "expo": 0.0,
    "deadzone": 0.1,
    "common": {
        "sticks": {"left_stick_y": {"moves": "tracks linear", "scale": -1.0}},
        "buttons": {
            "left_stick": "e-stop",
            "back": "release e-stop",
            "start": "mode",
            "south": "slower",
            "east": "stop",
            "right_trigger": "gripper gripper -",
        },
    },
    "modes": [
        {
            "name": "DRIVE",
            "sticks": {"right_stick_x": {"moves": "arm turret_joint"}},
            "buttons": {
                "dpad_up": "preset flat",
                "west": "side left",
                "dpad_down": "arm turret_joint +",
            },
            "shifted": {"buttons": {"dpad_up": "preset high", "south": "lamps a b"}},
        },
        {"name": "JOINT", "arm_mode": "JOINT", "buttons": {"dpad_up": "pose ready"}},
        {
            "name": "TOOL",
            "arm_mode": "CARTESIAN",
            "sticks": {"right_stick_x": {"moves": "tool y", "scale": -0.5}},
        },
    ],
}


class Hands:
    """A gamepad of the standard layout in somebody's hands."""

    def __init__(self, joy_map):
        pad = Pads.read(str(JOY / "pads.yaml")).pads["standard"]
        self.core = JoyTeleop(joy_map, pad, TIMEOUT)
        self.now = 100.0
        self.held = {}

    def do(self, wait=0.05, **held):
        """Hold these controls and no others besides those set before; return the presses."""
        self.held = {name: value for name, value in {**self.held, **held}.items() if value}
        self.now += wait
        axes = [float(self.held.get(name, 0.0)) for name in STICKS]
        buttons = [int(self.held.get(name, 0)) for name in BUTTONS]
        return self.core.take(axes, buttons, self.now)

    @property
    def demands(self):
        return self.core.demands(self.now)


@pytest.fixture
def hands():
    hands = Hands(read_config(JoyMap, SMALL, "small"))
    hands.do()
    return hands


def test_moves_only_with_the_enable_button(hands):
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {}
    hands.do(left_stick_y=0)
    hands.do(left_bumper=1)
    assert hands.demands == {}
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {AHEAD: 1.0}
    hands.do(left_stick_y=0.55)
    assert hands.demands == {Drive(-1, 0): pytest.approx(0.5)}
    hands.do(left_bumper=0)
    assert hands.demands == {}


def test_the_enable_button_itself_starts_nothing(hands):
    hands.do(left_stick_y=-1.0)
    hands.do(left_bumper=1)
    assert hands.demands == {}
    assert hands.core.waiting(hands.now) == ["left_stick_y"]
    hands.do(left_stick_y=-0.05)  # in the deadzone
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {AHEAD: 1.0}
    assert hands.core.waiting(hands.now) == []


def test_what_is_held_at_the_start_moves_nothing():
    hands = Hands(read_config(JoyMap, SMALL, "small"))
    hands.do(left_bumper=1, left_stick_y=-1.0, dpad_up=1, right_trigger=1)
    assert hands.demands == {}
    hands.do(dpad_up=0)
    hands.do(dpad_up=1)
    assert hands.demands == {Preset("flat"): 1.0}  # each control for itself


def test_silence_stops_and_then_needs_the_centre(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0)
    assert hands.core.demands(hands.now + TIMEOUT) == {AHEAD: 1.0}
    assert hands.core.demands(hands.now + TIMEOUT + 0.001) == {}
    hands.do(wait=TIMEOUT + 0.01)  # reconnected, still held
    assert hands.demands == {}
    hands.do(left_stick_y=0)
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {AHEAD: 1.0}


def test_what_waited_while_the_program_was_held_up_moves_nothing(hands):
    hands.do(left_bumper=1)
    hands.core.interrupt(hands.now)
    hands.do(wait=0.001)  # at rest, but long ago
    assert hands.do(wait=0.001, left_stick_y=-1.0, south=1) == []
    assert hands.demands == {}
    assert hands.do(wait=0.001, left_stick=1) == [Command.E_STOP]  # never too late
    hands.do(wait=0.2, left_stick=0)
    assert hands.demands == {}
    hands.do(left_stick_y=0)
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {AHEAD: 1.0}


def test_neutral_message_stops(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0)
    hands.do(left_bumper=0, left_stick_y=0)
    assert hands.demands == {}


def test_e_stop_needs_nothing_and_holds_until_the_centre(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0)
    assert hands.do(left_stick=1) == [Command.E_STOP]
    assert hands.demands == {}
    assert hands.do() == []
    hands.core.set_e_stop(True)  # the robot says so
    hands.do(left_stick=0, left_stick_y=0)
    hands.do(left_stick_y=-1.0)  # centred while it is set: does not count
    hands.core.set_e_stop(False)
    hands.do()
    assert hands.demands == {}
    hands.do(left_stick_y=0)
    hands.do(left_stick_y=-1.0)
    assert hands.demands == {AHEAD: 1.0}


def test_e_stop_counts_in_the_first_message_of_a_stream():
    hands = Hands(read_config(JoyMap, SMALL, "small"))
    assert hands.do(left_stick=1, south=1, start=1) == [Command.E_STOP]
    assert hands.do(wait=1.0) == [Command.E_STOP]  # and after a reconnection


def test_release_of_the_e_stop_needs_the_enable_button(hands):
    assert hands.do(back=1) == []
    hands.do(back=0, left_bumper=1)
    assert hands.do(back=1) == [Command.RELEASE_E_STOP]


def test_release_does_not_come_late_with_the_enable_button(hands):
    hands.do(back=1)
    assert hands.do(left_bumper=1) == []


def test_stop_lets_everything_go(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0)
    assert hands.do(east=1) == [Command.STOP]
    hands.do(east=0)
    assert hands.demands == {}


def test_a_press_counts_once(hands):
    assert hands.do(south=1) == [Command.SLOWER]
    assert hands.do() == []
    assert hands.do(south=0) == []
    assert hands.do(south=1) == [Command.SLOWER]


def test_change_of_mode_lets_go(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0, dpad_up=1)
    assert hands.demands == {AHEAD: 1.0, Preset("flat"): 1.0}
    assert hands.do(start=1) == [Command.MODE]
    assert hands.core.mode.name == "JOINT"
    assert hands.demands == {}
    hands.do(start=0)
    assert hands.demands == {}
    hands.do(left_stick_y=0, dpad_up=0)
    hands.do(dpad_up=1)
    assert hands.demands == {ToPose("ready"): 1.0}


def test_modes_go_round(hands):
    names = []
    for _ in range(3):
        hands.do(start=1)
        names.append(hands.core.mode.name)
        hands.do(start=0)
    assert names == ["JOINT", "TOOL", "DRIVE"]


def test_shift_changes_a_button_but_does_not_let_it_jump(hands):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0, dpad_up=1)
    hands.do(right_bumper=1)
    assert hands.demands == {AHEAD: 1.0}  # the stick has kept its meaning
    hands.do(dpad_up=0)
    hands.do(dpad_up=1)
    assert hands.demands == {AHEAD: 1.0, Preset("high"): 1.0}
    hands.do(right_bumper=0)
    assert hands.demands == {AHEAD: 1.0}


def test_a_button_held_over_a_change_of_layer_is_no_press(hands):
    assert hands.do(south=1) == [Command.SLOWER]
    assert hands.do(right_bumper=1) == []
    hands.do(south=0)
    assert hands.do(south=1) == [Lamps(("a", "b"))]
    assert hands.do(right_bumper=0) == []


def test_trigger_and_two_controls_of_one_joint(hands):
    hands.do(left_bumper=1)
    hands.do(right_trigger=1, west=1, right_stick_x=0.55, dpad_down=1)
    turret = Jog("arm", ("turret_joint",), 1)
    assert hands.demands == {Jog("gripper", ("gripper",), -1): 1.0, Side("left"): 1.0, turret: 1.0}


def test_scale_and_sign(hands):
    for _ in range(2):
        hands.do(start=1)
        hands.do(start=0)
    hands.do(left_bumper=1)
    hands.do(right_stick_x=1.0)
    assert hands.demands == {Tool(1, -1): pytest.approx(0.5)}


@pytest.mark.parametrize("axes", [[], [0.0, float("nan"), 0.0, 0.0]])
def test_wrong_messages_are_no_sign_of_life(hands, axes):
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0)
    with pytest.raises(InvalidJoy):
        hands.core.take(axes, [0] * 17, hands.now + 0.25)
    assert hands.core.demands(hands.now + 0.25) == {AHEAD: 1.0}
    assert hands.core.demands(hands.now + 0.31) == {}


class TestArmOfAnother:
    def test_the_mode_follows_when_somebody_else_changes_it(self, hands):
        hands.core.follow_arm("JOINT")
        hands.do(start=1)
        hands.do(start=0, left_bumper=1)
        hands.do(left_stick_y=-1.0)
        assert hands.core.mode.name == "JOINT"
        assert hands.core.follow_arm("CARTESIAN")
        assert hands.core.mode.name == "TOOL"
        assert hands.demands == {}

    def test_our_own_wish_is_waited_for(self, hands):
        hands.core.follow_arm("JOINT")
        for _ in range(2):
            hands.do(start=1)
            hands.do(start=0)
        assert not hands.core.follow_arm("JOINT")  # not changed yet
        assert not hands.core.follow_arm("CARTESIAN")
        assert hands.core.mode.name == "TOOL"

    def test_driving_goes_on(self, hands):
        hands.core.follow_arm("JOINT")
        assert not hands.core.follow_arm("CARTESIAN")
        assert hands.core.mode.name == "DRIVE"


def test_shipped_map_drives_and_raises_a_flipper():
    hands = Hands(JoyMap.read(str(JOY / "twin_stick.yaml")))
    hands.do()
    hands.do(left_bumper=1)
    hands.do(left_stick_y=-1.0, dpad_up=1)
    assert hands.demands == {AHEAD: 1.0, FRONT: 1.0}
