"""Core of the joint nodes: streams, watchdog, e-stop, resets and what a display is told."""

import pytest

from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.speed import SpeedScale

DT = 0.01
TIMEOUT = 0.28
LIMITS = MotionLimits(-2.0, 2.0, 0.6, 2.0, 0.2, 0.02)


class Robot:
    """A simulation whose joints follow their references, and a node."""

    def __init__(self, core, joints):
        self.core = core
        self.time = 100.0
        self.wall_offset = 0.0
        self.positions = dict.fromkeys(joints, 0.0)
        self.last = {}
        self.run(2 * TIMEOUT + DT)  # a new node is deaf for a while

    @property
    def wall(self):
        return self.time + self.wall_offset

    def step(self):
        self.time += DT
        self.last = self.core.update(self.time, self.wall, self.positions)
        self.positions.update(self.last)

    def run(self, duration):
        for _ in range(round(duration / DT)):
            self.step()

    def hold(self, duration, **rates):
        """Send velocities at 50 Hz, as a held key does."""
        for tick in range(round(duration / DT)):
            if tick % 2 == 0:
                self.send(**rates)
            self.step()

    def send(self, validity=None, caller="", **rates):
        self.core.receive(JogCommand(rates, {}, validity), self.wall, caller)

    def displace(self, **increments):
        self.core.receive(JogCommand({}, increments, None), self.wall)

    def message(self):
        return self.core.state(self.wall).message


@pytest.fixture
def robot():
    axes = {name: AxisSettings(LIMITS, 0.5) for name in ("a", "b")}
    return Robot(JointTeleop(axes, TIMEOUT, 0.5, SpeedScale()), axes)


def test_a_robot_without_these_joints_is_told_of():
    robot = Robot(JointTeleop({}, TIMEOUT, 0.5, SpeedScale()), ())
    assert robot.last == {}
    state = robot.core.state(robot.wall)
    assert (state.active, state.axes) == (False, ())
    assert "none of the joints" in state.message


def test_held_key_moves_at_the_rate_and_only_that_joint(robot):
    robot.hold(0.5, a=0.3)
    start = robot.positions["a"]
    robot.hold(1.0, a=0.3)
    assert robot.positions["a"] - start == pytest.approx(0.3, rel=1e-6)
    assert robot.positions["b"] == 0.0
    assert set(robot.last) == {"a"}


def test_state_names_who_is_obeyed(robot):
    robot.send(a=0.3, caller="/console")
    robot.send(b=0.3, caller="/pad")
    assert robot.core.state(robot.wall).commanders == ("/console", "/pad")
    robot.run(0.5)
    state = robot.core.state(robot.wall)
    assert (state.active, state.commanders) == (False, ())


def test_speed_scale_slows(robot):
    robot.core.speed.set(0.1)
    robot.hold(0.5, a=9.0)
    start = robot.positions["a"]
    robot.hold(1.0, a=9.0)
    assert robot.positions["a"] - start == pytest.approx(0.06, rel=1e-6)


def test_silence_stops_within_timeout_and_ramp(robot):
    robot.hold(1.0, a=0.6)
    robot.run(TIMEOUT - 0.04)  # the last message came 0.02 s before
    assert robot.core.axes["a"].generator.velocity == pytest.approx(0.6)
    robot.run(0.04)
    assert robot.core.axes["a"].generator.velocity < 0.6
    robot.run(0.3)
    assert robot.last == {}
    held = robot.positions["a"]
    robot.run(1.0)
    assert robot.positions["a"] == held


def test_zero_stops_at_once(robot):
    robot.hold(1.0, a=0.6)
    robot.send(a=0.0)
    robot.step()
    assert robot.core.axes["a"].generator.velocity < 0.6


def test_joints_have_streams_of_their_own(robot):
    robot.hold(0.5, a=0.3)
    robot.hold(1.0, b=0.3)
    assert robot.core.axes["a"].generator.velocity == 0.0
    assert robot.core.axes["b"].generator.velocity == pytest.approx(0.3)


def test_newest_of_two_clients_wins(robot):
    robot.send(a=0.3)
    robot.send(a=-0.3)
    robot.run(0.25)
    assert robot.positions["a"] < 0.0


def test_short_validity(robot):
    robot.send(a=0.3, validity=0.05)
    robot.run(0.06)
    before = robot.core.axes["a"].generator.velocity
    robot.step()
    assert robot.core.axes["a"].generator.velocity < before


def test_stale_stream_moves_nothing_after_a_pause(robot):
    robot.send(a=0.6)
    robot.wall_offset += 0.3
    robot.run(0.1)
    assert robot.positions["a"] == 0.0


def test_stream_through_a_pause_goes_on(robot):
    robot.hold(0.5, a=0.3)
    for _ in range(50):
        robot.wall_offset += 0.02
        robot.send(a=0.3)
    before = robot.positions["a"]
    robot.hold(0.1, a=0.3)
    assert robot.positions["a"] == pytest.approx(before + 0.03)


