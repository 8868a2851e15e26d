from __future__ import annotations

import pytest

from telex_control.hardware_interface import (
    ControllerInfo,
    EffortJointInterface,
    HardwareInterfaceError,
    InterfaceResources,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    RobotHW,
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
        match="'x' in 'hardware_interface::JointStateInterface'; it has: j",
    ):
        states.get_handle("x")


def test_missing_interfaces_are_named():
    robot = RobotHW()
    robot.register_interface(EffortJointInterface())
    with pytest.raises(HardwareInterfaceError, match="VelocityJointInterface.*it has.*Effort"):
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
