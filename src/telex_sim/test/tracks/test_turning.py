"""The tracked drive and its odometry in the simulation, against ground truth."""

from __future__ import annotations

import copy
import math

import numpy as np
import pybullet
import pytest
import yaml
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Float64

from telex_control.common.file_catalog import package_file
from telex_sim.engine.world import GRAVITY

pytestmark = pytest.mark.slow

FLIPPERS = ("front_left", "front_right", "rear_left", "rear_right")


class Driver:
    """Drives a robot by cmd_vel, and knows where it is."""

    def __init__(self, tested):
        self.tested = tested
        self.command = tested.node.advertise("track_controller/cmd_vel", Twist)
        self.odometry = []
        tested.node.subscribe("track_controller/odom", Odometry, self.odometry.append)
        tested.run(1.0)
        self.origin = self.pose()
        self.start = self.told()

    def pose(self):
        return self.tested.simulation.body.base_pose()

    def heading(self):
        return pybullet.getEulerFromQuaternion(self.pose()[1])[2]

    def drive(self, linear, angular, seconds):
        """Send commands at 20 Hz, and return the turned angle (rad)."""
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        turned, last = 0.0, self.heading()
        for _ in range(round(seconds / 0.05)):
            self.command.publish(message)
            self.tested.run(0.05)
            turned += math.remainder(self.heading() - last, math.tau)
            last = self.heading()
        return turned

    def told(self):
        pose = self.odometry[-1].pose.pose
        place, turn = pose.position, pose.orientation
        return (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)

    def deviations(self):
        """Error of the odometry in x, y, z and yaw, each over its standard deviation."""
        true = pybullet.multiplyTransforms(*pybullet.invertTransform(*self.origin), *self.pose())
        told = pybullet.multiplyTransforms(*pybullet.invertTransform(*self.start), *self.told())
        yaw, true_yaw = (pybullet.getEulerFromQuaternion(each[1])[2] for each in (told, true))
        errors = [*np.subtract(told[0], true[0]), math.remainder(yaw - true_yaw, math.tau)]
        covariance = self.odometry[-1].pose.covariance
        return [
            error / math.sqrt(covariance[7 * index]) for error, index in zip(errors, (0, 1, 2, 5))
        ]


@pytest.mark.parametrize("rate", [0.5, -1.0])
def test_turns_in_place_follow_the_command(robot, rate):
    driver = Driver(robot(start__pose="stow"))
    driver.drive(0.0, rate, 1.0)
    assert driver.drive(0.0, rate, 2.0) / 2.0 == pytest.approx(rate, rel=0.01)


def test_turns_on_flat_flippers_follow_the_command(robot):
    tested = robot(start__pose="stow")
    tested.run(1.0)  # in which the gyroscope's bias is learnt, before the flippers shake the robot
    for flipper in FLIPPERS:
        topic = f"{flipper}_flipper_position_controller/command"
        tested.node.advertise(topic, Float64).publish(Float64(0.0))
    tested.run(3.0)
    driver = Driver(tested)
    driver.drive(0.0, 0.3, 2.5)
    assert driver.drive(0.0, 0.3, 2.0) / 2.0 == pytest.approx(0.3, rel=0.02)


def test_a_curve_follows_the_command_and_ends_with_it(robot):
    driver = Driver(robot(start__pose="drive"))
    driver.drive(0.5, 0.4, 1.0)
    assert driver.drive(0.5, 0.4, 2.0) / 2.0 == pytest.approx(0.4, rel=0.01)
    assert abs(driver.drive(0.5, 0.0, 1.0)) < 0.1
    assert abs(driver.drive(0.5, 0.0, 1.0)) < 0.005


@pytest.fixture(scope="module")
def holding():
    """The shipped controllers, with and without heading hold."""
    with open(package_file("telex_control", "config", "telex_controllers.yaml")) as file:
        shipped = yaml.safe_load(file)

    def make(hold):
        changed = copy.deepcopy(shipped)
        changed["track_controller"]["yaw_rate_loop"]["hold_heading"] = hold
        return changed

    return make


def tilt(tested, degrees):
    """Let the ground rise to the robot's left."""
    angle = math.radians(degrees)
    pull = (0.0, -GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle))
    pybullet.setGravity(*pull, physicsClientId=tested.simulation.world.client)


@pytest.mark.parametrize(
    ("hold", "rest", "most"),
    # Without, the tolerance of 0.01 rad/s for 5 s; with, what is left of the bias: its standard
    # deviation is 0.01 deg/s.
    [(True, 0.0, 0.15), (True, 3.0, 0.15), (False, 0.0, 2.9)],
)
def test_on_a_cross_slope_the_heading_is_held_when_asked_for(robot, holding, hold, rest, most):
    driver = Driver(robot(controllers=holding(hold), start__pose="stow"))
    driver.tested.run(1.0)
    tilt(driver.tested, 30.0)
    driver.tested.run(rest)
    before, (x, y, _) = driver.heading(), driver.pose()[0]
    driver.drive(0.3, 0.0, 5.0)
    lost = math.degrees(math.remainder(driver.heading() - before, math.tau))
    assert abs(lost) < most
    there = driver.pose()[0]
    assert there[0] - x == pytest.approx(1.5, abs=0.1)
    assert abs(there[1] - y) < 0.15


