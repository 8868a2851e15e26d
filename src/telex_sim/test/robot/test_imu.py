"""What the inertial sensor measures, against the motion that it is given."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pybullet
import pytest
from sensor_msgs.msg import Imu as ImuMessage

from telex_control.common.params import ConfigError, read_config
from telex_control.hardware.hardware_interface import ImuSensorInterface
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.urdf.joints import parse_urdf
from telex_sim.engine.simulator_config import HardwareConfig
from telex_sim.engine.world import GRAVITY, World
from telex_sim.robot.imu import Imu
from telex_sim.robot.imu_noise import ImuNoise
from telex_sim.robot.robot_hw_sim import RobotHWSim

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
    tested = robot(hardware__imu_noise={})
    handle = tested.simulation.hw.get(ImuSensorInterface).get_handle("imu")
    received = []
    tested.node.subscribe("imu", ImuMessage, received.append)
    tested.run(1.5)
    assert handle.frame_id == "imu_link"
    assert handle.linear_acceleration == pytest.approx((0, 0, GRAVITY), abs=0.1)
    assert handle.angular_velocity == pytest.approx((0, 0, 0), abs=0.01)


# --- errors ----------------------------------------------------------------------------------

NOISE = ImuNoise(
    gyroscope_noise_density=2.5e-4,
    gyroscope_turn_on_bias=2.0e-3,
    gyroscope_bias_random_walk=1.5e-5,
    accelerometer_noise_density=2.0e-3,
    accelerometer_turn_on_bias=0.02,
    accelerometer_bias_random_walk=1.0e-4,
    tilt_error=2.0e-3,
    tilt_correlation_time=0.5,
    seed=4,
)


def readings(world, noise, steps, robot=""):
    """Errors of a sensor that rests level: of rate, acceleration and orientation (x, y, z)."""
    body = world.load_robot(ARM, str, (0, 0, 1), 0.0, {}, fixed_base=True)
    imu = Imu("imu", "base", noise, robot)
    imu.attach(body)
    found = []
    for _ in range(steps):
        imu.read(STEP)
        handle = imu.handle
        felt = np.subtract(handle.linear_acceleration, (0.0, 0.0, GRAVITY))
        turned = 2.0 * np.array(handle.orientation[:3])
        found.append((handle.angular_velocity, felt, turned))
    return imu.handle, np.array(found)


def test_noise_has_the_density_that_is_asked_for_and_the_covariance_says_so(world):
    handle, found = readings(world, NOISE, 5000)
    spread = found.std(axis=0)
    assert spread[0] == pytest.approx([2.5e-4 / math.sqrt(STEP)] * 3, rel=0.05)
    assert spread[1] == pytest.approx([2.0e-3 / math.sqrt(STEP)] * 3, rel=0.05)
    assert spread[2, :2] == pytest.approx([2.0e-3] * 2, rel=0.4)
    for told, column in (
        (handle.angular_velocity_covariance, 0),
        (handle.linear_acceleration_covariance, 1),
    ):
        deviation = math.sqrt(told[0])
        assert 0.95 < deviation / spread[column, 0] < 1.2  # with the bias, which is no noise
        assert np.abs(found[:, column].mean(axis=0)).max() < 3.0 * deviation
    assert math.sqrt(handle.orientation_covariance[0]) == pytest.approx(2.0e-3)


def test_the_bias_is_another_with_each_seed_and_spread_as_asked_for(world):
    noise = ImuNoise(gyroscope_turn_on_bias=2.0e-3, accelerometer_turn_on_bias=0.02)
    ends = []
    for seed in range(100):
        _, found = readings(world, dataclasses.replace(noise, seed=seed), 1)
        ends.append(found[0, :2])
    spread = np.std(ends, axis=0)
    assert spread[0] == pytest.approx([2.0e-3] * 3, rel=0.25)
    assert spread[1] == pytest.approx([0.02] * 3, rel=0.25)


def test_the_heading_drifts_with_the_gyroscope_and_the_covariance_grows_with_it(world):
    handle, found = readings(world, NOISE, 5000)
    drift = found[:, 0, 2].sum() * STEP
    assert found[-1, 2, 2] == pytest.approx(drift, rel=0.01)
    seconds = 5000 * STEP
    wanted = (2.0e-3 * seconds) ** 2 + 2.5e-4**2 * seconds
    assert handle.orientation_covariance[8] == pytest.approx(wanted, rel=0.05)
    assert abs(drift) < 3.0 * math.sqrt(wanted)


def test_the_same_seed_gives_the_same_errors_also_after_a_reset(world):
    _, first = readings(world, NOISE, 50)
    _, second = readings(world, NOISE, 50)
    assert (first == second).all()
    _, other = readings(world, dataclasses.replace(NOISE, seed=5), 50)
    assert (first != other).any(axis=(1, 2)).all()


def test_the_sensors_of_two_robots_differ_in_their_errors(world):
    _, first = readings(world, NOISE, 50, "/one")
    _, again = readings(world, NOISE, 50, "/one")
    _, other = readings(world, NOISE, 50, "/two")
    assert (first == again).all()
    assert (first != other).any(axis=(1, 2)).all()


def test_each_robot_of_a_simulation_has_errors_of_its_own():
    transmission = """
      <transmission name="t"><type>transmission_interface/SimpleTransmission</type>
        <joint name="turn">
          <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
        <actuator name="a"/></transmission>
    </robot>"""
    urdf = ARM.replace("</joint>", '<limit velocity="1" effort="1"/></joint>', 1).replace(
        "</robot>", transmission
    )
    config = HardwareConfig(imus={"imu": "sensor"}, imu_noise={"imu": NOISE})
    made = World(STEP, 50)
    found = []
    try:
        body = made.load_robot(urdf, str, (0, 0, 1), 0.0, {}, fixed_base=True)
        for name in ("/one", "/two"):
            hw = RobotHWSim(parse_urdf(urdf), config)
            hw.init(LocalNodeHandle(namespace=name), LocalNodeHandle())
            hw.attach(body)
            found.append(hw.get(ImuSensorInterface).get_handle("imu").angular_velocity)
    finally:
        made.close()
    assert found[0] != found[1]


@pytest.mark.parametrize("tilted", [(0.0, 0.0, 0.0), (0.3, -0.2, 2.0)])
def test_a_heading_that_is_lost_altogether_goes_round(world, tilted):
    noise = ImuNoise(gyroscope_turn_on_bias=1.0, seed=2)
    body = world.load_robot(ARM, str, (0, 0, 1), 0.0, {}, fixed_base=True)
    true = pybullet.getQuaternionFromEuler(tilted)
    pybullet.resetBasePositionAndOrientation(
        body.uid, (0, 0, 1), true, physicsClientId=world.client
    )
    imu = Imu("imu", "base", noise)
    imu.attach(body)
    level = np.reshape(pybullet.getMatrixFromQuaternion(imu.handle.orientation), (3, 3))
    rate = level[2] @ imu.handle.angular_velocity
    wanted = 0.0
    for _ in range(math.ceil(9.0 / abs(rate) / STEP)):
        imu.read(STEP)
        wanted += rate * STEP
        c, s = math.cos(wanted), math.sin(wanted)
        shown = np.reshape(pybullet.getMatrixFromQuaternion(imu.handle.orientation), (3, 3))
        expected = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ level
        assert np.abs(shown - expected).max() < 1e-6


def test_without_noise_it_is_exact(world):
    handle, found = readings(world, None, 10)
    assert np.abs(found).max() < 1e-9
    assert handle.angular_velocity_covariance[0] == pytest.approx(1e-9)


@pytest.mark.parametrize(
    ("imu_noise", "message"),
    [
        ({"compass": {}}, "imu_noise/compass: there is no such sensor; imus has: imu"),
        ({"imu": {"tilt_error": -1.0}}, "tilt_error is -1.0"),
        (
            {"imu": {"gyroscope_turn_on_bias": 1e200}},
            "gyroscope_turn_on_bias is 1e.200; it must be at least 0 and at most 1000",
        ),
        ({"imu": {"tilt_correlation_time": 0.0}}, "tilt_correlation_time is 0.0"),
        ({"imu": {"noise": 1.0}}, "noise is unknown"),
        ({"imu": {"gyroscope_noise_density": math.nan}}, "gyroscope_noise_density is nan"),
    ],
)
def test_wrong_noise_is_named(imu_noise, message):
    params = {"imus": {"imu": "imu_link"}, "imu_noise": imu_noise}
    with pytest.raises(ConfigError, match=message):
        read_config(HardwareConfig, params, "hardware")
