"""The six handles: the cases of upstream's joint_limits_interface_test, and what it leaves out."""

from __future__ import annotations

import dataclasses
import math

import pytest

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    HardwareInterfaceError,
    JointHandle,
    JointStateHandle,
    PositionJointInterface,
    VelocityJointInterface,
)
from telex_control.hardware.joint_limits import (
    JointLimits,
    JointLimitsError,
    SoftJointLimits,
    clamp,
)
from telex_control.hardware.joint_limits_interface import (
    EffortJointSaturationHandle,
    EffortJointSoftLimitsHandle,
    JointLimitsInterface,
    PositionJointSaturationHandle,
    PositionJointSoftLimitsHandle,
    VelocityJointSaturationHandle,
    VelocityJointSoftLimitsHandle,
    limits_handle,
)

PERIOD = 0.1
LIMITS = JointLimits(min_position=-1.0, max_position=1.0, max_velocity=2.0, max_effort=8.0)
SOFT = SoftJointLimits(min_position=-0.8, max_position=0.8, k_position=20.0, k_velocity=40.0)
STEP = 0.2  # what LIMITS.max_velocity allows in PERIOD


def without(limits, *names):
    return dataclasses.replace(limits, **dict.fromkeys(names, math.inf))


def joint(position=0.0, velocity=0.0, name="j"):
    handle = JointHandle(JointStateHandle(name))
    handle.state.position, handle.state.velocity = position, velocity
    return handle


def enforced(handle, target, command, period=PERIOD):
    target.command = command
    handle.enforce(period)
    return target.command


@pytest.mark.parametrize(
    ("value", "expected"), [(-0.5, -0.5), (-1, -1), (-2, -1), (2, 2), (3, 2), (math.inf, 2)]
)
def test_clamp(value, expected):
    assert clamp(value, -1.0, 2.0) == expected


def test_the_upper_bound_wins_where_bounds_have_crossed():
    assert [clamp(value, 3.0, 1.0) for value in (0.0, 2.0, 4.0)] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("kind", "missing"),
    [
        (lambda j, limits: PositionJointSoftLimitsHandle(j, limits, SOFT), "max_velocity"),
        (EffortJointSaturationHandle, "max_velocity"),
        (EffortJointSaturationHandle, "max_effort"),
        (lambda j, limits: EffortJointSoftLimitsHandle(j, limits, SOFT), "max_velocity"),
        (lambda j, limits: EffortJointSoftLimitsHandle(j, limits, SOFT), "max_effort"),
        (VelocityJointSaturationHandle, "max_velocity"),
    ],
)
def test_what_a_handle_needs_is_named(kind, missing):
    kind(joint(), LIMITS)
    with pytest.raises(JointLimitsError, match=f"joint 'j'. It has no {missing}"):
        kind(joint(), without(LIMITS, missing))


def test_position_saturation_and_soft_velocity_limits_need_nothing():
    target = joint()
    assert enforced(PositionJointSaturationHandle(target, JointLimits()), target, 99.0) == 99.0
    handle = VelocityJointSoftLimitsHandle(target, JointLimits(), SOFT)
    assert enforced(handle, target, 99.0) == 99.0


def position_handles(target):
    return [
        PositionJointSaturationHandle(target, LIMITS),
        PositionJointSoftLimitsHandle(target, LIMITS, SOFT),
    ]


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("fraction", [0.5, -0.5, 1.0, -1.0, 2.0, -2.0])
def test_a_position_moves_no_faster_than_the_velocity_limit(which, fraction):
    target = joint()
    handle = position_handles(target)[which]
    expected = max(min(fraction, 1.0), -1.0) * STEP
    assert enforced(handle, target, fraction * STEP) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("which", [0, 1])
def test_velocity_is_that_of_the_commands_not_of_the_joint(which):
    target = joint()
    handle = position_handles(target)[which]
    for count in (1, 2, 3):
        assert enforced(handle, target, 1.0) == pytest.approx(count * STEP)


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_position_stays_within_the_hard_limits(which, sign):
    target = joint(position=sign * 0.95)
    handle = PositionJointSaturationHandle(target, LIMITS)
    if which:
        beyond = SoftJointLimits(-1.5, 1.5, SOFT.k_position, SOFT.k_velocity)
        handle = PositionJointSoftLimitsHandle(target, LIMITS, beyond)
    assert enforced(handle, target, sign * 2.0) == sign * 1.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_soft_limits_let_no_position_go_further_out(sign):
    target = joint(position=sign * 0.8)
    handle = PositionJointSoftLimitsHandle(target, LIMITS, SOFT)
    assert enforced(handle, target, sign * 1.0) == pytest.approx(sign * 0.8, abs=1e-12)
    assert sign * enforced(handle, target, 0.0) < 0.8


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_beyond_a_soft_limit_a_position_is_led_back(sign):
    target = joint(position=sign * 0.9)
    handle = PositionJointSoftLimitsHandle(target, LIMITS, SOFT)
    # 20/s * 0.1 rad = 2 rad/s for 0.1 s
    assert enforced(handle, target, sign * 1.0) == pytest.approx(sign * 0.7)
    assert sign * enforced(handle, target, 0.0) < 0.7


