"""Main functions of the joint teleoperation nodes."""

from __future__ import annotations

from typing import Any, Dict

import rospy
from telex_msgs.srv import SetMode, SetModeResponse

from telex_control.robot_description import wait_for_robot_description
from telex_control.urdf_joints import joints, parse_urdf
from telex_teleop.coupled_teleop import CoupledTeleop
from telex_teleop.flipper_settings import FlipperTeleopSettings
from telex_teleop.flipper_teleop import FlipperTeleop
from telex_teleop.joint_teleop import JointTeleop
from telex_teleop.limits import JointLimits, limits_from_urdf
from telex_teleop.motion_settings import GripperTeleopSettings, JointTeleopSettings
from telex_teleop.ros_common import private_settings, run_node
from telex_teleop.ros_flipper_teleop import FlipperTeleopNode
from telex_teleop.ros_joint_teleop import JOINT_MODE, JointTeleopNode

__all__ = ["arm_main", "flipper_main", "gripper_main"]

CARTESIAN_MODE = "CARTESIAN"


def arm_main() -> int:
    """Run the node that jogs the arm's joints and its camera's pan and tilt."""
    return run_node("arm_teleop", _start_arm)


def flipper_main() -> int:
    """Run the node that jogs the four flippers, and leads them to presets."""
    return run_node("flipper_teleop", _start_flippers)


def gripper_main() -> int:
    """Run the node that opens and closes the gripper, or jogs its joints one by one."""
    return run_node("gripper_teleop", _start_gripper)


def _start_joints() -> JointTeleopNode:
    settings = private_settings(JointTeleopSettings)
    return JointTeleopNode(_independent(settings, _limits(settings)), settings.status_rate)


def _limits(settings: JointTeleopSettings) -> Dict[str, JointLimits]:
    """Wait for the robot, and return the limits of those of the node's joints that it has."""
    description = wait_for_robot_description()
    lacking = settings.lacking(joints(parse_urdf(description)))
    if lacking:
        rospy.loginfo(f"{rospy.get_name()}: left out, for this robot has no {', '.join(lacking)}")
    return limits_from_urdf(description, [name for name in settings.joints if name not in lacking])


def _independent(settings: JointTeleopSettings, limits: Dict[str, JointLimits]) -> JointTeleop:
    return JointTeleop(
        settings.axes(limits),
        settings.command_timeout,
        settings.longest_step,
        settings.speed_scale(),
    )


def _start_arm() -> object:
    node = _start_joints()
    return node, rospy.Service("~set_mode", SetMode, _set_mode)


def _set_mode(request: Any) -> SetModeResponse:
    if request.mode == JOINT_MODE:
        return SetModeResponse(success=True, message="")
    if request.mode == CARTESIAN_MODE:
        return SetModeResponse(
            success=False,
            message=f"{CARTESIAN_MODE}: operational-space mode is not available in this version; "
            f"the mode stays {JOINT_MODE}",
        )
    return SetModeResponse(
        success=False,
        message=f"mode {request.mode!r} is unknown; must be {JOINT_MODE} or {CARTESIAN_MODE}",
    )


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


def _start_gripper() -> JointTeleopNode:
    settings = private_settings(GripperTeleopSettings)
    limits = _limits(settings)
    if not limits:
        return JointTeleopNode(_independent(settings, limits), settings.status_rate)
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
