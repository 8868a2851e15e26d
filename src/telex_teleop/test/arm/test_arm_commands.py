"""Commands to the tool and settings of the arm: what is taken, and what a refusal says."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from arm_rig import FRAMES, JOINTS, LIMITS

from telex_control.common.params import ConfigError, read_config
from telex_teleop.arm.arm_settings import ArmTeleopSettings, carrier_of
from telex_teleop.arm.tool_command import Frame
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_follower import JointFollower
from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.motion.reference import MotionLimits

SOURCE = Path(__file__).parents[3]
CONFIG = yaml.safe_load((SOURCE / "telex_teleop" / "config" / "arm_teleop.yaml").read_text())
POSES = yaml.safe_load((SOURCE / "telex_description" / "config" / "poses.yaml").read_text())
ZERO, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("name", "frame"),
    [
        ("tool", Frame.TOOL),
        ("base", Frame.BASE),
        ("/base", Frame.BASE),
        ("world", Frame.WORLD),
        ("", Frame.TOOL),
    ],
)
def test_frames(name, frame):
    assert FRAMES.find(name) is frame


@pytest.mark.parametrize("name", ["camera", "Tool", "tool_link ", "odom"])
def test_unknown_frame_is_refused_with_those_that_are_known(name):
    with pytest.raises(InvalidCommand) as refusal:
        FRAMES.twist(name, ZERO, ZERO)
    assert repr(name) in str(refusal.value)
    assert "must be tool, base, world, or empty for tool" in str(refusal.value)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308])
@pytest.mark.parametrize("axis", range(3))
def test_twist_that_is_not_finite_is_refused(bad, axis):
    values = [0.0, 0.0, 0.0]
    values[axis] = bad
    with pytest.raises(InvalidCommand, match=f"twist.linear.{'xyz'[axis]} is"):
        FRAMES.twist("base", values, ZERO)
    with pytest.raises(InvalidCommand, match=f"twist.angular.{'xyz'[axis]} is"):
        FRAMES.twist("base", ZERO, values)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1e39])
def test_pose_that_is_not_finite_is_refused(bad):
    with pytest.raises(InvalidCommand, match=r"pose.position.y is"):
        FRAMES.pose("base", (0.0, bad, 0.0), UP)
    with pytest.raises(InvalidCommand, match=r"pose.orientation.w is"):
        FRAMES.pose("base", ZERO, (0.0, 0.0, 0.0, bad))


@pytest.mark.parametrize("quaternion", [(0, 0, 0, 0), (0, 0, 0, 2), (0.5, 0.5, 0.5, 0.6)])
def test_quaternion_that_is_not_normalised_is_refused(quaternion):
    with pytest.raises(InvalidCommand, match="norm"):
        FRAMES.pose("base", ZERO, quaternion)


def test_pose_is_a_transform():
    half = math.sqrt(0.5)
    pose = FRAMES.pose("base", (1.0, 2.0, 3.0), (0.0, 0.0, half, half)).pose
    assert pose == pytest.approx(
        np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]), abs=1e-12
    )


def test_follower_is_exact_where_it_can_be_and_keeps_its_limits_elsewhere():
    limits = MotionLimits(-1.0, 1.0, 0.5, 2.0, 0.1, 0.005)
    follower = JointFollower([limits])
    follower.rest_at(np.zeros(1))
    goals = [0.0005 * n**2 * 0.2 for n in range(20)]
    smooth = [float(follower.update(np.array([goal]), 0.01)[0]) for goal in goals]
    assert smooth == pytest.approx(goals, abs=1e-12)
    follower.rest_at(np.zeros(1))
    steps = [float(follower.update(np.array([0.2]), 0.01)[0]) for _ in range(150)]
    speeds = np.diff([0.0, *steps]) / 0.01
    assert np.abs(speeds).max() <= 0.5 + 1e-9
    assert np.abs(np.diff([0.0, *speeds]) / 0.01).max() <= 2.0 + 1e-6
    assert max(steps) <= 0.2 + 1e-9  # no overshoot
    assert steps[-1] == 0.2
    assert follower.resting


class TestSettings:
    def read(self, **changes):
        return read_config(ArmTeleopSettings, {**CONFIG, **POSES, **changes}, "/arm_teleop")

    def test_file_of_the_package_is_what_the_defaults_are(self):
        given = self.read()
        default = ArmTeleopSettings(joints=given.joints, optional_joints=given.optional_joints)
        assert given.frames == default.frames
        assert given.cartesian == default.cartesian
        assert given.proximity == default.proximity

    @pytest.mark.parametrize(
        ("changes", "says"),
        [
            ({"frames": {"tool": "base_link"}}, "must differ"),
            ({"frames": {"default": "moon"}}, "default is 'moon'"),
            ({"frames": {"base_pose": "gps"}}, "base_pose is 'gps'; sim, odom are possible"),
            ({"cartesian": {"max_linear": -1.0}}, "cartesian: max_linear is -1.0"),
            ({"cartesian": {"max_speed": 1.0}}, "cartesian/max_speed is unknown"),
            ({"proximity": {"stop_distance": -0.1}}, "proximity: stop_distance is -0.1"),
            ({"proximity": {"max_age": math.nan}}, "proximity/max_age is nan"),
            ({"poses": {"up": {"x": "high"}}}, "poses/up/x is 'high'"),
        ],
    )
    def test_bad_ones_are_refused_with_name_and_value(self, changes, says):
        with pytest.raises(ConfigError, match=says):
            self.read(**changes)


class TestCarrier:
    AXES = {name: AxisSettings(limits, 0.5) for name, limits in zip(JOINTS, LIMITS)}

    def settings(self, poses=None):
        return ArmTeleopSettings(joints=("a", "b"), poses=poses or {})

    @staticmethod
    def robot(*joints, tip="tool_link"):
        links = ["base_link", *(f"{joint}_link" for joint in joints[:-1]), tip]
        parts = [f'<link name="{link}"/>' for link in links]
        for parent, joint, child in zip(links, joints, links[1:]):
            parts.append(
                f'<joint name="{joint}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{child}"/><axis xyz="0 0 1"/><origin xyz="0.3 0 0"/>'
                '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
            )
        return f'<robot name="r">{"".join(parts)}</robot>'

    def axes(self, *names):
        return {name: AxisSettings(LIMITS[0], 0.5) for name in names}

    def test_joints_are_those_from_base_to_tool(self):
        chain, carrier, problems = carrier_of(
            self.settings(), self.robot("a", "b"), self.axes("b", "a", "camera")
        )
        assert chain is not None
        assert carrier.joints == ("a", "b")
        assert problems == []

    def test_robot_without_tool_says_so(self):
        chain, carrier, _ = carrier_of(
            self.settings(), self.robot("a", "b", tip="hand"), self.axes("a", "b")
        )
        assert chain is None
        assert "not available for this robot" in carrier.lacking
        assert "tool_link" in carrier.lacking

    def test_joint_of_another_node_in_the_arm_says_so(self):
        chain, carrier, _ = carrier_of(self.settings(), self.robot("a", "b"), self.axes("a"))
        assert chain is None
        assert "b carry tool_link, but are not among this node's joints" in carrier.lacking

    @pytest.mark.parametrize(
        ("change", "to"), [('type="revolute"', 'type="fixed"'), ('lower="-1"', 'lower="1"')]
    )
    def test_tool_that_cannot_move_against_the_base_is_no_arm(self, change, to):
        robot = self.robot("a").replace(change, to)
        chain, carrier, _ = carrier_of(self.settings(), robot, self.axes("a", "camera"))
        assert chain is None
        assert "no joint from base_link to tool_link can move" in carrier.lacking

    def test_poses_that_do_not_fit_are_left_out_with_the_reason(self):
        poses = {
            "fits": {"a": 1.0, "b": -1.005, "flipper": 9.0},
            "short": {"a": 0.0},
            "far": {"a": 0.0, "b": 1.5},
        }
        _, carrier, problems = carrier_of(
            self.settings(poses), self.robot("a", "b"), self.axes("a", "b")
        )
        assert dict(carrier.poses) == {"fits": [1.0, -1.0]}
        assert problems == [
            "pose short is left out: it says nothing of b",
            "pose far is left out: b is 1.5; this robot's may be from -1 to 1",
        ]