def test_displacement_goes_its_way_and_ends(robot):
    robot.displace(a=0.2)
    robot.displace(a=0.1)
    robot.run(2.0)
    assert robot.positions["a"] == pytest.approx(0.3, abs=1e-8)
    assert robot.last == {}


def test_displacement_from_before_a_pause_is_forgotten(robot):
    robot.displace(a=0.2)
    robot.wall_offset += 0.3
    robot.run(1.0)
    assert robot.positions["a"] == 0.0
    robot.displace(a=0.4)
    robot.run(0.2)
    robot.wall_offset += 0.3
    robot.run(2.0)
    assert 0.0 < robot.positions["a"] < 0.2


def test_long_displacement_is_refused_for_all_joints(robot):
    with pytest.raises(InvalidCommand, match="displacements of b is 0.6; must be at most 0.5"):
        robot.displace(a=0.1, b=0.6)
    robot.run(0.5)
    assert robot.positions == {"a": 0.0, "b": 0.0}


def test_jog_takes_over_from_a_displacement(robot):
    robot.displace(a=0.5)
    robot.run(0.3)
    robot.hold(0.5, a=-0.6)
    robot.send(a=0.0)
    robot.run(1.0)
    assert robot.positions["a"] < 0.1
    assert robot.last == {}


class TestEmergencyStop:
    def test_drops_motion_at_once(self, robot):
        robot.hold(0.5, a=0.6)
        robot.core.set_e_stop(True)
        robot.step()
        assert robot.last == {}
        assert robot.message() == "the e-stop is active"

    def test_running_stream_needs_a_new_press(self, robot):
        robot.hold(0.5, a=0.3)
        robot.core.set_e_stop(True)
        robot.hold(0.5, a=0.3)
        robot.core.set_e_stop(False)
        before = dict(robot.positions)
        robot.hold(1.0, a=0.3)
        assert robot.positions == before
        assert "press it again" in robot.message()
        robot.run(TIMEOUT)
        robot.hold(0.5, a=0.3)
        assert robot.positions["a"] > before["a"]
        assert robot.message() == ""

    def test_zero_counts_as_release(self, robot):
        robot.core.set_e_stop(True)
        robot.hold(0.5, a=0.3)
        robot.core.set_e_stop(False)
        robot.hold(0.1, a=0.3)
        robot.send(a=0.0)
        robot.hold(0.5, a=0.3)
        assert robot.positions["a"] > 0.0

    def test_displacements_are_ignored(self, robot):
        robot.core.set_e_stop(True)
        robot.displace(a=0.3)
        robot.core.set_e_stop(False)
        robot.run(1.0)
        assert robot.positions["a"] == 0.0

    def test_repeated_release_changes_nothing(self, robot):
        robot.core.set_e_stop(False)
        robot.hold(0.3, a=0.3)
        robot.core.set_e_stop(False)
        robot.hold(0.3, a=0.3)
        assert robot.core.axes["a"].generator.velocity == pytest.approx(0.3)


@pytest.mark.parametrize("jump", [-50.0, 0.6])
def test_jump_of_the_sim_time_needs_a_new_press(robot, jump):
    robot.hold(0.5, a=0.3)
    robot.time += jump
    robot.wall_offset -= jump
    robot.positions["a"] = 0.0
    robot.hold(1.0, a=0.3)
    assert robot.positions["a"] == 0.0
    robot.run(0.5)
    robot.hold(0.5, a=0.3)
    assert robot.positions["a"] > 0.0


class TestReset:
    """The simulator puts the robot back; its clock goes on."""

    def test_held_key_needs_a_new_press(self, robot):
        robot.hold(0.2, a=0.3)
        robot.core.restart(robot.time)
        robot.positions["a"] = 0.0
        robot.hold(1.0, a=0.3)
        assert robot.positions["a"] == 0.0
        assert "press it again" in robot.message()
        robot.run(TIMEOUT)
        robot.hold(0.5, a=0.3)
        assert robot.positions["a"] > 0.0

    def test_displacement_ends(self, robot):
        robot.displace(a=0.3)
        robot.run(0.1)
        robot.core.restart(robot.time)
        robot.positions["a"] = 0.0
        robot.run(2.0)
        assert robot.positions["a"] == 0.0

    def test_joint_that_was_moving_is_told_to_stay_where_it_was_put(self, robot):
        robot.hold(0.5, a=0.3)
        robot.core.restart(robot.time + DT)
        robot.step()  # measured before the reset
        assert robot.last == {}
        robot.positions["a"] = 0.01
        robot.step()
        assert robot.last == {"a": 0.01}
        robot.step()
        assert robot.last == {}

    def test_idle_node_says_nothing(self, robot):
        robot.core.restart(robot.time)
        robot.step()
        assert robot.last == {}


