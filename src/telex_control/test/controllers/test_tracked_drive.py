"""A tracked drive on belts that slip, with and without its inertial sensor."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from drive_rig import DriveRig
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from telex_control.hardware.hardware_interface import (
    ImuSensorHandle,
    ImuSensorInterface,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    RobotHW,
    VelocityJointInterface,
)

pytestmark = pytest.mark.slow

RADIUS, GAUGE, FACTOR = 0.1, 0.4, 2.0
BELTS = ("left", "right")


def urdf(mount="0 0 0", joint="fixed"):
    return f"""
<robot name="tracked">
  <link name="base_link"/><link name="bracket"/><link name="imu_link"/>
  <joint name="bracket_joint" type="{joint}"><parent link="base_link"/><child link="bracket"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/><axis xyz="0 0 1"/></joint>
  <joint name="imu_joint" type="fixed"><parent link="bracket"/><child link="imu_link"/>
    <origin xyz="0 0 0.1" rpy="{mount}"/></joint>
</robot>
"""


class TrackedHW(RobotHW):
    """Belts that follow at once, on a robot that turns by a share of what wheels would do."""

    def __init__(self, with_imu=True):
        super().__init__()
        states, velocities, imus = JointStateInterface(), VelocityJointInterface(), None
        self.belts = {name: JointHandle(JointStateHandle(name)) for name in BELTS}
        for belt in self.belts.values():
            states.register_handle(belt.state)
            velocities.register_handle(belt)
        self.imu = ImuSensorHandle("imu", "imu_link")
        for interface in (states, velocities):
            self.register_interface(interface)
        if with_imu:
            imus = ImuSensorInterface()
            imus.register_handle(self.imu)
            self.register_interface(imus)
        self.efficiency = 0.4
        self.disturbance = 0.0  # yaw rate that something else adds (rad/s)
        self.bias = 0.0
        self.braked = False  # the belts stand, whatever is commanded
        self.blocked = False  # the robot stands, whatever the belts do
        self.silent = False  # the sensor measures nothing
        self.to_sensor = np.eye(3)
        self.heading = 0.0
        self.rate = 0.0
        self.measure()

    def measure(self):
        if not self.silent:
            turning = self.to_sensor @ [0.0, 0.0, self.rate + self.bias]
            self.imu.angular_velocity = tuple(float(each) for each in turning)
            self.imu.orientation = (0.0, 0.0, 0.0, 1.0)

    def advance(self, period):
        for belt in self.belts.values():
            belt.state.velocity = 0.0 if self.braked else belt.command
            belt.state.position += belt.state.velocity * period
        left, right = (self.belts[name].state.velocity * RADIUS for name in BELTS)
        self.rate = self.efficiency * (right - left) / GAUGE + self.disturbance
        if self.blocked:
            self.rate = 0.0
        self.heading += self.rate * period
        self.measure()


PARAMS = {
    "type": "telex_controllers/TrackedDriveController",
    "left_wheel": "left",
    "right_wheel": "right",
    "wheel_radius": RADIUS,
    "wheel_separation": GAUGE,
    "wheel_separation_multiplier": FACTOR,
    "max_belt_speed": 1.5,
    "cmd_vel_timeout": 0.5,
    "pose_covariance_diagonal": [1e-6] * 6,
    "twist_covariance_diagonal": [1e-4] * 6,
    "angular": {"z": {"has_acceleration_limits": True, "max_acceleration": 4.0}},
}


class Rig(DriveRig):
    def __init__(self, bench, description, with_imu, params):
        super().__init__(bench, TrackedHW(with_imu), description, {**PARAMS, **params})

    @property
    def loop(self):
        return self.controller.yaw_loop

    def drive(self, linear, angular, seconds):
        """Send commands at 20 Hz, and return the fastest belt (m/s)."""
        fastest = 0.0
        for _ in range(round(seconds * 20)):
            self.send(linear, angular)
            self.run(0.05)
            fastest = max(fastest, *map(abs, self.speeds()))
        return fastest

    def turn(self, angular, seconds, linear=0.0):
        """Drive, and return the mean yaw rate of the second half (rad/s)."""
        self.drive(linear, angular, 0.5 * seconds)
        before = self.hw.heading
        self.drive(linear, angular, 0.5 * seconds)
        return (self.hw.heading - before) / (0.5 * seconds)

    def speeds(self):
        """Commanded speed of the left and the right belts (m/s)."""
        return tuple(self.hw.belts[name].command * RADIUS for name in BELTS)


@pytest.fixture
def rig(bench):
    def make(description=None, *, imu=True, **params):
        return Rig(bench, description or urdf(), imu, params).start()

    return make


# --- turning ---------------------------------------------------------------------------------


@pytest.mark.parametrize("efficiency", [0.16, 0.25, 0.46, 0.9])
@pytest.mark.parametrize("rate", [0.5, -1.0])
def test_turns_follow_the_command_however_the_belts_slip(rig, efficiency, rate):
    tested = rig(max_belt_speed=3.0)
    tested.hw.efficiency = efficiency
    assert tested.turn(rate, 4.0) == pytest.approx(rate, rel=0.005)


def test_curves_follow_the_command(rig):
    tested = rig()
    tested.hw.disturbance = -0.1
    assert tested.turn(0.3, 4.0, linear=0.5) == pytest.approx(0.3, rel=0.01)
    assert sum(tested.speeds()) == pytest.approx(1.0)


@pytest.mark.parametrize("efficiency", [0.16, 0.25, 0.46])
@pytest.mark.parametrize("jitter", [0.02, 0.05])
def test_an_unsteady_hand_turns_the_robot_no_slower(rig, efficiency, jitter):
    tested = rig(max_belt_speed=3.0)
    tested.hw.efficiency = efficiency
    source = random.Random(1)
    tested.turn(0.5, 2.0)
    asked, before = 0.0, tested.hw.heading
    for _ in range(250):
        rate = 0.5 * (1.0 + source.uniform(-jitter, jitter))
        tested.send(0.0, rate)
        tested.run(0.02)
        asked += 0.02 * rate
    assert tested.hw.heading - before == pytest.approx(asked, rel=0.01)


def test_a_turn_that_slows_down_and_speeds_up_again_need_not_be_learnt_anew(rig):
    tested = rig(max_belt_speed=3.0)
    tested.hw.efficiency = 0.16
    tested.turn(1.0, 3.0)
    learnt = tested.loop.integral
    tested.drive(0.0, 0.3, 0.3)
    assert tested.loop.integral < 0.5 * learnt
    tested.drive(0.0, 1.0, 0.2)
    # 70 % were taken away, of which 20 % are forgotten.
    assert tested.loop.integral == pytest.approx(learnt, rel=0.15)


def test_what_makes_up_for_a_pull_is_not_multiplied_in_a_faster_turn(rig):
    tested = rig(max_belt_speed=3.0)
    tested.drive(0.4, 1.0, 1.0)
    tested.hw.disturbance = -0.1
    tested.turn(0.05, 4.0, linear=0.4)
    assert tested.hw.rate == pytest.approx(0.05, rel=0.05)
    peak = 0.0
    for _ in range(40):
        tested.drive(0.4, 1.0, 0.05)
        peak = max(peak, tested.hw.rate)
    assert peak < 1.1


@pytest.mark.parametrize("rate", [0.04, 0.1, 0.2])
def test_a_slight_curve_is_kept_against_a_pull(rig, rate):
    tested = rig()
    tested.hw.disturbance = -0.25
    assert tested.turn(rate, 4.0, linear=0.5) == pytest.approx(rate, rel=0.02)


def test_a_turn_neither_overshoots_nor_goes_on_after_its_end(rig):
    tested = rig()
    tested.hw.efficiency = 0.2
    fastest = 0.0
    for _ in range(60):
        tested.drive(0.0, 1.0, 0.05)
        fastest = max(fastest, tested.hw.rate)
    assert fastest < 1.1
    tested.send(0.0, 0.0)
    before = tested.hw.heading
    tested.run(1.0)
    # the ramp of 4 rad/s2 from 1 rad/s takes 0.125 rad
    assert 0.05 < tested.hw.heading - before < 0.2
    assert tested.speeds() == (0.0, 0.0)


def test_the_loop_turns_nothing_that_is_told_to_stand(rig):
    tested = rig(yaw_rate_loop={"hold_heading": True})
    tested.drive(0.5, 0.0, 1.0)
    tested.send(0.0, 0.0)
    tested.run(0.5)
    tested.hw.disturbance = 0.3  # somebody turns it
    for _ in range(50):
        tested.run(0.02)
        assert tested.speeds() == (0.0, 0.0)
    assert tested.loop.integral == 0.0


def test_a_gyroscopes_bias_is_learnt_at_rest(rig):
    tested = rig()
    tested.hw.bias = 0.02
    odometry = tested.listen("d/odom", Odometry)
    tested.run(2.0)
    assert odometry[-1].twist.twist.angular.z == pytest.approx(0.0, abs=1e-12)
    assert odometry[-1].pose.pose.orientation.z == pytest.approx(0.0, abs=0.005)
    assert tested.turn(0.1, 4.0) == pytest.approx(0.1, rel=0.01)


@pytest.mark.parametrize("mount", [(0.0, 0.0, 1.0), (math.pi, 0.0, 0.0), (0.4, -0.7, 2.0)])
def test_the_sensor_may_be_mounted_in_any_way(rig, mount):
    roll, pitch, yaw = mount
    c, s = np.cos, np.sin
    about_x = np.array([[1, 0, 0], [0, c(roll), -s(roll)], [0, s(roll), c(roll)]])
    about_y = np.array([[c(pitch), 0, s(pitch)], [0, 1, 0], [-s(pitch), 0, c(pitch)]])
    about_z = np.array([[c(yaw), -s(yaw), 0], [s(yaw), c(yaw), 0], [0, 0, 1]])
    tested = rig(urdf(" ".join(map(str, mount))))
    tested.hw.to_sensor = (about_z @ about_y @ about_x).T
    assert tested.turn(0.5, 4.0) == pytest.approx(0.5, rel=0.005)


# --- limits ----------------------------------------------------------------------------------


def test_belts_keep_their_limit_and_the_turn_has_precedence(rig):
    tested = rig(max_belt_speed=1.0)
    tested.hw.efficiency = 0.4
    assert tested.turn(0.8, 4.0, linear=0.9) == pytest.approx(0.8, rel=0.01)
    left, right = tested.speeds()
    assert max(abs(left), abs(right)) == pytest.approx(1.0)
    assert 0.5 * (left + right) == pytest.approx(1.0 - 0.4, abs=0.01)


def test_a_turn_that_the_belts_cannot_do_winds_nothing_up(rig):
    tested = rig(max_belt_speed=0.3)
    tested.hw.efficiency = 0.2
    assert tested.drive(0.0, 1.0, 5.0) == pytest.approx(0.3)
    tested.hw.efficiency = 0.9
    peak = 0.0
    for _ in range(40):
        tested.drive(0.0, 1.0, 0.05)
        peak = max(peak, tested.hw.rate)
    assert peak < 1.4  # 0.3 m/s with this efficiency; the loop comes down from there
    assert tested.hw.rate == pytest.approx(1.0, rel=0.02)


def test_a_brake_winds_nothing_up(rig):
    tested = rig()
    tested.turn(0.5, 2.0)
    settled = tested.loop.integral
    tested.hw.braked = True
    tested.drive(0.0, 0.5, 3.0)
    assert abs(tested.loop.integral) <= abs(settled) + 0.05
    tested.hw.braked = False
    peak = 0.0
    for _ in range(40):
        tested.drive(0.0, 0.5, 0.05)
        peak = max(peak, tested.hw.rate)
    assert peak < 0.75


def test_a_blocked_robot_winds_nothing_up(rig):
    tested = rig()
    tested.hw.blocked = True
    # feed-forward and proportional part only: (2 + 2) times 0.5 rad/s on half the gauge
    assert tested.drive(0.0, 0.5, 5.0) == pytest.approx(4.0 * 0.5 * 0.5 * GAUGE, rel=0.02)
    assert tested.loop.integral == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("linear", [0.0, 0.3])
@pytest.mark.parametrize("rate", [0.04, 0.01])
def test_a_blocked_robot_winds_nothing_up_in_a_slow_turn(rig, rate, linear):
    tested = rig()
    tested.hw.blocked = True
    tested.drive(linear, rate, 5.0)
    left, right = tested.speeds()
    # feed-forward and proportional part only
    assert 0.5 * (right - left) == pytest.approx(4.0 * rate * 0.5 * GAUGE, rel=0.02)
    tested.hw.blocked = False
    peak = 0.0
    for _ in range(40):
        tested.drive(linear, rate, 0.05)
        peak = max(peak, tested.hw.rate)
    assert peak < 2.0 * rate
    assert tested.hw.rate == pytest.approx(rate, rel=0.05)


def test_in_a_slow_turn_on_the_spot_the_belts_keep_to_the_largest_factor(rig):
    tested = rig(yaw_rate_loop={"max_factor": 5.0})
    tested.hw.efficiency = 0.12  # of which a factor of 8.3 would make up
    assert tested.drive(0.0, 0.04, 5.0) == pytest.approx(5.0 * 0.04 * 0.5 * GAUGE)


def test_limits_and_time_out_are_those_of_a_diff_drive(rig):
    tested = rig(publish_cmd=True, cmd_vel_timeout=0.3)
    limited = tested.listen("d/cmd_vel_out", TwistStamped)
    tested.send(0.2, 9.0)
    tested.run(0.1)
    assert limited[-1].twist.angular.z == pytest.approx(4.0 * 0.1)
    tested.run(1.0)
    assert tested.speeds() == (0.0, 0.0)


def test_stopping_brakes_at_once(rig):
    tested = rig()
    tested.drive(0.5, 0.5, 1.0)
    assert tested.bench.switch(stop=["d"])
    assert tested.speeds() == (0.0, 0.0)


def test_a_reset_leaves_nothing_of_the_past(rig):
    def turned(tested):
        tested.hw.heading = 0.0
        tested.turn(0.5, 1.0)
        return tested.hw.heading

    fresh, used = rig(), rig()
    for belt in used.hw.belts.values():
        belt.state.position = 0.0
    used.hw.bias = 0.01
    used.run(1.0)
    used.drive(0.3, 0.4, 1.0)
    used.hw.bias = 0.0
    for belt in used.hw.belts.values():
        belt.command = belt.state.velocity = belt.state.position = 0.0
    used.hw.rate = 0.0
    used.hw.measure()
    used.bench.manager.reset(used.bench.time)
    assert turned(used) == turned(fresh)


# --- heading ---------------------------------------------------------------------------------


@pytest.mark.parametrize("hold", [True, False])
def test_the_heading_is_kept_against_a_pull_when_asked_for(rig, hold):
    tested = rig(yaw_rate_loop={"hold_heading": hold})
    tested.drive(0.5, 0.0, 0.5)
    tested.hw.disturbance = 0.2
    tested.drive(0.5, 0.0, 4.0)
    # By itself, the loop ends the turning but for its tolerance, and does not turn back.
    left = 0.0 if hold else 0.01
    lost = 0.0 if hold else (0.2 - left) / (20.0 * tested.hw.efficiency) + 4.0 * left
    assert tested.hw.heading == pytest.approx(lost, abs=3e-3)
    assert tested.hw.rate == pytest.approx(left, abs=1e-3)


def test_what_is_left_of_a_bias_does_not_set_the_belts_against_each_other(rig):
    tested = rig()
    tested.run(1.0)
    tested.hw.bias = 0.005  # it has wandered since the robot was at rest
    tested.drive(1.0, 0.0, 3.0)
    assert tested.speeds() == (1.0, 1.0)


def test_what_the_end_of_a_curve_needed_does_not_turn_the_robot_for_good(rig):
    tested = rig()
    tested.drive(0.5, 0.4, 2.0)
    tested.hw.disturbance = 0.1
    tested.drive(0.5, 0.0, 1.0)
    assert abs(tested.loop.integral) > 0.1
    tested.hw.disturbance = 0.0
    tested.drive(0.5, 0.0, 2.0)
    assert tested.speeds() == pytest.approx((0.5, 0.5), abs=1e-4)


def test_after_a_turn_the_new_heading_is_held(rig):
    tested = rig(yaw_rate_loop={"hold_heading": True})
    tested.drive(0.5, 0.0, 1.0)
    tested.drive(0.5, 0.5, 2.0)
    tested.drive(0.5, 0.0, 1.0)
    new = tested.hw.heading
    assert new == pytest.approx(1.0, abs=0.1)
    tested.drive(0.5, 0.0, 4.0)
    assert tested.hw.heading == pytest.approx(new, abs=0.01)


# --- without the sensor ----------------------------------------------------------------------


def test_without_a_sensor_the_fixed_factor_turns_it(rig, caplog):
    tested = rig(imu=False)
    tested.hw.efficiency = 0.5
    assert tested.turn(0.5, 2.0) == pytest.approx(0.5)
    tested.hw.efficiency = 0.25
    assert tested.turn(0.5, 2.0) == pytest.approx(0.25)
    assert "no inertial sensor 'imu'" in caplog.text
    assert "wheel_separation_multiplier" in caplog.text


def test_a_robot_that_is_to_have_no_sensor_is_not_warned_of(bench, caplog):
    tested = Rig(bench, "<robot/>", False, {"imu": {"name": ""}}).start()
    assert tested.turn(0.5, 2.0) == pytest.approx(0.5 * FACTOR * tested.hw.efficiency)
    assert "sensor" not in caplog.text


@pytest.mark.parametrize("way", ["silent", "not a number"])
def test_a_sensor_that_falls_silent_leaves_the_fixed_factor(rig, caplog, way):
    tested = rig()
    tested.hw.efficiency = 0.25
    assert tested.turn(0.5, 2.0) == pytest.approx(0.5, rel=0.01)
    tested.hw.silent = True
    if way == "not a number":
        tested.hw.imu.angular_velocity = (math.nan, 0.0, 0.0)
    tested.run(0.05)
    assert "no reading" not in caplog.text
    assert tested.turn(0.5, 2.0) == pytest.approx(0.25, rel=0.01)
    assert caplog.text.count("no reading of the inertial sensor 'imu' for 0.1 s") == 1
    tested.hw.silent = False
    assert tested.turn(0.5, 2.0) == pytest.approx(0.5, rel=0.01)


def test_a_sensor_of_a_robot_that_turns_steadily_is_not_taken_for_silent(rig, caplog):
    tested = rig()
    tested.turn(0.5, 6.0)  # the same figures in every cycle, but new readings
    assert "no reading" not in caplog.text


@pytest.mark.parametrize(
    ("description", "params", "logged"),
    [
        (urdf(joint="revolute"), {}, "by joint 'bracket_joint'; the sensor must be fixed"),
        ("<robot name='r'><link name='base_link'/></robot>", {}, "no link 'imu_link'"),
        (urdf(), {"max_belt_speed": None}, "max_belt_speed is missing"),
        (urdf(), {"max_belt_speed": 0.0}, "max_belt_speed is 0.0"),
        (urdf(), {"imu": {"timeout": 0.0}}, "d/imu: timeout is 0.0"),
        (urdf(), {"imu": {"rate": 3.0}}, "d/imu/rate is unknown"),
        (urdf(), {"yaw_rate_loop": {"integral_gain": -1.0}}, "integral_gain is -1.0"),
        (urdf(), {"yaw_rate_loop": {"max_factor": math.nan}}, "max_factor is nan"),
        (
            urdf(),
            {"yaw_rate_loop": {"max_factor": 1.5}},
            "/d/yaw_rate_loop/max_factor is 1.5; it must not be below "
            "/d/wheel_separation_multiplier, 2.0",
        ),
        (urdf(), {"odometry_errors": {"tilt": "small"}}, "odometry_errors/tilt is 'small'"),
    ],
)
def test_wrong_parameters_are_named(bench, caplog, description, params, logged):
    assert not Rig(bench, description, True, params).loaded
    assert logged in caplog.text


# --- odometry --------------------------------------------------------------------------------


def test_the_odometry_turns_with_the_robot_not_with_the_belts(rig):
    tested = rig()
    odometry = tested.listen("d/odom", Odometry)
    transforms = tested.listen("/tf", TFMessage)
    tested.turn(0.5, 2.0)
    tested.run(1.0)
    last = odometry[-1]
    yaw = 2.0 * math.asin(last.pose.pose.orientation.z)
    assert yaw == pytest.approx(tested.hw.heading, abs=2e-3)
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
    (transform,) = transforms[-1].transforms
    assert transform.transform.rotation == last.pose.pose.orientation


def test_the_covariance_grows_on_the_way_and_not_at_rest(rig):
    tested = rig()
    odometry = tested.listen("d/odom", Odometry)

    def deviations():
        matrix = np.array(odometry[-1].pose.covariance).reshape(6, 6)
        assert np.allclose(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > 0.0
        return np.sqrt(np.diag(matrix))

    tested.run(1.0)
    start = deviations()
    tested.run(1.0)
    assert deviations() == pytest.approx(start)
    tested.drive(0.5, 0.0, 4.0)
    straight = deviations()
    assert straight[0] == pytest.approx(0.03 * 2.0, rel=0.1)  # way_scale
    assert straight[1] < 0.02
    tested.turn(0.5, 4.0)
    assert deviations()[1] > 0.08  # turn_offset


def test_without_sensor_the_covariance_says_how_little_is_known_of_the_heading(rig):
    tested = rig(imu=False)
    odometry = tested.listen("d/odom", Odometry)
    tested.hw.efficiency = 0.2
    tested.turn(0.5, 4.0)
    tested.run(1.0)
    yaw = 2.0 * math.asin(odometry[-1].pose.pose.orientation.z)
    error = math.remainder(yaw - tested.hw.heading, 2.0 * math.pi)
    deviation = math.sqrt(odometry[-1].pose.covariance[35])
    assert abs(error) > 0.5
    assert abs(error) < 3.0 * deviation
