from __future__ import annotations

import math

import pytest
from std_msgs.msg import Float64, Float64MultiArray

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    PositionJointInterface,
    VelocityJointInterface,
)

SINGLE = [
    ("effort_controllers/JointEffortController", EffortJointInterface, 0.0),
    ("position_controllers/JointPositionController", PositionJointInterface, 0.4),
    ("velocity_controllers/JointVelocityController", VelocityJointInterface, 0.0),
]
GROUP = [
    ("effort_controllers/JointGroupEffortController", EffortJointInterface, [0.0, 0.0]),
    ("position_controllers/JointGroupPositionController", PositionJointInterface, [0.1, 0.4]),
    ("velocity_controllers/JointGroupVelocityController", VelocityJointInterface, [0.0, 0.0]),
]
JOINTS = ["slide", "elbow"]


@pytest.fixture
def begun(bench):
    """Start the controller "c" on joints that stand at 0.4 (elbow) and 0.1 (slide)."""

    def start(**params):
        tested = bench({"c": params})
        tested.hw.states["elbow"].position = 0.4
        tested.hw.states["slide"].position = 0.1
        tested.load_and_start("c")
        return tested

    return start


def command_of(tested, interface, joint="elbow"):
    return tested.hw.get(interface).get_handle(joint).command


@pytest.mark.parametrize(("kind", "interface", "rest"), SINGLE)
def test_a_joint_rests_until_it_is_commanded(begun, kind, interface, rest):
    tested = begun(type=kind, joint="elbow")
    assert command_of(tested, interface) == rest
    tested.node.advertise("c/command", Float64).publish(Float64(1.25))
    tested.cycle()
    assert command_of(tested, interface) == 1.25
    (info, _) = tested.manager.list_controllers()[0]
    (claim,) = info.claimed_resources
    assert (claim.hardware_interface, claim.resources) == (interface.type_name, ("elbow",))


@pytest.mark.parametrize(("kind", "interface", "rest"), SINGLE)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_is_dropped(begun, kind, interface, rest, bad, caplog):
    tested = begun(type=kind, joint="elbow")
    tested.node.advertise("c/command", Float64).publish(Float64(bad))
    tested.cycle()
    assert command_of(tested, interface) == rest
    assert "/c/command" in caplog.text


@pytest.mark.parametrize(("kind", "interface", "rest"), SINGLE)
def test_stop_and_start_forget_commands(begun, kind, interface, rest):
    tested = begun(type=kind, joint="elbow")
    publisher = tested.node.advertise("c/command", Float64)
    publisher.publish(Float64(1.25))
    tested.cycle()
    assert tested.switch(stop=["c"])
    assert command_of(tested, interface) == rest
    publisher.publish(Float64(9.0))
    assert tested.switch(start=["c"])
    assert command_of(tested, interface) == rest


@pytest.mark.parametrize(("kind", "interface", "rest"), GROUP)
def test_a_group_follows_in_the_order_of_its_joints(begun, kind, interface, rest):
    tested = begun(type=kind, joints=JOINTS)
    assert [command_of(tested, interface, joint) for joint in JOINTS] == rest
    tested.node.advertise("c/command", Float64MultiArray).publish(Float64MultiArray(data=[0.2, 7]))
    tested.cycle()
    assert [command_of(tested, interface, joint) for joint in JOINTS] == [0.2, 7]


@pytest.mark.parametrize(("kind", "interface", "rest"), GROUP)
@pytest.mark.parametrize("bad", [[], [1.0], [1.0, 2.0, 3.0], [1.0, math.nan], [math.inf, 1.0]])
def test_a_group_refuses_wrong_commands_as_a_whole(begun, kind, interface, rest, bad, caplog):
    tested = begun(type=kind, joints=JOINTS)
    tested.node.advertise("c/command", Float64MultiArray).publish(Float64MultiArray(data=bad))
    tested.cycle()
    assert [command_of(tested, interface, joint) for joint in JOINTS] == rest
    assert "/c/command" in caplog.text


@pytest.mark.parametrize(
    ("kind", "params", "logged"),
    [
        (SINGLE[0][0], {}, "/c/joint is missing"),
        (SINGLE[0][0], {"joint": "nose"}, "'nose'"),
        (GROUP[0][0], {}, "/c/joints is missing"),
        (GROUP[0][0], {"joints": []}, "/c/joints is []"),
        (GROUP[0][0], {"joints": ["elbow", "elbow"]}, "distinct"),
        (GROUP[0][0], {"joints": ["elbow", 3]}, "distinct names"),
    ],
)
def test_wrong_parameters_are_named(bench, caplog, kind, params, logged):
    assert not bench({"c": {"type": kind, **params}}).manager.load_controller("c")
    assert logged in caplog.text
