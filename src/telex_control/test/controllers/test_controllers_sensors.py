from __future__ import annotations

import pytest
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import Imu, JointState

from telex_control.hardware.hardware_interface import (
    ForceTorqueSensorHandle,
    ForceTorqueSensorInterface,
    ImuSensorHandle,
    ImuSensorInterface,
)


@pytest.fixture
def sensing(bench):
    """Start an IMU and a force-torque controller, with two sensors of each kind."""
    tested = bench(
        {
            "i": {"type": "imu_sensor_controller/ImuSensorController", "publish_rate": 100.0},
            "f": {
                "type": "force_torque_sensor_controller/ForceTorqueSensorController",
                "publish_rate": 50,
            },
        }
    )
    imus, wrenches = ImuSensorInterface(), ForceTorqueSensorInterface()
    for name in ("imu", "spare_imu"):
        imus.register_handle(ImuSensorHandle(name, f"{name}_link"))
    for name in ("wrist", "foot"):
        wrenches.register_handle(ForceTorqueSensorHandle(name, f"{name}_frame"))
    tested.hw.register_interface(imus)
    tested.hw.register_interface(wrenches)
    tested.load_and_start("i", "f")
    return tested


def listen(tested, topic, kind):
    received = []
    tested.node.subscribe(topic, kind, received.append)
    return received


def test_each_inertial_sensor_has_its_topic(sensing):
    imu = sensing.hw.get(ImuSensorInterface).get_handle("imu")
    imu.orientation = (0.0, 0.6, 0.0, 0.8)
    imu.orientation_covariance = (1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0)
    imu.angular_velocity = (0.1, 0.2, 0.3)
    received = listen(sensing, "imu", Imu)
    spare = listen(sensing, "spare_imu", Imu)
    sensing.cycle(500)
    assert len(received) in (100, 101)
    last = received[-1]
    assert last.header.frame_id == "imu_link"
    assert last.header.stamp.to_sec() == pytest.approx(sensing.time, abs=0.011)
    assert (last.orientation.y, last.orientation.w) == (0.6, 0.8)
    assert last.orientation_covariance[::4] == (1.0, 2.0, 3.0)
    assert last.angular_velocity.z == 0.3
    assert last.angular_velocity_covariance == (0.0,) * 9  # unknown
    assert last.linear_acceleration_covariance[0] == -1.0  # not measured
    assert spare[-1].orientation_covariance[0] == -1.0


def test_each_force_sensor_has_its_topic(sensing):
    wrist = sensing.hw.get(ForceTorqueSensorInterface).get_handle("wrist")
    wrist.force, wrist.torque = (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)
    received, other = (listen(sensing, name, WrenchStamped) for name in ("wrist", "foot"))
    sensing.cycle(500)
    assert len(received) in (50, 51)
    assert received[-1].header.frame_id == "wrist_frame"
    assert received[-1].wrench.force.y == 2.0
    assert received[-1].wrench.torque.z == 6.0
    assert other[-1].wrench.force.y == 0.0


@pytest.mark.parametrize("kind", ["imu_sensor_controller/ImuSensorController"])
@pytest.mark.parametrize("rate", [None, -1.0, "fast"])
def test_a_rate_is_needed(bench, caplog, kind, rate):
    params = {"type": kind, **({} if rate is None else {"publish_rate": rate})}
    assert not bench({"i": params}).manager.load_controller("i")
    assert "publish_rate" in caplog.text


def test_a_robot_without_the_sensor_is_told_so(bench, caplog):
    params = {"type": "imu_sensor_controller/ImuSensorController", "publish_rate": 10.0}
    assert not bench({"i": params}).manager.load_controller("i")
    assert "hardware_interface::ImuSensorInterface" in caplog.text


def joint_states(bench, **params):
    tested = bench(
        {
            "j": {
                "type": "joint_state_controller/JointStateController",
                "publish_rate": 100.0,
                **params,
            }
        }
    )
    received = listen(tested, "joint_states", JointState)
    tested.load_and_start("j")
    tested.cycle()
    return received


def test_joints_that_no_sensor_measures_are_added(bench):
    extra = [{"name": "tail", "position": 1, "velocity": 2.5}, {"name": "ear"}]
    message = joint_states(bench, extra_joints=extra)[-1]
    assert message.name == ["elbow", "slide", "wheel", "tail", "ear"]
    assert message.position[3:] == [1.0, 0.0]
    assert message.velocity[3:] == [2.5, 0.0]
    assert message.effort[3:] == [0.0, 0.0]


def test_an_extra_joint_that_is_measured_is_left_out(bench, caplog):
    message = joint_states(bench, extra_joints=[{"name": "elbow", "position": 9.0}])[-1]
    assert message.name == ["elbow", "slide", "wheel"]
    assert "'elbow' has a state already" in caplog.text


def test_at_a_rate_of_0_joint_states_are_never_published(bench):
    assert joint_states(bench, publish_rate=0) == []


def test_joints_come_in_the_order_that_is_asked_for(bench):
    assert joint_states(bench, joints=["wheel", "elbow"])[-1].name == ["wheel", "elbow"]


def test_a_joint_that_is_not_there_is_named(bench, caplog):
    with pytest.raises(AssertionError):
        joint_states(bench, joints=["nose"])
    assert "'nose'" in caplog.text


@pytest.mark.parametrize(
    ("wrong", "logged"),
    [
        ({"position": 1.0}, "extra_joints[0]/name is missing"),
        ({"name": "a", "angle": 1.0}, "extra_joints[0]/angle is unknown"),
        ("tail", "extra_joints[0] is 'tail'"),
        ({"name": "a", "effort": "big"}, "extra_joints[0]/effort is 'big'"),
    ],
)
def test_an_extra_joint_that_cannot_be_read_is_left_out(bench, caplog, wrong, logged):
    message = joint_states(bench, extra_joints=[wrong, {"name": "ear"}])[-1]
    assert message.name == ["elbow", "slide", "wheel", "ear"]
    assert logged in caplog.text
