"""The arm's three ways to move: modes, named poses, what is near, stops."""

import numpy as np
import pytest
from arm_rig import JOINTS, LIMITS, POSES, TICK, Rig, base_at, pose, tool_motion, twist

from telex_teleop.arm.arm_teleop import ArmTeleop, Carrier, ModeError
from telex_teleop.arm.base_pose import BasePose
from telex_teleop.arm.proximity import (
    ProximityGuard,
    ProximityPair,
    ProximitySettings,
    ProximityState,
)
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.speed import SpeedScale

pytestmark = pytest.mark.slow

AHEAD = twist("base", 0.1, 0.0, 0.0)


def jog(validity=None, **rates):
    return JogCommand(rates, {}, validity)


def displace(**increments):
    return JogCommand({}, increments, None)


class TestModes:
    def test_begins_in_joint_mode(self):
        rig = Rig()
        assert rig.core.mode == "JOINT"
        rig.run(0.5, jog(x=0.2))
        assert rig.positions["x"] > 0.05

    def test_tool_is_not_moved_in_joint_mode(self):
        rig = Rig()
        with pytest.raises(InvalidCommand, match="the mode is JOINT; set CARTESIAN"):
            rig.core.receive_tool(AHEAD, rig.time, "/gui")
        assert "set CARTESIAN" in rig.state().message
        rig.run(1.1)
        assert rig.state().message == ""

    def test_joints_of_the_tool_are_not_jogged_in_cartesian_mode(self):
        rig = Rig().cartesian()
        with pytest.raises(InvalidCommand, match="x, yaw carry the tool"):
            rig.core.receive(jog(x=0.1, camera=0.1, yaw=0.1), rig.time, "/gui")
        rig.run(0.5)
        assert rig.positions["camera"] == 0.0

    def test_other_joints_are_jogged_in_both_modes(self):
        rig = Rig().cartesian()
        rig.run(0.5, jog(camera=1.0))
        assert rig.positions["camera"] > 0.2

    def test_stop_of_a_joint_is_obeyed_in_cartesian_mode(self):
        rig = Rig().cartesian()
        assert rig.core.receive(jog(x=0.0), rig.time, "/gui") == frozenset()

    def test_unknown_mode_is_refused(self):
        with pytest.raises(ModeError, match="'FLY' is unknown; must be JOINT or CARTESIAN"):
            Rig().core.set_mode("FLY")

    def test_mode_waits_for_the_kinematics_and_joints_do_not(self):
        rig = Rig(attach=False)
        rig.core.prepare("warming up: the kinematics are being compiled")
        with pytest.raises(ModeError, match="warming up.*the mode stays JOINT"):
            rig.core.set_mode("CARTESIAN")
        assert "CARTESIAN mode: warming up" in rig.state().notice
        rig.run(0.5, jog(x=0.2))
        assert rig.positions["x"] > 0.05
        rig.core.attach(tool_motion())
        rig.cartesian().run(0.5, AHEAD)
        assert "warming up" not in rig.state().notice

    def test_change_of_mode_in_motion_brakes_on_the_ramp(self):
        rig = Rig()
        rig.run(0.6, jog(x=0.5, yaw=1.0))
        rig.core.set_mode("CARTESIAN")
        rig.run(0.6, twist("base", 0.0, 0.2, 0.0))
        rig.core.set_mode("JOINT")
        rig.run(0.6, jog(z=0.3))
        rig.run(0.8)
        rig.check_limits()
        assert rig.positions["y"] > 0.02
        assert rig.positions["z"] > 0.05

    def test_desired_pose_begins_where_the_joints_are(self):
        rig = Rig().cartesian()
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        rig.core.set_mode("JOINT")
        rig.run(0.8, jog(y=0.3))
        rig.run(0.8)
        there = rig.q
        rig.cartesian().run(0.3, AHEAD)
        rig.run(1.0)
        assert rig.q[1:] == pytest.approx(there[1:], abs=1e-9)

    def test_somebody_else_moved_the_arm(self):
        rig = Rig().cartesian()
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        # a controller of another program took it there, slowly
        for _ in range(100):
            rig.positions["z"] += 0.002
            rig.run(TICK)
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        assert rig.positions["z"] == pytest.approx(0.2)

    def test_somebody_else_moved_some_joints_much_and_others_little(self):
        rig = Rig().cartesian()
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        rig.positions["z"] += 0.05
        rig.positions["yaw"] += 0.01  # less than what a joint may be off its reference
        rig.run(0.2)
        there = rig.q
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        assert rig.q[1:] == pytest.approx(there[1:], abs=1e-9)

    def test_joint_that_sags_does_not_creep(self):
        rig = Rig().cartesian()
        for _ in range(3):
            rig.run(0.3, AHEAD)
            rig.run(1.0)
            rig.positions["z"] -= 0.001
            rig.run(0.1)
        rig.run(0.3, AHEAD)
        rig.run(1.0)
        assert rig.positions["z"] == 0.0

    def test_robot_without_an_arm_is_jogged_all_the_same(self):
        axes = {"camera": AxisSettings(LIMITS[3], 0.5)}
        lacking = Carrier(lacking="not available for this robot: no tool_link")
        guard, base = ProximityGuard(ProximitySettings()), BasePose(0.25)
        core = ArmTeleop(axes, lacking, 0.28, 0.5, SpeedScale(), guard, base)
        with pytest.raises(ModeError, match="not available for this robot"):
            core.set_mode("CARTESIAN")
        sent = {}
        for tick in range(150):
            if tick > 70:  # it is deaf at first
                core.receive(jog(camera=1.0), 0.01 * tick)
            sent = core.update(0.01 * tick, 0.01 * tick, {"camera": sent.get("camera", 0.0)})
        assert sent["camera"] > 0.2