@pytest.mark.parametrize("hold", [False, True])
def test_with_the_arm_out_on_a_cross_slope_the_heading_lasts(robot, holding, hold):
    """What the belts bear does not change from step to step, so the nose does not creep down."""
    driver = Driver(robot(controllers=holding(hold), start__pose="floor_pick"))
    driver.tested.run(1.0)
    tilt(driver.tested, 25.0)
    driver.tested.run(1.0)
    before = driver.heading()
    driver.drive(0.3, 0.0, 5.0)
    assert abs(math.degrees(math.remainder(before - driver.heading(), math.tau))) < 0.15


def flipper_commands(tested):
    return [
        tested.node.advertise(f"{flipper}_flipper_position_controller/command", Float64)
        for flipper in FLIPPERS
    ]


def bias_error(tested):
    """How wrong the bias is that was learnt, and its standard deviation (rad/s)."""
    controller = tested.simulation.controllers.loaded["track_controller"].controller
    (sensor,) = tested.simulation.hw.imus
    imu = controller.imu
    # The mount is not turned: the sensor's axes are the base's.
    wrong = np.subtract(imu.bias, sensor.errors.gyroscope(0.0))
    return np.abs(wrong).max(), math.sqrt(imu.bias_variance)


def test_what_moves_it_in_its_first_second_is_not_taken_for_a_bias(robot):
    tested = robot(start__pose="look_front")
    commands = flipper_commands(tested)
    pitch = [pybullet.getEulerFromQuaternion(tested.simulation.body.base_pose()[1])[1]]
    for index in range(50):
        for command in commands[:2]:
            command.publish(Float64(-0.5 * index / 50))
        tested.run(0.02)
        wrong, deviation = bias_error(tested)
        assert wrong < 4.0 * deviation
        pitch.append(pybullet.getEulerFromQuaternion(tested.simulation.body.base_pose()[1])[1])
    assert pitch[-1] - pitch[0] < -0.05  # the nose has risen
    tested.run(2.0)
    wrong, deviation = bias_error(tested)
    assert wrong < 4.0 * deviation < 4e-3


def test_what_moves_it_slowly_at_rest_is_not_taken_for_a_bias(robot):
    tested = robot(start__pose="stow")
    driver = Driver(tested)
    commands = flipper_commands(tested)
    for command in commands:
        command.publish(Float64(0.0))
    tested.run(3.0)
    level = pybullet.getEulerFromQuaternion(driver.pose()[1])[1]
    for index in range(300):
        for command in commands[:2]:
            command.publish(Float64(-0.25 * index / 300))
        tested.run(0.02)
    pitch = pybullet.getEulerFromQuaternion(driver.pose()[1])[1]
    assert -0.3 < pitch - level < -0.03  # the nose has risen, slowly enough to be at rest
    wrong, deviation = bias_error(tested)
    assert wrong < 4.0 * deviation < 4e-3


def test_at_rest_nothing_turns_it(robot):
    tested = robot(start__pose="stow")
    driver = Driver(tested)
    before = driver.heading()
    tested.run(3.0)
    assert driver.heading() == pytest.approx(before, abs=1e-4)
    assert all(
        tested.simulation.hw.joint_state(f"{flipper}_track_joint").velocity == 0.0
        for flipper in FLIPPERS
    )


@pytest.mark.parametrize(
    ("pose", "plan"),
    [
        ("stow", [(0.5, 0.0, 4.0), (0.0, 0.8, 4.0), (0.5, -0.3, 4.0)]),
        ("ready", [(0.0, -0.8, 4.0), (0.6, 0.2, 6.0)]),
    ],
)
def test_the_odometry_is_as_right_as_it_says(robot, pose, plan):
    driver = Driver(robot(start__pose=pose))
    for linear, angular, seconds in plan:
        driver.drive(linear, angular, seconds)
    driver.tested.run(1.0)
    deviations = driver.deviations()
    assert max(map(abs, deviations)) < 3.0
    # Honest also means that it does not say nothing: of a few metres, half a metre at most.
    assert driver.odometry[-1].pose.covariance[0] < 0.5**2
    assert driver.odometry[-1].pose.covariance[35] < 0.05**2


def test_the_emergency_stop_winds_nothing_up(robot):
    tested = robot(start__pose="stow")
    driver = Driver(tested)
    driver.drive(0.0, 0.5, 1.0)
    tested.simulation.request_e_stop(True)
    driver.drive(0.0, 0.5, 0.5)
    assert abs(driver.drive(0.0, 0.5, 1.0)) < 0.01
    tested.simulation.request_e_stop(False)
    tested.run(0.5)
    # Its controllers have started anew; the next command is the first.
    assert abs(driver.drive(0.0, 0.0, 0.5)) < 0.01
    fastest = max(driver.drive(0.0, 0.5, 0.1) / 0.1 for _ in range(15))
    assert fastest < 0.6
