"""The tracked drive and its odometry in the simulation, against ground truth."""

from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Float64

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