class TestNewestWins:
    def test_twist_after_named_pose(self):
        rig = Rig().cartesian()
        rig.run(1.0, "side")
        rig.run(1.5, AHEAD)
        assert rig.core.tool.moving
        rig.check_limits()

    def test_jog_after_named_pose(self):
        rig = Rig()
        rig.run(1.0, "side")
        rig.run(1.5, jog(z=-0.3))
        rig.run(1.0)
        assert rig.positions["z"] < -0.1
        rig.check_limits()

    def test_named_pose_after_twist(self):
        rig = Rig().cartesian()
        rig.run(1.0, twist("base", 0.0, 0.2, 0.0))
        rig.run(6.0, "side")
        assert rig.q == pytest.approx(POSES["side"], abs=1e-6)
        rig.check_limits()

    def test_another_pose_in_motion(self):
        rig = Rig()
        rig.run(1.0, "side")
        rig.run(4.0, "home")
        assert rig.q == pytest.approx(POSES["home"], abs=1e-6)
        rig.check_limits()


class TestNamedPose:
    def test_all_joints_go_straight_and_together(self):
        rig = Rig()
        begin = len(rig.history)
        rig.run(4.0, "side")
        path, goal = rig.path(begin), np.array(POSES["side"])
        assert path[-1] == pytest.approx(goal, abs=1e-6)
        share = path @ goal / (goal @ goal)
        assert np.abs(path - np.outer(share, goal)).max() < 1e-9
        assert np.all(np.diff(share) >= 0.0)
        rig.check_limits()

    def test_slowest_joint_runs_at_its_limit(self):
        rig = Rig()
        rig.run(0.6, "side")
        speed = np.abs(rig.path()[-1] - rig.path()[-2]) / TICK
        shares = speed / [each.max_velocity for each in LIMITS]
        assert shares.max() == pytest.approx(1.0, rel=1e-6)

    def test_speed_scale_counts(self):
        rig = Rig()
        rig.core.speed.set(0.2)
        rig.run(0.6, "side")
        speed = np.abs(rig.path()[-1] - rig.path()[-2]) / TICK
        assert (speed / [each.max_velocity for each in LIMITS]).max() == pytest.approx(0.2)

    def test_stops_when_the_key_is_let_go_and_goes_on_later(self):
        rig = Rig()
        rig.run(0.3, "side")
        rig.run(1.5)
        halfway = rig.q
        assert rig.sent == {}
        assert 0.05 < halfway[0] < 0.35
        rig.run(0.5)
        assert np.array_equal(rig.q, halfway)
        rig.run(4.0, "side")
        assert rig.q == pytest.approx(POSES["side"], abs=1e-6)
        assert "in pose side" in rig.state().notice

    def test_stop_message_ends_it_at_once(self):
        rig = Rig()
        rig.run(0.5, "side")
        before = rig.positions["x"]
        rig.core.receive_pose_name("", rig.time, "/operator")
        rig.run(1.0)
        assert rig.positions["x"] - before < 0.5 * 0.25 + 0.01

    def test_unknown_pose_is_refused(self):
        rig = Rig()
        with pytest.raises(InvalidCommand, match="pose 'moon' is unknown; known are home, side"):
            rig.core.receive_pose_name("moon", rig.time, "/gui")

    def test_does_not_move_other_joints(self):
        rig = Rig(camera=0.3)
        rig.run(2.0, "side")
        assert rig.positions["camera"] == 0.3

    def test_waits_for_a_joint_that_is_blocked(self):
        rig = Rig()

        def block(_):
            rig.positions["x"] = 0.0

        rig.run(2.0, "side", each=block)
        assert rig.sent["x"] <= LIMITS[0].max_lead + 1e-9
        assert "something holds x back" in rig.state().notice


