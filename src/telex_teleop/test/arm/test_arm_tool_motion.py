"""The tool's motion on a gantry: directions, speeds, limits, poses, the place in the world."""

import math
import re

import numpy as np
import pytest
from arm_rig import (
    ANGULAR,
    LIMITS,
    SETTINGS,
    TICK,
    Gantry,
    Rig,
    base_at,
    pose,
    tool_motion,
    twist,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from telex_control.common.geometry.matrices import inverse
from telex_control.common.params import ConfigError
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.motion.rigid_motion import advanced, pose_error

pytestmark = pytest.mark.slow


@pytest.fixture
def rig():
    return Rig(yaw=0.5, pitch=0.3, roll=-0.2).cartesian()


def moved(rig, command, duration=1.0, **more):
    """Hold a command for a while, let it go; return the step from start to end."""
    start = rig.pose
    rig.run(duration, command, **more)
    rig.run(0.8, **more)
    return pose_error(rig.pose, start)


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_twist_in_the_base_moves_along_its_axis_at_its_rate(rig, axis, sign):
    rates = [0.0] * 6
    rates[axis] = sign * (0.1 if axis < 3 else 0.3)
    step = moved(rig, twist("base", *rates))
    # 1 s and the watchdog's 0.28 s at the full rate, less the ramp up, with the ramp down
    assert step[axis] == pytest.approx(1.28 * rates[axis], rel=0.02)
    assert np.abs(np.delete(step, axis)).max() < 1e-6
    rig.check_limits()


@pytest.mark.parametrize("axis", range(6))
def test_twist_in_the_tool_moves_along_the_axes_of_the_tool(rig, axis):
    rates = [0.0] * 6
    rates[axis] = 0.1
    turned = rig.pose[:3, :3]
    step = moved(rig, twist("tool", *rates))
    local = np.concatenate([turned.T @ step[:3], turned.T @ step[3:]])
    assert local[axis] == pytest.approx(0.128, rel=0.02)
    assert np.abs(np.delete(local, axis)).max() < 1e-6


def test_twist_in_the_world_takes_the_base_turn_into_account(rig):
    def report(time):
        rig.base.take(time, base_at(3.0, 2.0, yaw=math.pi / 2))

    report(rig.time)
    step = moved(rig, twist("world", 0.1, 0.0, 0.0), each=report)
    assert step[1] == pytest.approx(-0.128, rel=0.02)
    assert np.abs(np.delete(step, 1)).max() < 1e-6


def test_speed_scale_scales_the_tool(rig):
    rig.core.speed.set(0.25)
    step = moved(rig, twist("base", 0.1, 0.0, 0.0))
    assert step[0] == pytest.approx(0.25 * 0.128, rel=0.02)


def test_speed_is_clamped_in_length_and_keeps_its_direction(rig):
    start = rig.pose
    rig.run(1.0, twist("base", 3.0, 4.0, 0.0))
    speed = (rig.path()[-1] - rig.path()[-2])[:3] / TICK
    assert np.linalg.norm(speed) == pytest.approx(SETTINGS.max_linear, rel=1e-6)
    step = pose_error(rig.pose, start)
    assert step[1] / step[0] == pytest.approx(4.0 / 3.0, rel=1e-6)


def test_starts_and_stops_on_a_ramp_without_a_jump(rig):
    rig.run(1.0, twist("base", 0.2, 0.0, 0.0))
    rig.run(1.0)
    speed = np.diff(rig.path()[:, 0]) / TICK
    change = np.diff(speed) / TICK
    assert np.abs(change).max() <= SETTINGS.max_linear / SETTINGS.acceleration_time * (1 + 1e-6)
    assert speed[-1] == 0.0
    assert rig.sent == {}
    assert not rig.core.tool.moving


def test_line_goes_on_exactly_after_a_rest(rig):
    start = rig.pose
    for _ in range(3):
        rig.run(0.5, twist("base", 0.05, 0.05, 0.0, 0.2, 0.0, 0.0))
        rig.run(1.0)
    step = pose_error(rig.pose, start)
    assert step[0] == pytest.approx(step[1], abs=1e-9)
    assert abs(step[2]) < 1e-9


class TestBoundary:
    def push(self, rig, duration=4.0, *more):
        rig.run(duration, twist("base", 0.2, *(more or (0.0, 0.0))))

    def test_slows_down_before_a_limit_and_says_which_joint_and_how_far(self):
        rig = Rig(x=0.9).cartesian()
        rig.run(0.7, twist("base", 0.2, 0.0, 0.0))
        notice = rig.state().notice
        room = 1000.0 * (1.0 - rig.positions["x"])
        assert 5.0 < room < 60.0
        assert "slowed to" in notice
        assert "x is " in notice
        said = float(notice.split("x is ")[1].split(" mm from its limit")[0])
        # it was told a moment ago
        assert said == pytest.approx(room, abs=8.0)
        speed = np.diff(rig.path()[:, 0])[-1] / TICK
        assert 0.0 < speed < 0.15

    def test_comes_to_the_limit_smoothly_and_stays(self):
        rig = Rig(x=0.8).cartesian()
        self.push(rig)
        assert 0.99 < rig.positions["x"] <= 1.0
        rig.check_limits()

    def test_slides_along_a_limit(self):
        rig = Rig(x=1.0).cartesian()
        self.push(rig, 2.0, 0.2, 0.0)
        assert rig.positions["y"] > 0.05
        assert rig.positions["x"] == pytest.approx(1.0, abs=1e-6)
        assert rig.positions["z"] == 0.0

    def test_returns_without_delay_however_long_it_was_pushed(self):
        rig = Rig(x=1.0).cartesian()
        self.push(rig, 10.0)
        before = rig.positions["x"]
        rig.run(1.0)
        rig.run(0.5, twist("base", -0.2, 0.0, 0.0))
        assert rig.positions["x"] < before - 0.04

    def test_orientation_is_kept_within_its_lead_while_pushing(self):
        rig = Rig(x=0.95, yaw=1.3).cartesian()
        start = rig.pose
        rig.run(4.0, twist("base", 0.2, 0.0, 0.0))
        assert np.linalg.norm(pose_error(rig.pose, start)[3:]) < SETTINGS.angular_lead

    def test_blocked_joint_holds_the_tool_and_is_named(self):
        rig = Rig().cartesian()
        stuck = {}

        def block(_):
            stuck.setdefault("y", rig.positions["y"])
            rig.positions["y"] = stuck["y"]

        rig.run(3.0, twist("base", 0.0, 0.2, 0.0), each=block)
        assert rig.sent["y"] <= stuck["y"] + LIMITS[1].max_lead + 1e-9
        assert "something holds y back" in rig.state().notice

    def test_slow_joint_slows_the_tool_and_is_named(self):
        slow = (*LIMITS[:5], type(ANGULAR)(-1.4, 1.4, 0.1, 0.4, 0.35, 0.02))
        motion = tool_motion(limits=slow)
        q = np.zeros(6)
        for _ in range(100):
            q = motion.update(TICK, twist("base", 0.0, 0.0, 0.0, 0.8, 0.0, 0.0), q, q, None, 1.0)
        assert motion.slowdown is not None
        assert motion.slowdown.share == pytest.approx(0.125, abs=0.02)
        assert "roll is as fast as it can be" in str(motion.slowdown)


class TestPose:
    def test_goes_along_a_straight_line_and_arrives(self, rig):
        start = rig.pose
        target = pose("base", (0.3, -0.2, 0.15), (0.1, 0.4, -0.3))
        rig.run(6.0, target)
        assert np.abs(pose_error(rig.pose, target.pose)).max() < 1e-5
        line = target.pose[:3, 3] - start[:3, 3]
        away = rig.path()[:, :3] - start[:3, 3]
        along = away @ line / (line @ line)
        assert np.abs(away - np.outer(along, line)).max() < 1e-6
        assert np.all(np.diff(along) >= -1e-12)
        rig.check_limits()

    def test_turning_ends_with_moving(self, rig):
        start = rig.pose
        target = pose("base", (0.3, -0.2, 0.15), (0.1, 0.4, -0.3))
        rig.run(1.0, target)
        way, turn = pose_error(target.pose, start)[:3], pose_error(target.pose, start)[3:]
        left = pose_error(target.pose, rig.pose)
        assert np.linalg.norm(left[:3]) / np.linalg.norm(way) == pytest.approx(
            np.linalg.norm(left[3:]) / np.linalg.norm(turn), abs=1e-4
        )

    def test_stops_when_the_stream_stops(self, rig):
        rig.run(0.6, pose("base", (0.9, 0.0, 0.0)))
        rig.run(1.0)
        assert 0.05 < rig.positions["x"] < 0.3
        assert rig.sent == {}

    def test_runs_at_the_operators_speed(self, rig):
        rig.core.speed.set(0.5)
        rig.run(1.5, pose("base", (0.9, 0.0, 0.0)))
        speed = (rig.path()[-1] - rig.path()[-2])[0] / TICK
        assert speed == pytest.approx(0.5 * SETTINGS.max_linear, rel=0.01)

    def test_in_the_tool_is_measured_from_where_the_stream_began(self, rig):
        start = rig.pose
        rig.run(4.0, pose("tool", (0.1, 0.0, 0.0)))
        local = start[:3, :3].T @ pose_error(rig.pose, start)[:3]
        assert local == pytest.approx([0.1, 0.0, 0.0], abs=1e-5)
        rig.run(1.0)
        rig.run(4.0, pose("tool", (0.1, 0.0, 0.0)))
        local = start[:3, :3].T @ pose_error(rig.pose, start)[:3]
        assert local == pytest.approx([0.2, 0.0, 0.0], abs=1e-5)

    def test_in_the_world_follows_the_base(self, rig):
        base = base_at(1.0, 0.5, yaw=0.3)

        def report(time):
            rig.base.take(time, base)

        report(rig.time)
        rig.run(6.0, pose("world", (1.4, 0.6, 0.1)), each=report)
        assert (base @ rig.pose)[:3, 3] == pytest.approx([1.4, 0.6, 0.1], abs=1e-5)


class TestPlaceInTheWorld:
    def drive(self, rig, duration, speed, turn=0.0):
        """Let the base drive on a circle, and return how far the tool moved in the world."""
        begin = rig.time
        rig.base.take(rig.time, base_at())
        worst = 0.0
        first = rig.pose

        def report(time):
            nonlocal worst
            travelled = time - begin
            # a report every second joint state, as the simulator sends them
            if round(time / TICK) % 2 == 0:
                rig.base.take(time, base_at(speed * travelled, 0.0, yaw=turn * travelled))

        rig.core.hold_tool(True)
        for _ in range(round(duration / 0.1)):
            rig.run(0.1, each=report)
            travelled = rig.time - begin
            base = base_at(speed * travelled, 0.0, yaw=turn * travelled)
            worst = max(worst, float(np.linalg.norm((base @ rig.pose - first)[:3, 3])))
        return worst

    def test_is_kept_while_the_base_drives_and_turns(self, rig):
        assert self.drive(rig, 3.0, 0.1, 0.1) < 0.012
        assert rig.positions["x"] < -0.25
        assert "keeps its place in the world" in rig.state().notice

    def test_is_given_up_gently_out_of_reach(self, rig):
        self.drive(rig, 8.0, 0.2)
        assert rig.positions["x"] >= -1.0
        rig.check_limits()
        rig.core.hold_tool(False)
        rig.run(1.0)
        assert rig.sent == {}

    def test_ends_with_the_e_stop_and_does_not_come_back(self, rig):
        self.drive(rig, 0.5, 0.1)
        rig.core.set_e_stop(True)
        rig.run(0.1)
        rig.core.set_e_stop(False)
        before = rig.q
        rig.run(1.0, each=lambda time: rig.base.take(time, base_at(5.0)))
        assert np.array_equal(rig.q, before)
        assert not rig.core.tool.holding

    def test_is_said_to_be_lost_when_nothing_tells_where_the_base_is(self, rig):
        self.drive(rig, 0.3, 0.1)
        rig.run(0.5)
        assert "the pose of the base in the world is unknown" in rig.state().notice
        before = rig.q
        rig.run(0.5)
        assert np.array_equal(rig.q, before)

    def test_limit_that_the_base_drives_a_joint_to_is_named(self, rig):
        self.drive(rig, 5.5, 0.2)
        notice = rig.state().notice
        assert re.search(r"slowed to \d %: x is \d mm from its limit", notice)
        assert "mm from the place that it is to keep" in notice

    def test_can_be_shifted_by_the_operator(self, rig):
        self.drive(rig, 0.3, 0.0)
        start = rig.pose
        rig.run(
            1.0,
            twist("base", 0.0, 0.1, 0.0),
            each=lambda time: rig.base.take(time, base_at()),
        )
        rig.run(1.0, each=lambda time: rig.base.take(time, base_at()))
        assert pose_error(rig.pose, start)[1] == pytest.approx(0.128, rel=0.03)


rates = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6)
moves = st.tuples(st.sampled_from(["tool", "base"]), rates, st.integers(1, 60))


