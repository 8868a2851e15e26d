"""Where limits come from: the cases of upstream's tests of URDF and parameters, and ours."""

from __future__ import annotations

import math

import pytest

from telex_control.common.params import ConfigError
from telex_control.hardware.joint_limits import (
    JointLimits,
    JointLimitsError,
    SoftJointLimits,
    joint_limits,
)
from telex_control.urdf.joints import SoftLimits, UrdfJoint


def described(kind="revolute", **changes):
    values = {
        "name": "j",
        "kind": kind,
        "lower": -1.0,
        "upper": 2.0,
        "velocity": 3.0,
        "effort": 4.0,
        "friction": 0.0,
        "damping": 0.0,
        "soft": SoftLimits(-0.9, 1.9, 20.0, 30.0),
    }
    return UrdfJoint(**{**values, **changes})


CONTINUOUS = described("continuous", lower=-math.inf, upper=math.inf, soft=None)


def limits_with(params, joint=None):
    return joint_limits(joint or described(), {"j": params})


def test_limits_of_the_urdf():
    limits, soft = joint_limits(described())
    assert limits == JointLimits(-1.0, 2.0, 3.0, math.inf, math.inf, 4.0)
    assert soft == SoftJointLimits(-0.9, 1.9, 20.0, 30.0)
    limits, soft = joint_limits(CONTINUOUS)
    assert not limits.has_position_limits
    assert limits.angle_wraparound
    assert soft is None


def test_parameters_of_other_joints_change_nothing():
    assert joint_limits(described(), {"other": {"has_effort_limits": False}}) == joint_limits(
        described()
    )
    assert joint_limits(described(), None) == joint_limits(described())


def test_parameters_prevail():
    limits, soft = limits_with(
        {
            "has_position_limits": True,
            "min_position": 0,
            "max_position": 1.5,
            "has_velocity_limits": True,
            "max_velocity": 0.5,
            "has_acceleration_limits": True,
            "max_acceleration": 5.0,
            "has_jerk_limits": True,
            "max_jerk": 100.0,
            "has_effort_limits": True,
            "max_effort": 2.0,
            "has_soft_limits": True,
            "k_position": 10.0,
            "k_velocity": 20.0,
            "soft_lower_limit": 0.1,
            "soft_upper_limit": 1.4,
        }
    )
    assert limits == JointLimits(0.0, 1.5, 0.5, 5.0, 100.0, 2.0)
    assert soft == SoftJointLimits(0.1, 1.4, 10.0, 20.0)


def test_what_parameters_do_not_mention_is_the_urdfs():
    limits, soft = limits_with({"has_velocity_limits": True, "max_velocity": 0.5})
    assert limits == JointLimits(-1.0, 2.0, 0.5, math.inf, math.inf, 4.0)
    assert soft is not None


def test_a_false_flag_takes_a_limit_away():
    limits, soft = limits_with(
        {
            "has_position_limits": False,
            "angle_wraparound": True,
            "has_velocity_limits": False,
            "max_velocity": 0.5,
            "has_effort_limits": False,
            "has_soft_limits": False,
        }
    )
    assert limits == JointLimits(angle_wraparound=True)
    assert soft is None


def test_a_value_without_its_flag_has_no_effect_and_is_named(caplog):
    limits, _ = limits_with({"max_velocity": 0.5})
    assert limits.max_velocity == 3.0
    assert "joint_limits/j/max_velocity has no effect without has_velocity_limits" in caplog.text


def test_angle_wraparound_is_for_joints_without_ends():
    ends = {"has_position_limits": True, "min_position": -1.0, "max_position": 1.0}
    limits, _ = limits_with({**ends, "angle_wraparound": True}, CONTINUOUS)
    assert limits.has_position_limits
    assert not limits.angle_wraparound


def test_a_continuous_joint_that_gets_ends_has_them_as_soft_limits():
    joint = described(
        "continuous",
        lower=-math.inf,
        upper=math.inf,
        soft=SoftLimits(-math.inf, math.inf, 20.0, 30.0),
    )
    ends = {"has_position_limits": True, "min_position": -1.0, "max_position": 1.0}
    _, soft = limits_with(ends, joint)
    assert soft == SoftJointLimits(-1.0, 1.0, 20.0, 30.0)


def test_soft_limits_that_freeze_a_joint_are_named(caplog):
    joint_limits(described(soft=SoftLimits(-0.9, 1.9, 0.0, 30.0)))
    assert "joint 'j': k_position is 0" in caplog.text


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"has_velocity_limits": True}, "joint_limits/j: .*max_velocity is not given"),
        ({"has_position_limits": True, "max_position": 1.0}, "min_position is not given"),
        ({"has_soft_limits": True, "k_position": 1.0}, "k_velocity is not given"),
        ({"has_velocity_limits": True, "max_velocity": math.nan}, "max_velocity is nan"),
        ({"has_velocity_limits": True, "max_velocity": -1.0}, "max_velocity is -1.0"),
        ({"has_effort_limits": True, "max_effort": 0.0}, "max_effort is 0.0"),
        ({"has_velocity_limits": 1}, "has_velocity_limits is 1; true or false"),
        ({"max_speed": 1.0}, "joint_limits/j/max_speed is unknown"),
        (
            {"has_position_limits": True, "min_position": 1.0, "max_position": -1.0},
            "max_position is -1.0; it must be at least 1",
        ),
        (
            {
                "has_soft_limits": True,
                "k_position": 1.0,
                "k_velocity": 1.0,
                "soft_lower_limit": 1.0,
                "soft_upper_limit": 1.0,
            },
            "soft_upper_limit is 1.0; it must be above 1",
        ),
        ([1.0], "joint_limits/j is .*; a struct is needed"),
    ],
)
def test_wrong_parameters_are_named(params, named):
    with pytest.raises(ConfigError, match=named):
        limits_with(params)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
@pytest.mark.parametrize("limit", ["velocity", "effort"])
def test_wrong_limits_of_the_urdf_are_named(limit, bad):
    with pytest.raises(JointLimitsError, match=f"joint 'j': max_{limit} is {bad}"):
        joint_limits(described(**{limit: bad}))


def test_limits_cannot_be_nan_or_crossed():
    for values in ((math.nan, 1.0), (0.0, math.nan), (1.0, 0.0)):
        with pytest.raises(ValueError, match="min_position"):
            JointLimits(*values)
        with pytest.raises(ValueError, match="soft_lower_limit"):
            SoftJointLimits(*values, 1.0, 1.0)
    for gain in (math.nan, -1.0, math.inf):
        with pytest.raises(ValueError, match="k_velocity"):
            SoftJointLimits(0.0, 1.0, 1.0, gain)
