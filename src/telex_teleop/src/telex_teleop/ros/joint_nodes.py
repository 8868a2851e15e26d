"""Main functions of the joint teleoperation nodes."""

from __future__ import annotations

from typing import Dict

import rospy

from telex_control.ros.robot_description import wait_for_robot_description
from telex_control.urdf.joints import parse_urdf
from telex_teleop.arm.arm_settings import ArmTeleopSettings
from telex_teleop.cores import arm_core, flipper_core, gripper_core
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.joints.joint_settings import (
    GripperTeleopSettings,
    JointTeleopSettings,
    limits_of_present,
)
from telex_teleop.motion.limits import JointBounds
from telex_teleop.ros.arm_teleop_node import ArmTeleopNode
from telex_teleop.ros.common import private_settings, run_node
from telex_teleop.ros.flipper_teleop_node import FlipperTeleopNode
from telex_teleop.ros.joint_teleop_node import JointTeleopNode
from telex_teleop.ros.kinematics_services import KinematicsServices


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
    limits, lacking = limits_of_present(settings, wait_for_robot_description())
    if lacking:
        rospy.loginfo(f"{rospy.get_name()}: left out, for this robot has no {', '.join(lacking)}")
    return limits


def _start_arm() -> object:
    settings = private_settings(ArmTeleopSettings)
    description = wait_for_robot_description()
    arm = arm_core(settings, _limits(settings), description)
    for problem in arm.problems:
        rospy.logwarn(f"{rospy.get_name()}: {problem}")
    links = list(parse_urdf(description).link_map)
    node = ArmTeleopNode(arm.core, settings, arm.chain, links)
    return node, KinematicsServices(node, arm.chain, settings.frames)


def _start_flippers() -> FlipperTeleopNode:
    settings = private_settings(FlipperTeleopSettings)
    return FlipperTeleopNode(flipper_core(settings, _limits(settings)), settings.status_rate)


def _start_gripper() -> JointTeleopNode:
    settings = private_settings(GripperTeleopSettings)
    return JointTeleopNode(gripper_core(settings, _limits(settings)), settings.status_rate)