@settings(max_examples=12, deadline=None)
@given(st.lists(moves, min_size=1, max_size=5), st.floats(0.05, 1.0))
def test_no_joint_ever_exceeds_its_limits_whatever_is_commanded(commands, scale):
    rig = Rig(x=0.9, z=-0.7, pitch=0.8).cartesian()
    rig.core.speed.set(scale)
    for frame, values, ticks in commands:
        rig.run(ticks * TICK, twist(frame, *values))
    rig.run(1.5)
    rig.check_limits()


def test_same_commands_give_the_same_references():
    runs = []
    for _ in range(2):
        rig = Rig(yaw=0.4).cartesian()
        rig.run(1.0, twist("tool", 0.1, -0.2, 0.05, 0.3, 0.1, -0.7))
        rig.run(1.0, pose("base", (0.2, 0.2, 0.0)))
        runs.append(rig.path())
    assert np.array_equal(*runs)


def test_inverse_and_steps_of_poses():
    first = advanced(np.eye(4), np.array([0.1, 0.2, 0.3, 0.4, -0.5, 0.6]))
    second = advanced(first, np.array([-0.3, 0.1, 0.0, 1.0, 2.0, -0.5]))
    assert inverse(first) @ first == pytest.approx(np.eye(4), abs=1e-12)
    assert advanced(first, pose_error(second, first)) == pytest.approx(second, abs=1e-12)
    assert Gantry().forward(np.zeros(6)) == pytest.approx(np.eye(4))


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"max_linear": 0.0}, "max_linear is 0.0"),
        ({"look_ahead": -1.0}, "look_ahead is -1.0"),
        ({"hold_lead": 0.001}, "hold_lead is 0.001"),
        ({"least_share": 0.5}, "least_share is 0.5"),
    ],
)
def test_bad_settings_are_refused(values, says):
    with pytest.raises(ConfigError, match=says):
        ToolSettings(**values)
