"""Main functions of the joint teleoperation nodes."""

from __future__ import annotations

from typing import Dict

import rospy

from telex_control.ros.robot_description import wait_for_robot_description
from telex_control.urdf.joints import joints, parse_urdf
from telex_teleop.arm.arm_settings import ArmTeleopSettings, carrier_of
from telex_teleop.arm.arm_teleop import ArmTeleop
from telex_teleop.arm.base_pose import BasePose
from telex_teleop.arm.proximity import ProximityGuard
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.flippers.flipper_teleop import FlipperTeleop
from telex_teleop.joints.coupled_teleop import CoupledTeleop
from telex_teleop.joints.joint_settings import GripperTeleopSettings, JointTeleopSettings
from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.limits import JointBounds, limits_from_urdf
from telex_teleop.ros.arm_teleop import ArmTeleopNode
from telex_teleop.ros.common import private_settings, run_node
from telex_teleop.ros.flipper_teleop import FlipperTeleopNode
from telex_teleop.ros.joint_teleop import JointTeleopNode
from telex_teleop.ros.kinematics_services import KinematicsServices

__all__ = ["arm_main", "flipper_main", "gripper_main"]


def arm_main() -> int:
    """Run the node that moves the arm by its joints or its tool, and its camera's pan and tilt."""
    return run_node("arm_teleop", _start_arm)


def flipper_main() -> int:
    """Run the node that jogs the four flippers, and leads them to presets."""
    return run_node("flipper_teleop", _start_flippers)


def gripper_main() -> int:
    """Run the node that opens and closes the gripper, or jogs its joints one by one."""
    return run_node("gripper_teleop", _start_gripper)


def _limits(settings: JointTeleopSettings) -> Dict[str, JointBounds]:
    """Wait for the robot, and return the limits of those of the node's joints that it has."""
    description = wait_for_robot_description()
    lacking = settings.lacking(joints(parse_urdf(description)))
    if lacking:
        rospy.loginfo(f"{rospy.get_name()}: left out, for this robot has no {', '.join(lacking)}")
    return limits_from_urdf(description, [name for name in settings.joints if name not in lacking])


def _start_arm() -> object:
    settings = private_settings(ArmTeleopSettings)
    description = wait_for_robot_description()
    axes = settings.axes(_limits(settings))
    chain, carrier, problems = carrier_of(settings, description, axes)
    for problem in problems:
        rospy.logwarn(f"{rospy.get_name()}: {problem}")
    core = ArmTeleop(
        axes,
        carrier,
        settings.command_timeout,
        settings.longest_step,
        settings.speed_scale(),
        ProximityGuard(settings.proximity),
        BasePose(settings.frames.base_pose_max_age),
    )
    links = list(parse_urdf(description).link_map)
    node = ArmTeleopNode(core, settings, chain, links)
    return node, KinematicsServices(node, chain, settings.frames)


def _start_flippers() -> FlipperTeleopNode:
    settings = private_settings(FlipperTeleopSettings)
    axes = settings.axes(_limits(settings))
    core = FlipperTeleop(
        axes=axes,
        presets=settings.preset_table(axes),
        goal_rules=settings.goal_rules(),
        command_timeout=settings.command_timeout,
        longest_step=settings.longest_step,
        speed=settings.speed_scale(),
    )
    return FlipperTeleopNode(core, settings.status_rate)


def _without_joints(settings: JointTeleopSettings) -> JointTeleop:
    """Return a core that answers operators of a robot without the node's joints."""
    return JointTeleop({}, settings.command_timeout, settings.longest_step, settings.speed_scale())


def _start_gripper() -> JointTeleopNode:
    settings = private_settings(GripperTeleopSettings)
    limits = _limits(settings)
    if not limits:
        return JointTeleopNode(_without_joints(settings), settings.status_rate)
    group = settings.coupling
    fingers = settings.axes(limits)
    core = CoupledTeleop(
        joints=fingers,
        group=settings.axis(group.name, group.limits(fingers)),
        coupling=group.coupling(),
        command_timeout=settings.command_timeout,
        longest_step=settings.longest_step,
        speed=settings.speed_scale(),
    )
    return JointTeleopNode(core, settings.status_rate)