class TestStops:
    WAYS = (
        ("JOINT", jog(x=0.3)),
        ("CARTESIAN", AHEAD),
        ("CARTESIAN", pose("base", (0.9, 0.0, 0.0))),
        ("JOINT", "side"),
    )

    @pytest.mark.parametrize(("mode", "command"), WAYS)
    def test_e_stop_ends_it_and_latches(self, mode, command):
        rig = Rig()
        rig.core.set_mode(mode)
        rig.run(0.5, command)
        rig.core.set_e_stop(True)
        before = rig.q
        rig.run(0.3, command)
        rig.core.set_e_stop(False)
        rig.run(0.5, command)  # the key is still held
        assert np.array_equal(rig.q, before)
        assert "release the key" in rig.state().message
        rig.run(0.5)
        rig.run(0.5, command)
        assert not np.array_equal(rig.q, before)

    @pytest.mark.parametrize(("mode", "command"), WAYS)
    def test_silence_ends_it(self, mode, command):
        rig = Rig()
        rig.core.set_mode(mode)
        rig.run(0.5, command)
        rig.run(1.2)
        before = rig.q
        rig.run(0.5)
        assert np.array_equal(rig.q, before)
        assert not rig.state().active

    @pytest.mark.parametrize(("mode", "command"), WAYS)
    def test_reset_ends_it_and_nothing_goes_back(self, mode, command):
        rig = Rig()
        rig.core.set_mode(mode)
        rig.run(0.5, command)
        rig.core.restart(rig.time)
        rig.positions.update(dict.fromkeys(JOINTS, 0.0))
        rig.run(0.5, command)
        assert rig.q == pytest.approx(np.zeros(6))

    @pytest.mark.parametrize(("mode", "command"), WAYS)
    def test_one_operator_does_not_end_the_latch_of_another(self, mode, command):
        rig = Rig()
        rig.core.set_mode(mode)
        rig.run(0.5, command, caller="/first")
        rig.core.set_e_stop(True)
        rig.core.set_e_stop(False)
        before = rig.q
        rig.run(0.4, command, caller="/first")
        assert np.array_equal(rig.q, before)


def near(distance, stamp, touchable=False, **gradient):
    pair = ProximityPair("gripper_link", "base_link", touchable, distance, gradient)
    return ProximityState(stamp, dict.fromkeys(gradient, 0.0), (pair,))


