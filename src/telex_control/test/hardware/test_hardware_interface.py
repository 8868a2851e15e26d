from __future__ import annotations

import pytest

from telex_control.hardware.hardware_interface import (
    ControllerInfo,
    EffortJointInterface,
    ForceTorqueSensorHandle,
    ForceTorqueSensorInterface,
    HardwareInterface,
    HardwareInterfaceError,
    ImuSensorHandle,
    ImuSensorInterface,
    InterfaceResources,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    PositionJointInterface,
    RobotHW,
    SwitchState,
    VelocityJointInterface,
)

EFFORT, VELOCITY = EffortJointInterface.type_name, VelocityJointInterface.type_name


def info(name, *claims):
    return ControllerInfo(name, "t", tuple(InterfaceResources(*claim) for claim in claims))


def test_command_interfaces_claim_and_state_interfaces_do_not():
    state = JointStateHandle("j")
    effort, states = EffortJointInterface(), JointStateInterface()
    effort.register_handle(JointHandle(state))
    states.register_handle(state)
    assert states.get_handle("j") is state
    assert states.take_claims() == set()
    effort.get_handle("j")
    assert effort.take_claims() == {"j"}
    assert effort.take_claims() == set()


STATE = JointStateHandle("x")
KINDS = [
    (JointStateInterface, STATE, False),
    (EffortJointInterface, JointHandle(STATE), True),
    (VelocityJointInterface, JointHandle(STATE), True),
    (PositionJointInterface, JointHandle(STATE), True),
    (ImuSensorInterface, ImuSensorHandle("x", "imu_link"), False),
    (ForceTorqueSensorInterface, ForceTorqueSensorHandle("x", "wrist_link"), False),
]


@pytest.mark.parametrize(("kind", "handle", "claims"), KINDS)
def test_every_interface_has_upstreams_name_and_claims(kind, handle, claims):
    robot, interface = RobotHW(), kind()
    interface.register_handle(handle)
    robot.register_interface(interface)
    assert robot.get(kind).get_handle("x") is handle
    (taken,) = robot.take_claims()
    assert taken.hardware_interface == f"hardware_interface::{kind.__name__}"
    assert taken.resources == (("x",) if claims else ())
    assert robot.take_claims() == ()


def test_sensors_measure_nothing_until_they_do():
    imu = ImuSensorHandle("imu", "imu_link")
    assert (imu.frame_id, imu.orientation, imu.angular_velocity_covariance) == (
        "imu_link",
        None,
        None,
    )
    assert ForceTorqueSensorHandle("ft", "wrist_link").force is None


def test_registering_again_replaces_and_warns(caplog):
    robot, interface = RobotHW(), JointStateInterface()
    first, second = JointStateHandle("j"), JointStateHandle("j")
    interface.register_handle(first)
    assert caplog.text == ""
    interface.register_handle(second)
    assert interface.get_handle("j") is second
    assert "Replacing previously registered handle 'j' in" in caplog.text
    robot.register_interface(JointStateInterface())
    robot.register_interface(interface)
    assert robot.get(JointStateInterface) is interface
    assert "interface 'hardware_interface::JointStateInterface'" in caplog.text


def test_a_robots_own_interface_is_named_by_its_class():
    class GripperInterface(HardwareInterface):
        claims_resources = True

    assert GripperInterface.type_name.endswith("GripperInterface")
    with pytest.raises(HardwareInterfaceError, match="GripperInterface"):
        RobotHW().get(GripperInterface)


def test_a_robot_switches_at_once_unless_it_says_otherwise():
    robot = RobotHW()
    assert robot.prepare_switch([], []) is None
    robot.do_switch([], [])
    assert robot.switch_result() is SwitchState.DONE
    assert robot.switch_result(info("a")) is SwitchState.DONE


def test_a_handle_shows_what_the_robot_measured():
    state = JointStateHandle("j")
    handle = JointHandle(state)
    state.position = 1.5
    assert handle.state.position == 1.5
    assert handle.name == "j"


def test_names_are_sorted():
    states = JointStateInterface()
    for name in ("b", "a", "c"):
        states.register_handle(JointStateHandle(name))
    assert states.names() == ["a", "b", "c"]


def test_unknown_resources_are_named():
    states = JointStateInterface()
    states.register_handle(JointStateHandle("j"))
    with pytest.raises(
        HardwareInterfaceError,
        match=r"Could not find resource 'x' in 'hardware_interface::JointStateInterface'\. .* j$",
    ):
        states.get_handle("x")


def test_missing_interfaces_are_named():
    robot = RobotHW()
    robot.register_interface(EffortJointInterface())
    with pytest.raises(
        HardwareInterfaceError,
        match="requires a hardware interface of type 'hardware_interface::VelocityJointInterface'. "
        "Make sure this is registered in the hardware_interface::RobotHW class.*Effort",
    ):
        robot.get(VelocityJointInterface)


@pytest.mark.parametrize(
    ("controllers", "conflict"),
    [
        ([info("a", (EFFORT, ["j1"])), info("b", (EFFORT, ["j2"]))], None),
        ([info("a", (EFFORT, ["j1", "j2"])), info("b", (EFFORT, ["j2"]))], "j2"),
        ([info("a", (EFFORT, ["j1"])), info("b", (VELOCITY, ["j1"]))], "j1"),
        ([info("a", (EFFORT, ["j1"]), (VELOCITY, ["j1"]))], "'a' and 'a'"),
    ],
)
def test_conflicts(controllers, conflict):
    found = RobotHW().check_for_conflict(controllers)
    assert (found is None) if conflict is None else (conflict in found)