def test_a_joint_without_ends_has_no_soft_position_limits():
    target = joint(position=5.0)
    limits = JointLimits(max_velocity=2.0)
    handle = PositionJointSoftLimitsHandle(target, limits, SOFT)
    assert enforced(handle, target, 9.0) == pytest.approx(5.2)


@pytest.mark.parametrize("which", [0, 1])
def test_reset_begins_with_the_measured_position(which):
    target = joint()
    handle = position_handles(target)[which]
    assert enforced(handle, target, 1.0) == pytest.approx(STEP)
    target.state.position = 0.7
    handle.reset()
    assert enforced(handle, target, 0.75) == 0.75


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_position_that_is_not_finite_holds(which, bad):
    target = joint(position=0.3)
    handle = position_handles(target)[which]
    assert enforced(handle, target, bad) == 0.3
    assert enforced(handle, target, 0.4) == 0.4
    assert enforced(handle, target, bad) == 0.4


@pytest.mark.parametrize(
    ("position", "velocity", "command", "expected"),
    [
        (0.0, 0.0, 5.0, 5.0),
        (0.0, 0.0, 50.0, 8.0),
        (0.0, 0.0, -50.0, -8.0),
        (1.1, 0.0, 5.0, 0.0),
        (1.1, 0.0, -5.0, -5.0),
        (-1.1, 0.0, -5.0, 0.0),
        (-1.1, 0.0, 5.0, 5.0),
        (0.0, 2.1, 5.0, 0.0),
        (0.0, 2.1, -5.0, -5.0),
        (0.0, -2.1, -5.0, 0.0),
        (1.1, -2.1, 5.0, 0.0),
        (1.1, -2.1, -5.0, 0.0),
        (1.0, 2.0, 5.0, 5.0),
        (0.0, 0.0, math.nan, 0.0),
        (0.0, 0.0, math.inf, 0.0),
    ],
)
def test_effort_saturation(position, velocity, command, expected):
    target = joint(position, velocity)
    assert enforced(EffortJointSaturationHandle(target, LIMITS), target, command) == expected


@pytest.mark.parametrize(
    ("position", "velocity", "command", "expected"),
    [
        (0.0, 0.0, 5.0, 5.0),
        (0.0, 0.0, 50.0, 8.0),
        # 20 * (0.8 - 0.79) = 0.2 rad/s are allowed; 40 * (0.2 - 0.1) = 4 Nm
        (0.79, 0.1, 8.0, 4.0),
        (-0.79, -0.1, -8.0, -4.0),
        # faster than allowed: 40 * (0.2 - 0.3) = -4 Nm, whatever is commanded
        (0.79, 0.3, 8.0, -4.0),
        (-0.79, -0.3, -8.0, 4.0),
        (0.79, 0.3, -8.0, -8.0),
        # on the soft limit and at rest: nothing outwards, anything back
        (0.8, 0.0, 8.0, 0.0),
        (0.8, 0.0, -8.0, -8.0),
        # beyond it: 20 * 0.01 = 0.2 rad/s back are asked for
        (0.81, 0.0, 8.0, -8.0),
        (0.0, 2.1, 8.0, -4.0),
        (0.79, 0.3, math.nan, -4.0),
        (0.0, 0.0, math.inf, 0.0),
    ],
)
def test_effort_soft_limits(position, velocity, command, expected):
    target = joint(position, velocity)
    handle = EffortJointSoftLimitsHandle(target, LIMITS, SOFT)
    assert enforced(handle, target, command) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("command", "expected"),
    [(1.0, 1.0), (-1.0, -1.0), (2.0, 2.0), (4.0, 2.0), (-4.0, -2.0), (math.nan, 0.0)],
)
def test_velocity_saturation(command, expected):
    target = joint()
    assert enforced(VelocityJointSaturationHandle(target, LIMITS), target, command) == expected


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_velocity_changes_no_faster_than_the_acceleration_limit(sign):
    target = joint()
    limits = dataclasses.replace(LIMITS, max_acceleration=20.0)  # 2 rad/s in a period
    handle = VelocityJointSaturationHandle(target, limits)
    assert enforced(handle, target, sign * 1.0, period=1000.0) == sign * 1.0
    assert enforced(handle, target, sign * 4.0) == sign * 2.0  # the velocity limit
    assert enforced(handle, target, sign * 1.0, period=1000.0) == sign * 1.0
    assert enforced(handle, target, sign * -4.0) == sign * -1.0  # the acceleration limit


