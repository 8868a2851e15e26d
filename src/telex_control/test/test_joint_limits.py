from __future__ import annotations

import math

import pytest

from telex_control.hardware_interface import JointHandle, JointStateHandle
from telex_control.joint_limits import EffortJointSaturationHandle, VelocityJointSaturationHandle


def joint(position=0.0, velocity=0.0, command=0.0):
    handle = JointHandle(JointStateHandle("j"))
    handle.state.position, handle.state.velocity, handle.command = position, velocity, command
    return handle


@pytest.mark.parametrize(
    ("position", "velocity", "command", "expected"),
    [
        (0.0, 0.0, 5.0, 5.0),
        (0.0, 0.0, 50.0, 10.0),
        (0.0, 0.0, -50.0, -10.0),
        (1.1, 0.0, 5.0, 0.0),
        (1.1, 0.0, -5.0, -5.0),
        (-1.1, 0.0, -5.0, 0.0),
        (-1.1, 0.0, 5.0, 5.0),
        (0.0, 2.1, 5.0, 0.0),
        (0.0, 2.1, -5.0, -5.0),
        (0.0, -2.1, -5.0, 0.0),
        (1.1, -2.1, 5.0, 0.0),
        (0.0, 0.0, math.nan, 0.0),
        (0.0, 0.0, math.inf, 0.0),
    ],
)
def test_effort_saturation(position, velocity, command, expected):
    handle = joint(position, velocity, command)
    EffortJointSaturationHandle(handle, -1.0, 1.0, velocity=2.0, effort=10.0).enforce(0.002)
    assert handle.command == expected


@pytest.mark.parametrize(
    ("command", "expected"), [(1.0, 1.0), (3.0, 2.0), (-3.0, -2.0), (math.nan, 0.0)]
)
def test_velocity_saturation(command, expected):
    handle = joint(command=command)
    VelocityJointSaturationHandle(handle, 2.0).enforce(0.002)
    assert handle.command == expected


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
def test_limits_must_be_positive(bad):
    with pytest.raises(ValueError, match="'j'"):
        EffortJointSaturationHandle(joint(), -1.0, 1.0, velocity=bad, effort=1.0)
    with pytest.raises(ValueError, match="'j'"):
        EffortJointSaturationHandle(joint(), -1.0, 1.0, velocity=1.0, effort=bad)
    with pytest.raises(ValueError, match="'j'"):
        VelocityJointSaturationHandle(joint(), bad)
