"""Flipper presets: by a key that is held, and as goals; who wins, and what ends them."""

import math
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError, read_config
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.flippers.flipper_teleop import FlipperTeleop
from telex_teleop.flippers.presets import FlipperPreset, GoalEnd, GoalRules
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.limits import JointBounds
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.speed import SpeedScale

DT = 0.01
TIMEOUT = 0.28
STALL = 1.0
RATE = 1.0
LIMITS = MotionLimits(-1.9, 2.0, RATE, 4.0, 0.2, 0.02)
JOINTS = tuple(f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right"))
PRESETS = {
    "flat": FlipperPreset("flat", "", dict.fromkeys(JOINTS, 0.0)),
    "high": FlipperPreset("high", "", dict.fromkeys(JOINTS, -1.2)),
    "nose_up": FlipperPreset("nose_up", "", {"front_left": 1.0, "front_right": 1.0}),
}


class Robot:
    """A simulation whose flippers follow their references, unless something is in their way."""

    def __init__(self):
        axes = {name: AxisSettings(LIMITS, 0.5) for name in JOINTS}
        rules = GoalRules(0.01, STALL)
        self.core = FlipperTeleop(axes, PRESETS, rules, TIMEOUT, 0.5, SpeedScale())
        self.time = 10.0
        self.positions = dict.fromkeys(JOINTS, 0.4)
        self.stops = {}  # joint to the angle above which something is in its way
        self.last = {}
        self.number = 0

    def start(self):
        self.run(2 * TIMEOUT + 5 * DT)  # a new node is deaf for a while
        return self

    def step(self):
        self.time += DT
        self.last = self.core.update(self.time, self.time, self.positions)
        self.positions.update(self.last)
        for joint, stop in self.stops.items():
            self.positions[joint] = min(self.positions[joint], stop)

    def run(self, duration):
        for _ in range(round(duration / DT)):
            self.step()

    def hold(self, duration, preset, *joints, caller="a", jog=None):
        """Repeat a preset, and perhaps a jog, at 50 Hz, as held keys do."""
        for tick in range(round(duration / DT)):
            if tick % 2 == 0:
                if jog:
                    self.jog(caller=caller, **jog)
                self.press(preset, *joints, caller=caller)
            self.step()

    def press(self, preset, *joints, caller="a"):
        return self.core.hold_preset(preset, joints, self.time, caller)

    def jog(self, caller="a", **rates):
        self.core.receive(JogCommand(rates, {}, None), self.time, caller)

    def goal(self, preset, *joints):
        self.number += 1
        self.core.begin_goal(self.number, preset, joints, self.time)
        return self.number

    def ended(self):
        return self.core.requests.goals.take_ended()

    def message(self):
        return self.core.state(self.time).message

    def active(self):
        return self.core.state(self.time).active


@pytest.fixture
def robot():
    return Robot().start()


# ---- keys


def test_a_held_preset_moves_at_the_flippers_rate_and_stops_at_its_angles(robot):
    robot.hold(0.5, "high")
    assert robot.core.axes["rear_left"].generator.velocity == -RATE
    robot.hold(2.0, "high")
    assert robot.positions == pytest.approx(dict.fromkeys(JOINTS, -1.2), abs=1e-9)
    assert robot.last == {}  # nothing to say any more
    assert robot.active()
    robot.run(1.0)
    assert not robot.active()


def test_speed_scale_slows_a_preset(robot):
    robot.core.speed.set(0.1)
    robot.hold(1.0, "high")
    before = robot.positions["front_left"]
    robot.hold(1.0, "high")
    assert before - robot.positions["front_left"] == pytest.approx(0.1 * RATE)


def test_silence_stops_within_timeout_and_ramp(robot):
    robot.hold(0.6, "high")
    robot.run(TIMEOUT - 0.04)
    assert robot.core.axes["front_left"].generator.velocity == -RATE
    robot.run(0.04)
    assert robot.core.axes["front_left"].generator.velocity > -RATE
    robot.run(0.25)
    assert robot.last == {}
    assert robot.positions["front_left"] > -1.0


def test_an_empty_preset_stops_at_once(robot):
    robot.hold(0.6, "high")
    robot.press("")
    robot.step()
    assert robot.core.axes["front_left"].generator.velocity > -RATE
    robot.hold(0.1, "high")  # and the next press counts
    robot.hold(2.0, "high")
    assert robot.positions["front_left"] == pytest.approx(-1.2)


def test_only_the_joints_that_are_named_move(robot):
    robot.hold(2.0, "high", "front_left", "rear_left")
    assert robot.positions == pytest.approx(
        {"front_left": -1.2, "front_right": 0.4, "rear_left": -1.2, "rear_right": 0.4}
    )


def test_joints_that_a_preset_does_not_name_stay(robot):
    robot.hold(2.0, "nose_up")
    assert robot.positions["front_left"] == pytest.approx(1.0)
    assert robot.positions["rear_left"] == 0.4


@pytest.mark.parametrize(
    ("preset", "joints", "says"),
    [
        ("flip", (), "preset is 'flip'; this robot has flat, high, nose_up"),
        ("flat", ("left_leg",), "joint_names: unknown 'left_leg'; this node moves front_left"),
        ("nose_up", ("rear_left",), "none of them is in preset 'nose_up'"),
        ("flat", JOINTS + JOINTS, "has 8 entries"),
    ],
)
def test_what_is_not_there_is_refused_and_moves_nothing(robot, preset, joints, says):
    with pytest.raises(InvalidCommand, match=says):
        robot.press(preset, *joints)
    with pytest.raises(InvalidCommand, match=says):
        robot.goal(preset, *joints)
    robot.run(0.5)
    assert set(robot.positions.values()) == {0.4}


def test_a_new_node_is_deaf_to_a_key_that_was_held_before():
    robot = Robot()
    robot.hold(1.0, "high")
    assert set(robot.positions.values()) == {0.4}
    assert "release its key" in robot.message()
    robot.run(0.4)
    robot.hold(1.0, "high")
    assert robot.positions["front_left"] < 0.0


def test_e_stop_ends_a_held_preset_until_a_new_press(robot):
    robot.hold(0.5, "high")
    robot.core.set_e_stop(True)
    before = dict(robot.positions)
    robot.hold(0.5, "high")
    assert robot.positions == before
    robot.core.set_e_stop(False)
    robot.hold(0.5, "high")
    assert robot.positions == before
    robot.run(0.3)
    robot.hold(0.5, "high")
    assert robot.positions["front_left"] < before["front_left"] - 0.2


def test_a_reset_ends_a_held_preset_until_a_new_press(robot):
    robot.hold(0.5, "high")
    robot.core.restart(robot.time)
    robot.positions = dict.fromkeys(JOINTS, 0.0)
    robot.hold(0.5, "high")
    assert set(robot.positions.values()) == {0.0}


# ---- a flipper key wins


def test_a_flipper_key_wins_and_the_preset_needs_a_new_press(robot):
    robot.hold(0.5, "high")
    robot.hold(0.6, "high", jog={"front_left": RATE})
    assert robot.core.axes["front_left"].generator.velocity == RATE
    robot.jog(front_left=0.0)
    rear = robot.positions["rear_left"]
    robot.hold(1.0, "high")
    assert robot.positions["rear_left"] == pytest.approx(rear, abs=0.02)
    assert "release its key" in robot.message()
    robot.press("")
    robot.hold(2.0, "high")
    assert robot.positions["front_left"] == pytest.approx(-1.2)


def test_a_preset_that_is_pressed_during_a_flipper_key_does_nothing(robot):
    for tick in range(50):
        if tick % 2 == 0:
            robot.jog(caller="b", rear_left=-RATE)
            assert not robot.press("high", caller="a")
        robot.step()
    assert robot.positions["front_left"] == 0.4
    assert robot.positions["rear_left"] < 0.1


def test_the_newer_of_two_operators_presets_wins(robot):
    robot.hold(0.5, "high", caller="a")
    for tick in range(300):
        if tick % 2 == 0:
            robot.press("nose_up", caller="b")
            robot.press("high", caller="a")
        robot.step()
    assert robot.positions["front_left"] == pytest.approx(1.0)
    assert robot.positions["rear_left"] > -0.3


def test_an_operators_stop_ends_the_presets_of_all(robot):
    robot.hold(0.5, "high", caller="a")
    robot.press("", caller="b")
    robot.hold(0.3, "high", caller="a")
    stopped = robot.positions["front_left"]
    robot.hold(1.0, "high", caller="a")
    assert robot.positions["front_left"] == stopped > -0.6
    assert "release its key" in robot.message()
    robot.press("", caller="a")
    robot.hold(0.5, "high", caller="a")
    assert robot.positions["front_left"] < stopped


def test_a_stop_lets_nobody_else_in_again(robot):
    robot.hold(0.3, "high", caller="a")
    robot.core.set_e_stop(True)
    robot.hold(0.1, "high", caller="a")
    robot.core.set_e_stop(False)
    robot.press("", caller="b")
    before = dict(robot.positions)
    robot.hold(1.0, "high", caller="a")
    assert robot.positions == before


# ---- goals


def test_state_names_who_is_obeyed(robot):
    def commanders():
        return robot.core.state(robot.time).commanders

    robot.jog(caller="pad", front_left=0.1)
    assert commanders() == ("pad",)
    robot.jog(caller="pad", front_left=0.0)
    robot.run(0.5)
    assert commanders() == ()
    robot.hold(0.1, "high", caller="console 3")
    assert commanders() == ("console 3",)
    robot.press("", caller="console 3")
    robot.run(0.5)
    robot.goal("high")
    robot.run(0.2)
    assert commanders() == ("goal",)


def test_a_goal_moves_reports_and_is_reached(robot):
    number = robot.goal("high")
    robot.run(0.8)
    assert robot.active()
    told, remaining = robot.core.requests.goals.progress()
    assert told == number
    assert set(remaining) == set(JOINTS)
    assert -1.6 < remaining["front_left"] < -0.5
    robot.run(1.5)
    (end,) = robot.ended()
    assert (end.number, end.end, end.message) == (number, GoalEnd.REACHED, "")
    assert end.remaining == pytest.approx(dict.fromkeys(JOINTS, 0.0), abs=0.01)
    assert robot.core.requests.goals.progress() is None
    assert not robot.active()


def test_a_goal_at_its_angles_is_reached_at_once(robot):
    robot.positions.update(front_left=1.0, front_right=1.0)
    robot.run(0.1)
    robot.goal("nose_up")
    robot.run(0.05)
    assert [end.end for end in robot.ended()] == [GoalEnd.REACHED]


def test_a_goal_ends_with_a_pause_of_the_simulation(robot):
    robot.goal("high")
    robot.run(0.3)
    before = robot.positions["rear_left"]
    for _ in range(200):
        robot.time += DT
        robot.last = robot.core.update(robot.time, robot.time + 50.0, robot.positions)
        robot.positions.update(robot.last)
    (end,) = robot.ended()
    assert (end.end, end.message) == (GoalEnd.ABORTED, "the simulation was paused")
    # the way of braking
    assert robot.positions["rear_left"] > before - RATE**2 / 8.0 - 0.02


def test_a_goal_ends_while_the_pause_lasts(robot):
    robot.goal("high")
    robot.run(0.3)
    robot.core.end_goal_in_pause(robot.time + 2 * TIMEOUT - 0.01)
    assert robot.ended() == []
    robot.core.end_goal_in_pause(robot.time + 2 * TIMEOUT + 0.01)
    assert [end.message for end in robot.ended()] == ["the simulation was paused"]


def test_a_cancelled_goal_stops(robot):
    number = robot.goal("high")
    robot.run(0.8)
    robot.core.requests.goals.cancel(number + 1)
    assert robot.ended() == []
    robot.core.requests.goals.cancel(number)
    assert [end.end for end in robot.ended()] == [GoalEnd.CANCELLED]
    before = robot.positions["front_left"]
    robot.run(1.0)
    # the way of braking
    assert robot.positions["front_left"] == pytest.approx(before - RATE**2 / 8.0, abs=0.02)


def test_a_newer_goal_replaces_the_present_one(robot):
    first, second = robot.goal("high"), robot.goal("flat")
    (end,) = robot.ended()
    assert (end.number, end.end) == (first, GoalEnd.CANCELLED)
    assert "newer goal" in end.message
    robot.run(2.0)
    assert [(end.number, end.end) for end in robot.ended()] == [(second, GoalEnd.REACHED)]


@pytest.mark.parametrize(
    ("act", "says"),
    [
        (lambda robot: robot.jog(caller="b", rear_left=0.2), "by hand"),
        (lambda robot: robot.jog(caller="b", rear_left=0.0), "stopped by an operator"),
        (lambda robot: robot.press("", caller="b"), "stopped by an operator"),
        (lambda robot: robot.press("nose_up", caller="b"), "a preset key"),
        (lambda robot: robot.core.set_e_stop(True), "the e-stop is active"),
        (lambda robot: robot.core.restart(robot.time), "put somewhere else"),
    ],
)
def test_what_ends_a_goal(robot, act, says):
    robot.goal("high")
    robot.run(0.5)
    act(robot)
    (end,) = robot.ended()
    assert end.end is GoalEnd.ABORTED
    assert says in end.message
    robot.run(2.0)
    assert robot.positions["rear_left"] > -0.5
    assert robot.ended() == []


def test_a_goal_against_an_obstacle_is_given_up(robot):
    robot.stops["front_right"] = 0.6
    robot.goal("nose_up")
    robot.run(1.2 + STALL)
    (end,) = robot.ended()
    assert end.end is GoalEnd.ABORTED
    assert "no progress" in end.message
    assert "front_right +0.40 rad" in end.message
    assert "front_left" not in end.message
    robot.run(0.5)
    assert robot.last == {}


def test_a_slow_goal_is_not_given_up(robot):
    robot.core.speed.set(0.05)
    robot.goal("nose_up")
    robot.run(15.0)
    assert [end.end for end in robot.ended()] == [GoalEnd.REACHED]


def test_goals_are_rejected_while_nothing_is_obeyed(robot):
    robot.core.set_e_stop(True)
    with pytest.raises(InvalidCommand, match="the e-stop is active"):
        robot.goal("flat")
    robot.core.set_e_stop(False)
    robot.jog(front_left=0.5)
    with pytest.raises(InvalidCommand, match="by hand"):
        robot.goal("flat")
    with pytest.raises(InvalidCommand, match="no joint_states yet"):
        Robot().goal("flat")
    new = Robot()
    new.run(0.1)
    with pytest.raises(InvalidCommand, match="just started"):
        new.goal("flat")


def test_a_key_that_is_held_when_a_goal_begins_needs_a_new_press(robot):
    robot.hold(0.3, "high")
    robot.goal("nose_up")
    robot.hold(2.0, "high")
    assert [end.end for end in robot.ended()] == [GoalEnd.REACHED]
    assert robot.positions["front_left"] == pytest.approx(1.0)


# ---- settings

CONFIG = Path(__file__).parents[2] / "config"
FILES = [CONFIG / "flipper_teleop.yaml", CONFIG / "flipper_presets.yaml"]


def shipped(**changes):
    values = {}
    for file in FILES:
        values.update(yaml.safe_load(file.read_text()))
    return read_config(FlipperTeleopSettings, {**values, **changes}, "f")


def limits(lower=-1.88, upper=1.98):
    joints = shipped().joints
    return dict.fromkeys(joints, JointBounds("revolute", lower, upper, 1.0))


def test_the_shipped_presets():
    settings = shipped()
    table = settings.preset_table(settings.axes(limits()))
    assert list(table) == ["flat", "drive", "approach", "climb", "descend", "high", "folded"]
    for preset in table.values():
        assert set(preset.positions) == set(settings.joints)
        assert preset.description
    assert set(table["flat"].positions.values()) == {0.01}


def test_drive_and_folded_are_those_of_the_named_poses():
    poses = CONFIG.parents[1] / "telex_description" / "config" / "poses.yaml"
    poses = yaml.safe_load(poses.read_text())["poses"]
    settings = shipped()
    table = settings.preset_table(settings.axes(limits()))
    for preset, pose in (("drive", "drive"), ("folded", "stow")):
        for joint, angle in table[preset].positions.items():
            assert poses[pose][joint] == angle


PRESET = {"name": "up", "positions": {"front_left_flipper_joint": 1.0}}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"presets": [PRESET, PRESET]}, r"presets\[1\]/name is 'up' as of one before"),
        ({"presets": [{**PRESET, "name": "to top"}]}, "name is 'to top'; letters"),
        ({"presets": [{**PRESET, "positions": {}}]}, "positions is empty"),
        (
            {"presets": [{**PRESET, "positions": {"leg": 1.0}}]},
            r"presets\[0\]/positions/leg is unk",
        ),
        ({"presets": [{**PRESET, "speed": 1.0}]}, r"presets\[0\]/speed is unknown"),
        (
            {"presets": [{**PRESET, "positions": {"front_left_flipper_joint": math.nan}}]},
            "is nan",
        ),
        ({"goal_tolerance": 0.0}, "goal_tolerance is 0.0"),
        ({"stall_time": -1.0}, "stall_time is -1.0"),
    ],
)
def test_bad_presets_are_refused(changes, says):
    with pytest.raises(ConfigError, match=says):
        shipped(**changes)


def test_a_preset_out_of_reach_is_refused_with_its_place():
    settings = shipped()
    says = r"presets\[6\]/positions/front_left_flipper_joint is 1.945 \(folded\); .* to 1.498"
    with pytest.raises(ConfigError, match=says):
        settings.preset_table(settings.axes(limits(upper=1.5)))


def test_a_robot_without_rear_flippers_keeps_the_rest_of_the_presets():
    settings = shipped()
    front = {joint: limit for joint, limit in limits().items() if joint.startswith("front")}
    table = settings.preset_table(settings.axes(front))
    assert set(table["high"].positions) == set(front)
