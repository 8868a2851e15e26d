from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from telex_control.hardware_interface import (
    ActuatorHandle,
    ActuatorStateHandle,
    JointHandle,
    JointStateHandle,
)
from telex_control.transmission_interface import (
    ActuatorToJointStateHandle,
    DifferentialTransmission,
    JointToActuatorEffortHandle,
    JointToActuatorPositionHandle,
    JointToActuatorVelocityHandle,
    SimpleTransmission,
    TransmissionError,
    TransmissionInterface,
)

values = st.floats(-100.0, 100.0)
reductions = st.floats(0.1, 100.0).flatmap(lambda n: st.sampled_from([n, -n]))


def test_simple_reduces_velocity_and_raises_effort():
    transmission = SimpleTransmission(reduction=50.0, joint_offset=1.0)
    assert transmission.actuator_to_joint_effort([2.0]) == (100.0,)
    assert transmission.actuator_to_joint_velocity([100.0]) == (2.0,)
    assert transmission.actuator_to_joint_position([100.0]) == (3.0,)
    assert transmission.joint_to_actuator_effort([100.0]) == (2.0,)
    assert transmission.joint_to_actuator_velocity([2.0]) == (100.0,)
    assert transmission.joint_to_actuator_position([3.0]) == (100.0,)


def test_a_negative_reduction_turns_against_the_actuator():
    transmission = SimpleTransmission(reduction=-10.0)
    assert transmission.actuator_to_joint_effort([1.0]) == (-10.0,)
    assert transmission.actuator_to_joint_velocity([1.0]) == (-0.1,)


@pytest.mark.parametrize(
    ("first", "second", "moves"), [(1.0, 1.0, (True, False)), (1.0, -1.0, (False, True))]
)
def test_sum_and_difference_of_a_differential(first, second, moves):
    transmission = DifferentialTransmission([10.0, 10.0], [2.0, 2.0])
    for convert in (
        transmission.actuator_to_joint_effort,
        transmission.actuator_to_joint_velocity,
        transmission.actuator_to_joint_position,
    ):
        assert tuple(value != 0.0 for value in convert([first, second])) == moves


def test_figures_of_a_differential():
    transmission = DifferentialTransmission([10.0, -10.0], [2.0, 4.0], [0.5, -0.5])
    assert transmission.actuator_to_joint_effort([1.0, 2.0]) == (-20.0, 120.0)
    assert transmission.actuator_to_joint_velocity([40.0, 80.0]) == (-1.0, 1.5)
    assert transmission.actuator_to_joint_position([40.0, 80.0]) == (-0.5, 1.0)
    assert transmission.joint_to_actuator_effort([-20.0, 120.0]) == (1.0, 2.0)
    assert transmission.joint_to_actuator_velocity([-1.0, 1.5]) == (40.0, 80.0)
    assert transmission.joint_to_actuator_position([-0.5, 1.0]) == (40.0, 80.0)


def there_and_back(transmission, given_values):
    for quantity in ("effort", "velocity", "position"):
        joint = getattr(transmission, f"actuator_to_joint_{quantity}")(given_values)
        back = getattr(transmission, f"joint_to_actuator_{quantity}")(joint)
        assert back == pytest.approx(given_values, rel=1e-6, abs=1e-6)


def power_is_kept(transmission, efforts, velocities):
    joint_efforts = transmission.actuator_to_joint_effort(efforts)
    joint_velocities = transmission.actuator_to_joint_velocity(velocities)
    power = sum(effort * velocity for effort, velocity in zip(efforts, velocities))
    assert sum(
        effort * velocity for effort, velocity in zip(joint_efforts, joint_velocities)
    ) == pytest.approx(power, rel=1e-6, abs=1e-6)


@given(reductions, values, values, values)
def test_simple_is_its_own_inverse_and_keeps_power(reduction, offset, effort, velocity):
    transmission = SimpleTransmission(reduction, offset)
    there_and_back(transmission, [effort])
    power_is_kept(transmission, [effort], [velocity])


@given(st.tuples(*[reductions] * 4), st.tuples(*[values] * 6))
def test_a_differential_is_its_own_inverse_and_keeps_power(ratios, numbers):
    transmission = DifferentialTransmission(ratios[:2], ratios[2:], numbers[:2])
    there_and_back(transmission, numbers[2:4])
    power_is_kept(transmission, numbers[2:4], numbers[4:])


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf])
def test_impossible_ratios_are_named(bad):
    with pytest.raises(TransmissionError, match=f"reduction is {bad}; it must be finite and not 0"):
        SimpleTransmission(bad)
    with pytest.raises(TransmissionError, match="actuator_reduction is"):
        DifferentialTransmission([1.0, bad], [1.0, 1.0])
    with pytest.raises(TransmissionError, match="joint_reduction is"):
        DifferentialTransmission([1.0, 1.0], [bad, 1.0])


def test_offsets_may_be_zero_but_must_be_finite():
    SimpleTransmission(1.0, 0.0)
    with pytest.raises(TransmissionError, match="joint_offset is nan"):
        SimpleTransmission(1.0, math.nan)


def test_a_differential_needs_two_of_each():
    with pytest.raises(TransmissionError, match="joint_reduction has 1 values; 2 are needed"):
        DifferentialTransmission([1.0, 1.0], [1.0])


def test_handles_carry_states_and_commands_over():
    actuators = [ActuatorHandle(ActuatorStateHandle(f"a{i}")) for i in (1, 2)]
    joints = [JointHandle(JointStateHandle(f"j{i}")) for i in (1, 2)]
    transmission = DifferentialTransmission([10.0, -10.0], [2.0, 4.0], [0.5, -0.5])
    for actuator, value in zip(actuators, (40.0, 80.0)):
        actuator.state.position = actuator.state.velocity = value
        actuator.state.effort = value / 40.0
    states = TransmissionInterface()
    states.register_handle(
        ActuatorToJointStateHandle(
            "t", transmission, [a.state for a in actuators], [j.state for j in joints]
        )
    )
    states.propagate()
    assert [j.state.position for j in joints] == [-0.5, 1.0]
    assert [j.state.velocity for j in joints] == [-1.0, 1.5]
    assert [j.state.effort for j in joints] == [-20.0, 120.0]
    for kind, commands, expected in (
        (JointToActuatorEffortHandle, (-20.0, 120.0), [1.0, 2.0]),
        (JointToActuatorVelocityHandle, (-1.0, 1.5), [40.0, 80.0]),
        (JointToActuatorPositionHandle, (-0.5, 1.0), [40.0, 80.0]),
    ):
        for joint, command in zip(joints, commands):
            joint.command = command
        kind("t", transmission, actuators, joints).propagate()
        assert [a.command for a in actuators] == expected


def test_handles_check_their_numbers():
    with pytest.raises(TransmissionError, match="'t': 0 actuators and 1 joints are given"):
        ActuatorToJointStateHandle("t", SimpleTransmission(1.0), [], [JointStateHandle("j")])