class TestGuard:
    """A wall at x = 0.3: its distance is 0.3 - x."""

    @pytest.fixture
    def rig(self):
        return Rig(proximity=ProximitySettings(stop_distance=0.02))

    @staticmethod
    def wall(rig, touchable=False):
        def report(time):
            x = rig.positions["x"]
            pair = ProximityPair("gripper_link", "base_link", touchable, 0.3 - x, {"x": -1.0})
            rig.guard.take(ProximityState(time, {"x": x}, (pair,)))

        return report

    @pytest.mark.parametrize(("mode", "command"), [*TestStops.WAYS[:3], ("JOINT", "side")])
    def test_slows_and_stops_before_it(self, rig, mode, command):
        rig.core.set_mode(mode)
        rig.run(6.0, command, each=self.wall(rig))
        assert 0.265 < rig.positions["x"] <= 0.281
        notice = rig.state().notice
        assert "stopped: gripper_link is 2" in notice
        assert "mm from base_link" in notice
        rig.check_limits()

    @pytest.mark.parametrize(
        ("mode", "back"), [("JOINT", jog(x=-0.3)), ("CARTESIAN", twist("base", -0.1, 0.0, 0.0))]
    )
    def test_motion_away_is_free_however_near(self, rig, mode, back):
        rig.positions["x"] = 0.31  # inside the wall
        rig.run(0.6)
        rig.core.set_mode(mode)
        rig.run(0.6, back, each=self.wall(rig))
        speed = (rig.path()[-1] - rig.path()[-2])[0] / TICK
        assert speed == pytest.approx(-0.3 if mode == "JOINT" else -0.1, rel=1e-6)

    def test_twist_whose_square_is_0_moves_nothing(self, rig):
        rig.positions["x"] = 0.29  # nearer than it may come
        rig.run(0.6)
        rig.cartesian().run(0.6, twist("base", 1e-200, 0.0, 0.0), each=self.wall(rig))
        assert rig.positions["x"] == pytest.approx(0.29)

    def test_joint_that_does_not_close_in_moves_on(self, rig):
        rig.run(4.0, jog(x=0.3, y=0.1), each=self.wall(rig))
        assert rig.positions["x"] < 0.281
        assert rig.positions["y"] > 0.35

    @pytest.mark.parametrize(("mode", "command"), [*TestStops.WAYS[:3], ("JOINT", "side")])
    def test_what_may_touch_touches_slowly_and_presses_no_deeper_than_it_may(
        self, rig, mode, command
    ):
        rig.core.set_mode(mode)
        begin = len(rig.history)
        rig.run(7.0, command, each=self.wall(rig, touchable=True))
        x = rig.path(begin)[:, 0]
        touched = int(np.argmax(x > 0.3))
        assert (x[touched] - x[touched - 1]) / TICK == pytest.approx(0.05, rel=0.05)
        assert 0.312 < x.max() < 0.3155
        assert "stopped: gripper_link presses on base_link" in rig.state().notice
        rig.check_limits()

    @pytest.mark.parametrize("touchable", [False, True])
    def test_tool_slides_along_what_it_must_not_run_into(self, rig, touchable):
        rig.cartesian()
        begin = len(rig.history)
        rig.run(5.0, twist("base", 0.1, 0.1, 0.0), each=self.wall(rig, touchable))
        path = rig.path(begin)
        assert 0.26 < path[-1, 0] < (0.316 if touchable else 0.281)
        assert (path[-1] - path[-2])[1] / TICK == pytest.approx(0.1, rel=0.02)
        assert np.abs(path[:, 2:]).max() < 1e-6
        assert "slowed: gripper_link" in rig.state().notice
        rig.check_limits()

    def test_tool_that_turns_is_slowed_and_does_not_evade(self, rig):
        def report(time):
            yaw = rig.positions["yaw"]
            pair = ProximityPair("gripper_link", "base_link", False, 0.1 - 0.2 * yaw, {"yaw": -0.2})
            rig.guard.take(ProximityState(time, {"yaw": yaw}, (pair,)))

        rig.cartesian().run(5.0, twist("base", 0.0, 0.0, 0.0, 0.0, 0.0, 0.5), each=report)
        assert 0.35 < rig.positions["yaw"] <= 0.401
        assert np.abs(rig.q[:3]).max() < 1e-9
        assert "stopped: gripper_link is 20 mm from base_link" in rig.state().notice

    def test_way_to_a_pose_stays_straight_and_stops(self, rig):
        begin = len(rig.history)
        rig.cartesian().run(6.0, pose("base", (0.5, 0.2, 0.0)), each=self.wall(rig))
        path = rig.path(begin)
        assert path[-1, 0] <= 0.281
        assert np.abs(path[:, 1] - 0.4 * path[:, 0]).max() < 1e-3
        assert "stopped" in rig.state().notice

    def test_can_be_switched_off(self, rig):
        rig.guard.enabled = False
        rig.run(1.5, jog(x=0.3), each=self.wall(rig))
        assert rig.positions["x"] > 0.3
        assert "guard" not in rig.state().notice

    def test_place_in_the_world_is_given_up_where_the_arm_would_run_into_its_base(self, rig):
        begin = rig.time
        wall = self.wall(rig)

        def report(time):
            wall(time)
            rig.base.take(time, base_at(min(0.1 * (begin - time), 0.0)))  # the base reverses

        rig.base.take(rig.time, base_at())
        rig.cartesian().core.hold_tool(True)
        rig.run(6.0, each=report)
        assert 0.265 < rig.positions["x"] <= 0.281
        notice = rig.state().notice
        assert "stopped: gripper_link is 20 mm from base_link" in notice
        assert "mm from the place that it is to keep" in notice
        rig.check_limits()

    def test_what_the_base_does_counts_against_what_stands_in_the_world(self, rig):
        def wall(time, speed):
            pair = ProximityPair(
                "gripper_link", "wall", False, 0.06, {"x": -1.0}, (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            )
            rig.guard.take(ProximityState(time, {"x": rig.positions["x"]}, (pair,)))
            rig.base.take(time, base_at(speed * time))

        speeds = {}
        for base_speed in (0.0, 0.1, -0.1):
            rig.run(0.6, each=lambda time, v=base_speed: wall(time, v))
            rig.run(0.5, jog(x=0.4), each=lambda time, v=base_speed: wall(time, v))
            speeds[base_speed] = (rig.path()[-1] - rig.path()[-2])[0] / TICK
        # 6 cm before a wall: sqrt(2 * 0.5 m/s2 * (0.06 m - 0.02 m)), and what the base adds
        assert speeds[0.0] == pytest.approx(0.2, rel=0.01)
        assert speeds[0.1] == pytest.approx(0.1, rel=0.02)
        assert speeds[-0.1] == pytest.approx(0.3, rel=0.02)

    def test_arm_that_the_base_drives_against_something_is_named(self, rig):
        def drive(time):
            pair = ProximityPair(
                "elbow_link", "wall", False, 0.05, {}, (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            )
            rig.guard.take(ProximityState(time, {"x": 0.0}, (pair,)))
            rig.base.take(time, base_at(0.5 * time))

        rig.run(0.3, each=drive)
        assert rig.state().notice == "the base drives: elbow_link is 50 mm from wall"

    def test_silence_of_the_guard_is_told_and_does_not_stop_the_arm(self, rig):
        rig.run(0.5, each=self.wall(rig))
        assert "guard" not in rig.state().notice
        rig.run(0.5, jog(x=0.3))
        assert "no proximity guard" in rig.state().notice
        assert rig.positions["x"] > 0.05

    def test_displacement_that_is_stopped_does_not_go_on_when_the_way_is_free(self, rig):
        rig.core.receive(displace(x=0.45), rig.time, "/gui")
        rig.run(5.0, each=self.wall(rig))
        assert rig.positions["x"] <= 0.281
        before = rig.positions["x"]
        rig.guard.enabled = False
        rig.run(2.0)
        assert rig.positions["x"] == before


class TestWorld:
    def test_command_in_the_world_needs_a_base(self):
        rig = Rig().cartesian()
        with pytest.raises(InvalidCommand, match="pose of the base in the world is not known"):
            rig.core.receive_tool(twist("world", 0.1, 0.0, 0.0), rig.time, "/gui")
        with pytest.raises(ModeError, match="pose of the base in the world is not known"):
            rig.core.hold_tool(True)

    def test_stale_base_counts_as_none(self):
        rig = Rig().cartesian()
        rig.base.take(rig.time, base_at())
        rig.run(0.4)
        with pytest.raises(InvalidCommand):
            rig.core.receive_tool(twist("world", 0.1, 0.0, 0.0), rig.time, "/gui")

    def test_tool_is_held_in_cartesian_mode_only(self):
        rig = Rig()
        rig.base.take(rig.time, base_at())
        with pytest.raises(ModeError, match="CARTESIAN mode only"):
            rig.core.hold_tool(True)

    def test_base_is_carried_on_between_its_reports(self):
        rig = Rig()
        rig.base.take(1.0, base_at(1.0))
        rig.base.take(1.02, base_at(1.02))
        assert rig.base.at(1.05)[0, 3] == pytest.approx(1.05)
        assert rig.base.at(1.5) is None
        rig.base.forget()
        assert rig.base.at(1.02) is None


def test_joint_state_with_nothing_new_changes_nothing():
    rig = Rig().cartesian()
    rig.run(0.5, AHEAD)
    assert rig.core.update(rig.time, rig.time, dict(rig.positions)) == {}
