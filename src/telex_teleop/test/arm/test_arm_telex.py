"""The tool's motion on Telex's own arm, with the inverse kinematics that the node uses."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from arm_rig import TICK
from hypothesis import given, settings
from hypothesis import strategies as st

from telex_control.common.params import read_config
from telex_teleop.arm.arm_settings import ArmTeleopSettings, carrier_of
from telex_teleop.arm.ik_kinematics import IKKinematics
from telex_teleop.arm.tool_motion import ToolMotion
from telex_teleop.motion.limits import limits_from_urdf

pytestmark = pytest.mark.slow

SOURCE = Path(__file__).parents[3]
DESCRIPTION = SOURCE / "telex_description"
AXES = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]


class Arm:
    """Telex's arm in the pose ready, whose joints are where their references are."""

    def __init__(self):
        script = DESCRIPTION / "scripts" / "robot_description"
        urdf = subprocess.run(
            [sys.executable, str(script)], capture_output=True, text=True, check=True
        ).stdout
        config = yaml.safe_load(
            (SOURCE / "telex_teleop" / "config" / "arm_teleop.yaml").read_text()
        )
        poses = yaml.safe_load((DESCRIPTION / "config" / "poses.yaml").read_text())
        given = read_config(ArmTeleopSettings, {**config, **poses}, "/arm_teleop")
        axes = given.axes(limits_from_urdf(urdf, given.joints))
        self.chain, carrier, problems = carrier_of(given, urdf, axes)
        assert problems == []
        self.frames = given.frames.names()
        self.limits = [axes[joint].motion for joint in carrier.joints]
        self.kinematics = IKKinematics(self.chain, self.limits)
        self.kinematics.warm_up()
        self.ready = np.array(carrier.poses["ready"])
        self.settings = given.cartesian
        self.reset()

    def reset(self):
        self.motion = ToolMotion(
            self.chain.joint_names,
            self.limits,
            [joint.kind == "prismatic" for joint in self.chain.joints],
            self.kinematics,
            self.settings,
        )
        self.path = [self.ready]
        return self

    def run(self, duration, frame="base_link", linear=(0.0, 0.0, 0.0), angular=(0.0, 0.0, 0.0)):
        command = self.frames.twist(frame, linear, angular)
        for _ in range(round(duration / TICK)):
            q = self.path[-1]
            moved = self.motion.update(TICK, command if command.moves else None, q, q, None, 1.0)
            self.path.append(q if moved is None else moved)

    def poses(self):
        return np.array([self.kinematics.forward(q) for q in self.path])

    def check_limits(self):
        velocity = np.diff(self.path, axis=0) / TICK
        acceleration = np.diff(velocity, axis=0) / TICK
        for index, limits in enumerate(self.limits):
            assert np.abs(velocity[:, index]).max() <= limits.max_velocity * (1 + 1e-9)
            assert np.abs(acceleration[:, index]).max() <= limits.max_acceleration * (1 + 1e-6)
            assert limits.lower - 1e-12 <= np.array(self.path)[:, index].min()
            assert np.array(self.path)[:, index].max() <= limits.upper + 1e-12


@pytest.fixture(scope="module")
def telex():
    return Arm()


@pytest.fixture
def arm(telex):
    return telex.reset()


@pytest.mark.parametrize("direction", AXES, ids=["+x", "-x", "+y", "-y", "+z", "-z"])
def test_tool_stays_on_its_line_at_full_speed(arm, direction):
    arm.run(1.2, linear=arm.settings.max_linear * direction)
    arm.run(1.0)
    away = arm.poses()[:, :3, 3] - arm.poses()[0, :3, 3]
    along = away @ direction
    assert along[-1] > 0.08
    assert np.abs(away - np.outer(along, direction)).max() < 1.5e-3
    assert np.abs(arm.poses()[-1, :3, :3] - arm.poses()[0, :3, :3]).max() < 5e-3
    arm.check_limits()
    assert not arm.motion.moving


@pytest.mark.parametrize("direction", AXES, ids=["+x", "-x", "+y", "-y", "+z", "-z"])
def test_tool_centre_point_stays_while_the_tool_turns(arm, direction):
    arm.run(1.0, "tool_link", angular=0.5 * arm.settings.max_angular * direction)
    arm.run(1.0)
    away = arm.poses()[:, :3, 3] - arm.poses()[0, :3, 3]
    assert np.linalg.norm(away, axis=1).max() < 3e-3
    arm.check_limits()


def test_end_of_reach_is_come_to_smoothly_named_and_slid_along(arm):
    arm.run(9.0, linear=(0.15, 0.0, 0.0))
    assert arm.motion.slowdown is not None
    assert "from its limit" in str(arm.motion.slowdown) or "singularity" in str(arm.motion.slowdown)
    speeds = np.linalg.norm(np.diff(arm.poses()[:, :3, 3], axis=0), axis=1) / TICK
    assert speeds[-50:].max() < 0.01
    before = arm.poses()[-1, :3, 3]
    arm.run(2.0, linear=(0.1, 0.0, 0.1))
    assert arm.poses()[-1, 2, 3] - before[2] > 0.03
    arm.run(1.0)
    before = arm.poses()[-1, :3, 3]
    arm.run(1.0, linear=(-0.1, 0.0, 0.0))
    assert arm.poses()[-1, 0, 3] - before[0] < -0.03
    arm.check_limits()


def test_arm_rests_after_it_was_pushed_against_the_end_of_its_reach(arm):
    arm.run(9.0, linear=(0.15, 0.0, 0.0))
    arm.run(1.5)
    assert not arm.motion.moving
    assert np.array_equal(arm.path[-1], arm.path[-2])


twists = st.tuples(
    st.sampled_from(["base_link", "tool_link"]),
    st.tuples(*[st.floats(-0.3, 0.3)] * 3),
    st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    st.floats(0.05, 2.0),
)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.lists(twists, min_size=1, max_size=4))
def test_no_joint_exceeds_its_limits_whatever_is_commanded(telex, commands):
    arm = telex.reset()
    for frame, linear, angular, duration in commands:
        arm.run(duration, frame, linear, angular)
    arm.run(3.0)
    arm.check_limits()
    assert not arm.motion.moving
