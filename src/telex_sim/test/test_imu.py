"""What the inertial sensor measures, against the motion that it is given."""

from __future__ import annotations

import math

import pybullet
import pytest
from sensor_msgs.msg import Imu as ImuMessage

from telex_control.hardware_interface import ImuSensorInterface
from telex_sim.imu import Imu
from telex_sim.world import GRAVITY, World

STEP = 0.002
ARM = """
<robot name="arm">
  <link name="base"><inertial><mass value="1e6"/>
    <inertia ixx="1e6" iyy="1e6" izz="1e6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="sensor"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="mount" type="fixed"><parent link="arm"/><child link="sensor"/>
    <origin xyz="0.5 0 0" rpy="0 0 0.3"/></joint>
</robot>
"""


@pytest.fixture
def world():
    made = World(STEP, 50)
    yield made
    made.close()


def measure(world, body, link, steps):
    imu = Imu("imu", link)
    imu.attach(body)
    for _ in range(steps):
        world.step()
        imu.read(STEP)
    return imu.handle


@pytest.mark.parametrize("link", ["base", "sensor"])
def test_in_free_fall_no_acceleration_is_felt(world, link):
    body = world.load_robot(ARM, str, (0, 0, 100), 0.0, {})
    felt = measure(world, body, link, 50)
    assert felt.linear_acceleration == pytest.approx((0, 0, 0), abs=1e-6)
    assert felt.angular_velocity == pytest.approx((0, 0, 0), abs=1e-9)


def test_at_rest_it_feels_the_opposite_of_gravity_in_its_own_axes(world):
    body = world.load_robot(ARM, str, (0, 0, 1), 0.0, {}, fixed_base=True)
    tilted = pybullet.getQuaternionFromEuler((0.0, math.pi / 6.0, 0.0))
    pybullet.resetBasePositionAndOrientation(
        body.uid, (0, 0, 1), tilted, physicsClientId=world.client
    )
    felt = measure(world, body, "base", 5)
    wanted = (-GRAVITY * math.sin(math.pi / 6.0), 0.0, GRAVITY * math.cos(math.pi / 6.0))
    assert felt.linear_acceleration == pytest.approx(wanted, abs=1e-5)
    assert felt.orientation == pytest.approx(tilted, abs=1e-6)


def test_on_a_turning_arm_it_feels_the_pull_towards_the_middle(world):
    body = world.load_robot(ARM, str, (0, 0, 1), 0.0, {}, fixed_base=True)
    speed = 2.0
    pybullet.resetJointState(
        body.uid, body.joints["turn"], 0.0, speed, physicsClientId=world.client
    )
    pybullet.setJointMotorControl2(
        body.uid,
        body.joints["turn"],
        pybullet.VELOCITY_CONTROL,
        targetVelocity=speed,
        force=1e3,
        physicsClientId=world.client,
    )
    felt = measure(world, body, "sensor", 100)
    inwards = speed**2 * 0.5
    wanted = (-inwards * math.cos(0.3), inwards * math.sin(0.3), GRAVITY)
    assert felt.linear_acceleration == pytest.approx(wanted, abs=0.01)
    assert felt.angular_velocity == pytest.approx((0, 0, speed), abs=1e-6)


def test_the_robots_imu_stands_level_and_still(robot):
    tested = robot()
    handle = tested.simulation.hw.get(ImuSensorInterface).get_handle("imu")
    received = []
    tested.node.subscribe("imu", ImuMessage, received.append)
    tested.run(1.5)
    assert handle.frame_id == "imu_link"
    assert handle.linear_acceleration == pytest.approx((0, 0, GRAVITY), abs=0.1)
    assert handle.angular_velocity == pytest.approx((0, 0, 0), abs=0.01)