class TestThrownJoint:
    """Nobody tells of the reset, but a joint is suddenly somewhere else."""

    @pytest.mark.parametrize("start", ["hold", "displace"])
    def test_ends_what_was_under_way(self, robot, start):
        robot.hold(3.0, a=0.3)
        robot.run(1.0)
        {"hold": lambda: robot.hold(0.5, a=0.3), "displace": lambda: robot.displace(a=0.3)}[start]()
        robot.run(0.1)
        robot.positions["a"] = 0.0
        highest = 0.0
        for _ in range(100):
            if start == "hold":
                robot.send(a=0.3)
            robot.step()
            highest = max(highest, *robot.last.values(), 0.0)
        assert highest == 0.0

    def test_one_wrong_measurement_moves_nothing(self, robot):
        robot.hold(0.5, a=0.3)
        true = robot.positions["a"]
        robot.positions["a"] = true + 1.0
        robot.step()
        assert robot.last == {}
        robot.positions["a"] = true
        robot.step()
        assert robot.last == {}
        robot.step()
        assert robot.last == {"a": true}

    def test_what_the_lead_explains_goes_on(self, robot):
        robot.hold(0.5, a=0.3)
        robot.positions["a"] -= 0.19
        robot.hold(0.1, a=0.3)
        assert robot.core.state(robot.wall).active


class TestStart:
    @pytest.fixture
    def started(self):
        axes = {"a": AxisSettings(LIMITS, 0.5)}
        robot = Robot.__new__(Robot)
        robot.core = JointTeleop(axes, TIMEOUT, 0.5, SpeedScale())
        robot.time, robot.wall_offset, robot.positions, robot.last = 100.0, 0.0, {"a": 0.0}, {}
        return robot

    def test_stream_from_before_needs_a_new_press(self, started):
        started.hold(3.0, a=0.3)
        assert started.positions["a"] == 0.0
        assert "press it again" in started.message()
        started.run(TIMEOUT)
        started.hold(0.5, a=0.3)
        assert started.positions["a"] > 0.0

    def test_stream_that_begins_later_is_obeyed(self, started):
        started.run(0.1)
        assert started.message() == "just started"
        started.run(0.5)
        assert started.message() == ""
        started.hold(0.5, a=0.3)
        assert started.positions["a"] > 0.0

    def test_end_of_the_start_does_not_release_the_e_stop(self, started):
        started.core.set_e_stop(True)
        started.run(1.0)
        started.hold(0.5, a=0.3)
        assert started.positions["a"] == 0.0
        assert started.message() == "the e-stop is active"


def test_stop_of_another_client_does_not_release_a_key_held_through_the_e_stop(robot):
    robot.send(a=0.3, caller="keyboard")
    robot.core.set_e_stop(True)
    robot.core.set_e_stop(False)
    for _ in range(50):
        robot.send(a=0.3, caller="keyboard")
        robot.send(a=0.0, caller="console")
        robot.step()
    assert robot.positions["a"] == 0.0


def test_nothing_before_joint_states(robot):
    core = JointTeleop({"a": AxisSettings(LIMITS, 0.5)}, TIMEOUT, 0.5, SpeedScale())
    core.receive(JogCommand({"a": 0.3}, {}, None), 1.0)
    state = core.state(1.0)
    assert not state.active
    assert state.axes == ()
    assert "no joint_states yet" in state.message
    assert core.update(5.0, 1.0, {"a": 0.0}) == {}
    assert core.update(5.01, 1.01, {"a": 0.0}) == {}


def test_state_while_jogging(robot):
    robot.hold(0.5, a=0.3)
    state = robot.core.state(robot.wall)
    assert state.active
    assert state.message == ""
    axis = state.axes[0]
    assert (axis.name, axis.max_velocity, axis.limited) == ("a", 0.6, False)
    assert axis.reference == robot.positions["a"]
    assert axis.position == pytest.approx(axis.reference - 0.3 * DT)


def test_state_says_that_the_simulation_stands_still(robot):
    robot.hold(0.5, a=0.3)
    state = robot.core.state(robot.wall + 1.0)
    assert not state.active
    assert "paused" in state.message


def test_state_names_limited_joints(robot):
    robot.hold(6.0, b=0.6)
    assert [axis.limited for axis in robot.core.state(robot.wall).axes] == [False, True]


def test_a_motion_begins_as_slowly_after_a_rest_of_its_node(robot):
    assert robot.core.idle
    robot.time += 0.04  # joint states that the node has slept through
    robot.send(a=0.6)
    robot.step()
    assert not robot.core.idle
    assert robot.positions["a"] == pytest.approx(2.0 * DT**2)


def test_a_rest_of_the_node_takes_nothing_from_a_short_command(robot):
    robot.time += 0.04
    robot.send(validity=0.03, a=0.3)
    robot.time += 0.01
    robot.step()
    assert robot.last["a"] > 0.0
