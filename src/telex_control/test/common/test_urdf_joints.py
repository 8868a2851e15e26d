from __future__ import annotations

import math

import pytest

from telex_control.urdf.joints import UrdfError, joints, parse_urdf


def robot(body):
    return parse_urdf(f'<robot name="r"><link name="a"/><link name="b"/>{body}</robot>')


def test_joints_and_limits(bench_urdf):
    found = joints(parse_urdf(bench_urdf))
    assert list(found) == ["elbow", "slide", "wheel"]
    assert (found["elbow"].lower, found["elbow"].upper) == (-1.0, 2.0)
    assert found["slide"].effort == 100.0
    assert found["wheel"].lower == -math.inf
    assert found["wheel"].velocity == 10.0


def test_soft_limits_friction_and_damping():
    joint = joints(
        robot(
            '<joint name="j" type="revolute"><limit lower="-1" upper="1" velocity="1" effort="1"/>'
            '<dynamics friction="0.5" damping="3"/><safety_controller soft_lower_limit="-0.9" '
            'soft_upper_limit="0.8" k_position="20" k_velocity="30"/></joint>'
        )
    )["j"]
    assert (joint.friction, joint.damping) == (0.5, 3.0)
    assert joint.soft is not None
    assert (joint.soft.lower, joint.soft.upper, joint.soft.k_velocity) == (-0.9, 0.8, 30.0)


def safety(kind, attributes):
    return joints(
        robot(
            f'<joint name="j" type="{kind}"><limit lower="-1" upper="1" velocity="1" effort="1"/>'
            f"<safety_controller {attributes}/></joint>"
        )
    )["j"].soft


def test_absent_soft_limits_are_zero_as_urdf_has_it():
    soft = safety("revolute", 'soft_upper_limit="0.8"')
    assert (soft.lower, soft.upper, soft.k_position) == (0.0, 0.8, 0.0)


def test_continuous_joints_have_gains_only():
    soft = safety("continuous", 'k_velocity="10" soft_upper_limit="0.8"')
    assert (soft.lower, soft.upper, soft.k_velocity) == (-math.inf, math.inf, 10.0)


@pytest.mark.parametrize(
    "attributes",
    ['k_velocity="10"', 'soft_lower_limit="0.5"', 'soft_lower_limit="1" soft_upper_limit="-1"'],
)
def test_soft_limits_that_leave_no_room_are_named(attributes):
    with pytest.raises(UrdfError, match=r"joint 'j': soft_lower_limit .* must be below"):
        safety("revolute", attributes)


def test_fixed_joints_are_left_out():
    assert joints(robot('<joint name="j" type="fixed"/>')) == {}


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ('<joint name="j" type="revolute"/>', "'j' is revolute and has no <limit>"),
        ('<joint name="j" type="revolute"><limit lower="x"/></joint>', 'lower="x"'),
        ('<joint name="j" type="revolute"><limit effort="nan"/></joint>', "a finite number"),
        ('<joint name="j" type="revolute"><limit lower="2" upper="1"/></joint>', "above"),
        ('<joint name="j" type="continuous"><dynamics friction="-1"/></joint>', "friction is -1"),
        ('<joint name="j" type="continuous"><dynamics damping="-2"/></joint>', "damping is -2"),
    ],
)
def test_wrong_joints_are_named(body, named):
    with pytest.raises(UrdfError, match=named):
        joints(robot(body))


@pytest.mark.parametrize("text", ["", "not xml", "<robot>", "<sdf/>"])
def test_no_robot(text):
    with pytest.raises(UrdfError, match="robot_description"):
        parse_urdf(text)