def test_reset_velocity_begins_at_rest():
    target = joint()
    handle = VelocityJointSaturationHandle(
        target, dataclasses.replace(LIMITS, max_acceleration=5.0)
    )
    assert enforced(handle, target, 2.0) == pytest.approx(0.5)
    assert enforced(handle, target, 2.0) == pytest.approx(1.0)
    handle.reset()
    assert enforced(handle, target, 2.0) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("position", "velocity", "command", "expected"),
    [
        (0.0, 0.0, 1.0, 0.5),  # acceleration from the measured velocity
        (0.0, 1.0, -1.0, 0.5),
        (0.79, 0.2, 2.0, 0.2),  # 20 * 0.01
        (0.9, 0.0, 2.0, -2.0),  # where the bounds cross, the limit counts
        (-0.9, 0.0, -2.0, 0.5),  # … from below, the acceleration
        (0.0, 0.0, math.nan, 0.0),
    ],
)
def test_velocity_soft_limits(position, velocity, command, expected):
    target = joint(position, velocity)
    limits = dataclasses.replace(LIMITS, max_acceleration=5.0)
    handle = VelocityJointSoftLimitsHandle(target, limits, SOFT)
    assert enforced(handle, target, command) == pytest.approx(expected)


def test_an_interface_enforces_and_resets_all():
    targets = [joint(position=0.9, name=name) for name in ("a", "b")]
    interface = JointLimitsInterface()
    for target in targets:
        interface.register_handle(PositionJointSoftLimitsHandle(target, LIMITS, SOFT))
        target.command = 1.0
    assert interface.get_handle("b").name == "b"
    with pytest.raises(HardwareInterfaceError, match="'c' in 'joint_limits_interface::"):
        interface.get_handle("c")
    interface.enforce(PERIOD)
    assert [target.command for target in targets] == pytest.approx([0.7, 0.7])
    for target in targets:
        target.state.position = 0.0
        target.command = 0.1
    interface.reset()
    interface.enforce(PERIOD)
    assert [target.command for target in targets] == [0.1, 0.1]


@pytest.mark.parametrize(
    ("interface", "saturation", "soft"),
    [
        (EffortJointInterface, EffortJointSaturationHandle, EffortJointSoftLimitsHandle),
        (VelocityJointInterface, VelocityJointSaturationHandle, VelocityJointSoftLimitsHandle),
        (PositionJointInterface, PositionJointSaturationHandle, PositionJointSoftLimitsHandle),
    ],
)
def test_the_handle_is_chosen_by_interface_and_soft_limits(interface, saturation, soft):
    assert type(limits_handle(interface, joint(), LIMITS)) is saturation
    assert type(limits_handle(interface, joint(), LIMITS, SOFT)) is soft


INTERFACES = (EffortJointInterface, VelocityJointInterface, PositionJointInterface)


@pytest.mark.parametrize("soft", [None, SOFT])
@pytest.mark.parametrize("interface", INTERFACES)
def test_a_joint_without_limits_is_given_any_number(interface, soft):
    target = joint(position=0.3, velocity=99.0)
    handle = limits_handle(interface, target, JointLimits(), soft)
    assert enforced(handle, target, -1e9) == -1e9
    assert enforced(handle, target, 1e9) == 1e9
    for bad in (math.nan, math.inf, -math.inf):
        assert enforced(handle, target, bad) == (1e9 if interface is PositionJointInterface else 0)


@pytest.mark.parametrize(
    ("interface", "lacking", "position", "expected"),
    [
        (EffortJointInterface, "max_velocity", 0.0, 8.0),
        (EffortJointInterface, "max_velocity", 1.1, 0.0),
        (EffortJointInterface, "max_effort", 0.0, 50.0),
        (EffortJointInterface, "max_effort", 1.1, 0.0),
        (VelocityJointInterface, "max_effort", 0.0, 2.0),
        (PositionJointInterface, "max_velocity", 0.0, 1.0),
    ],
)
def test_of_a_joints_limits_those_that_there_are_are_enforced(
    interface, lacking, position, expected
):
    target = joint(position)
    handle = limits_handle(interface, target, without(LIMITS, lacking))
    assert enforced(handle, target, 50.0) == expected


@pytest.mark.parametrize(
    "lacking", [("max_velocity",), ("max_effort",), ("max_velocity", "max_effort")]
)
def test_a_soft_limit_needs_no_other_limits(lacking):
    target = joint(0.8)
    handle = limits_handle(EffortJointInterface, target, without(LIMITS, *lacking), SOFT)
    assert enforced(handle, target, 5.0) == 0.0
    assert enforced(handle, target, -5.0) == -5.0
