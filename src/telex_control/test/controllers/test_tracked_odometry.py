"""Dead reckoning by belts and gyroscope: where it leads, and how honest its covariance is."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from telex_control.base.imu import BaseImu, BaseImuConfig, sensor_mount
from telex_control.base.tracked_odometry import OdometryErrors, TrackedOdometry
from telex_control.common.params import ConfigError, read_config
from telex_control.hardware.hardware_interface import ImuSensorHandle
from telex_control.kinematics.urdf_tree import KinematicsError
from telex_control.urdf.joints import parse_urdf

PERIOD = 0.01
LEVEL = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def about_y(angle):
    return (0.0, math.sin(0.5 * angle), 0.0, math.cos(0.5 * angle))


class Robot:
    """A robot whose belts and sensor are told what happens."""

    def __init__(self, errors=None, **sensor):
        self.handle = ImuSensorHandle("imu", "imu_link")
        self.config = BaseImuConfig(**sensor)
        self.imu = BaseImu(self.handle, LEVEL, self.config)
        self.odometry = TrackedOdometry(
            5, errors or OdometryErrors(), self.imu, self.config.noise_density
        )
        self.odometry.set_geometry(0.4, 1.0, 1.0)
        self.belts = [0.0, 0.0]

    def cycle(self, way, rates, orientation=(0.0, 0.0, 0.0, 1.0), standing=False):
        """Go on for a cycle: the belts by `way` (m), the sensor measuring `rates`."""
        x, y, z = rates
        self.handle.angular_velocity = (x, y, z)  # a new reading, even of the same figures
        self.handle.orientation = orientation
        self.imu.update(standing, PERIOD)
        self.belts = [self.belts[0] + way, self.belts[1] + way]
        self.odometry.update(*self.belts, PERIOD)

    def rest(self, seconds, bias=0.0, noise=lambda: 0.0):
        for _ in range(round(seconds / PERIOD)):
            self.cycle(0.0, (0.0, 0.0, bias + noise()), standing=True)


def test_a_circle_closes():
    robot = Robot()
    robot.cycle(0.0, (0, 0, 0))
    count = 1000
    for _ in range(count):
        robot.cycle(math.tau / count, (0.0, 0.0, math.tau / (count * PERIOD)))
    assert robot.odometry.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    assert robot.odometry.heading == pytest.approx(0.0, abs=1e-6)
    assert robot.odometry.linear == pytest.approx(math.tau / count / PERIOD)


def test_the_way_up_a_ramp_is_height():
    robot = Robot()
    up = about_y(-math.radians(30.0))  # nose up
    for _ in range(100):  # from standing on the ramp
        robot.cycle(0.0, (0.0, 0.0, 0.0), up)
    for _ in range(200):
        robot.cycle(0.01, (0.0, 0.0, 0.0), up)
    x, y, z = robot.odometry.position
    assert (x, y, z) == pytest.approx((2.0 * math.cos(math.pi / 6), 0.0, 1.0), abs=1e-3)
    assert robot.odometry.orientation == pytest.approx(up, abs=1e-6)


def test_a_turn_on_a_ramp_changes_the_course_along_its_plane():
    robot = Robot()
    tilt = math.radians(20.0)
    robot.cycle(0.0, (0.0, 0.0, 0.0), about_y(-tilt))
    turns = 200
    for index in range(1, turns + 1):
        half = 0.25 * math.pi * index / turns
        y, w = math.sin(-0.5 * tilt), math.cos(-0.5 * tilt)
        # the ramp's tilt, then a quarter turn about the ramp's normal
        true = (y * math.sin(half), y * math.cos(half), w * math.sin(half), w * math.cos(half))
        robot.cycle(0.0, (0.0, 0.0, 0.5 * math.pi / (turns * PERIOD)), true)
    for _ in range(100):
        robot.cycle(0.01, (0.0, 0.0, 0.0), true)
    # across the ramp: neither up nor down
    assert robot.odometry.position == pytest.approx((0.0, 1.0, 0.0), abs=5e-3)


def test_without_an_orientation_it_stays_in_the_plane():
    robot = Robot()
    for _ in range(100):
        robot.cycle(0.01, (0.0, 0.0, 0.0), None)
    assert robot.odometry.position == pytest.approx((0.99, 0.0, 0.0))


def test_without_a_sensor_the_belts_tell_the_turn():
    odometry = TrackedOdometry(5, OdometryErrors(), None)
    odometry.set_geometry(0.5, 1.0, 1.0)
    odometry.update(0.0, 0.0, PERIOD)
    for index in range(1, 101):
        odometry.update(-0.005 * index, 0.005 * index, PERIOD)
    assert odometry.heading == pytest.approx(2.0)
    odometry.propagate()
    assert math.sqrt(odometry.pose_covariance()[35]) == pytest.approx(0.5 * 2.0)


def test_a_standing_robot_does_not_turn_by_its_gyroscopes_noise():
    robot = Robot(noise_density=2.5e-4)
    source = random.Random(3)
    robot.rest(20.0, bias=0.004, noise=lambda: source.gauss(0.0, 2.5e-3))
    assert abs(robot.odometry.heading) < 0.004  # of the time before it counted as at rest
    assert robot.imu.bias[2] == pytest.approx(0.004, abs=3e-4)
    before = robot.odometry.heading
    for _ in range(500):
        robot.cycle(0.005, (0.0, 0.0, 0.004 + source.gauss(0.0, 2.5e-3)))
    assert abs(robot.odometry.heading - before) < 3.0 * math.hypot(2.5e-4 * 5**0.5, 5.0 * 2e-4)


def test_a_robot_that_something_turns_at_rest_knows_it():
    robot = Robot()
    robot.rest(1.0)
    for _ in range(100):
        robot.cycle(0.0, (0.0, 0.0, 0.5), standing=True)
    assert robot.odometry.heading == pytest.approx(0.5)
    assert robot.imu.bias == pytest.approx((0.0, 0.0, 0.0))


@pytest.mark.parametrize("rate", [0.045, 0.02, -0.005])
@pytest.mark.parametrize("rested", [2.0, 30.0])
def test_a_slow_turn_at_rest_is_no_bias(rate, rested):
    source = random.Random(5)

    def noise():
        return source.gauss(0.0, 2.5e-4 / math.sqrt(PERIOD))

    robot = Robot()
    robot.rest(rested, 0.004, noise)
    known, before = robot.imu.bias[2], robot.odometry.heading
    robot.rest(10.0, 0.004 + rate, noise)  # it slides, or its flippers move
    seen = robot.odometry.heading - before
    # What passes until it is noticed, and the bias as well as it was known.
    deviation = math.sqrt(robot.imu.bias_variance)
    assert seen == pytest.approx(10.0 * rate, abs=3e-3 + 3.0 * 10.0 * deviation)
    assert robot.imu.bias[2] == pytest.approx(known, abs=1e-3)
    assert abs(robot.imu.bias[2] - 0.004) < 3.0 * deviation
    robot.rest(5.0, 0.004, noise)
    assert robot.imu.at_rest
    assert abs(robot.imu.bias[2] - 0.004) < 3.0 * math.sqrt(robot.imu.bias_variance)


def test_noise_is_not_taken_for_a_turn():
    source = random.Random(7)
    robot = Robot()
    robot.rest(1.0, 0.003)
    before = robot.odometry.orientation
    robot.rest(120.0, 0.003, lambda: source.gauss(0.0, 2.5e-4 / math.sqrt(PERIOD)))
    assert robot.odometry.orientation == before


def test_a_slow_tilting_at_rest_spoils_no_bias():
    robot = Robot()
    robot.rest(5.0)
    for _ in range(1000):
        robot.cycle(0.0, (0.0, 0.012, 0.0), standing=True)
    assert robot.imu.bias == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)


def test_a_bias_that_really_changes_is_accepted_in_the_end_and_doubted_until_then():
    robot = Robot()
    robot.rest(10.0, 0.001)
    sure = robot.imu.bias_variance
    robot.rest(20.0, 0.004)  # accepted after 30 s
    assert not robot.imu.at_rest
    assert robot.imu.bias_variance > 4.0 * sure
    robot.rest(120.0, 0.004)
    assert robot.imu.at_rest
    assert robot.imu.bias[2] == pytest.approx(0.004, abs=2e-4)


def test_doubt_goes_no_further_than_before_the_first_rest():
    robot = Robot(turn_on_bias=1e-3)
    robot.rest(5.0)
    for _ in range(20_000):
        robot.cycle(0.0, (0.0, 0.0, 0.03), standing=True)
    assert robot.imu.bias_variance <= 1e-3**2 * 1.01
    assert robot.imu.bias[2] == pytest.approx(0.0, abs=1e-6)


def test_the_covariance_is_that_of_many_runs():
    errors = OdometryErrors(
        way_scale=0.02, way_noise=0.02, turn_offset=0.0, turn_scale=0.0, tilt=0.0
    )
    sensor = {"noise_density": 2.0e-3, "turn_on_bias": 0.01, "bias_random_walk": 0.0}
    source = random.Random(1)
    ends = []
    for _ in range(150):
        robot = Robot(errors, **sensor)
        bias, scale = source.gauss(0.0, 0.01), source.gauss(1.0, 0.02)
        robot.cycle(0.0, (0.0, 0.0, 0.0), None)
        x = y = heading = 0.0
        for index in range(600):
            rate = 0.3 if 200 <= index < 400 else 0.0
            way = 0.01
            heading += rate * PERIOD
            x += way * math.cos(heading)
            y += way * math.sin(heading)
            measured = way * scale + source.gauss(0.0, 0.02 * math.sqrt(way))
            noisy = rate + bias + source.gauss(0.0, 2.0e-3 / math.sqrt(PERIOD))
            robot.cycle(measured, (0.0, 0.0, noisy), None)
            if index % 5 == 4:
                robot.odometry.propagate()
        position = robot.odometry.position
        ends.append((position[0] - x, position[1] - y, robot.odometry.heading - heading))
    found = np.sqrt(np.mean(np.square(ends), axis=0))
    told = np.sqrt(np.array(robot.odometry.pose_covariance())[[0, 7, 35]])
    assert found == pytest.approx(told, rel=0.2)
    # As a whole, correlations included: the mean squared Mahalanobis distance is the dimension.
    matrix = np.array(robot.odometry.pose_covariance()).reshape(6, 6)[np.ix_((0, 1, 5), (0, 1, 5))]
    distances = [end @ np.linalg.solve(matrix, end) for end in np.array(ends)]
    assert np.mean(distances) == pytest.approx(3.0, rel=0.25)


def test_a_reset_is_a_new_beginning():
    robot = Robot()
    for _ in range(100):
        robot.cycle(0.01, (0.0, 0.0, 0.3))
    robot.odometry.propagate()
    robot.odometry.reset()
    assert robot.odometry.position == (0.0, 0.0, 0.0)
    assert robot.odometry.heading == 0.0
    assert sum(robot.odometry.pose_covariance()[:3]) == 0.0


# --- the sensor ------------------------------------------------------------------------------

ROBOT = """
<robot name="r">
  <link name="base_link"/><link name="plate"/><link name="imu_link"/><link name="arm"/>
  <joint name="a" type="fixed"><parent link="base_link"/><child link="plate"/>
    <origin rpy="0 0 1.5707963"/></joint>
  <joint name="b" type="fixed"><parent link="plate"/><child link="imu_link"/>
    <origin rpy="3.1415926 0 0"/></joint>
  <joint name="c" type="continuous"><parent link="base_link"/><child link="arm"/></joint>
</robot>
"""


def test_the_mount_is_the_product_of_all_joints_up_to_the_sensor():
    mount = np.array(sensor_mount(parse_urdf(ROBOT), "base_link", "imu_link"))
    assert mount @ (1, 0, 0) == pytest.approx((0, 1, 0), abs=1e-6)
    assert mount @ (0, 1, 0) == pytest.approx((1, 0, 0), abs=1e-6)
    assert mount @ (0, 0, 1) == pytest.approx((0, 0, -1), abs=1e-6)


def test_a_base_of_another_name_is_the_root():
    mount = sensor_mount(parse_urdf(ROBOT), "hull", "base_link")
    assert mount == LEVEL


def test_a_sensor_on_an_arm_is_refused():
    with pytest.raises(KinematicsError, match="joint 'c'"):
        sensor_mount(parse_urdf(ROBOT), "base_link", "arm")


@pytest.mark.parametrize(
    ("key", "value"), [("noise_density", 0.0), ("still_rate", -1.0), ("turn_on_bias", math.inf)]
)
def test_wrong_figures_of_the_sensor_are_named(key, value):
    with pytest.raises(ConfigError, match=f"imu.*{key} is {value}"):
        read_config(BaseImuConfig, {key: value}, "imu")
