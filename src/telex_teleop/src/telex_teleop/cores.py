"""Cores of the joint teleoperation nodes, made from their parameters and the robot's URDF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Mapping, Optional

from telex_control.kinematics import Chain
from telex_teleop.arm.arm_settings import ArmTeleopSettings, carrier_of
from telex_teleop.arm.arm_teleop import ArmTeleop
from telex_teleop.arm.base_pose import BasePose
from telex_teleop.arm.ik_kinematics import IKKinematics
from telex_teleop.arm.proximity import ProximityGuard
from telex_teleop.arm.tool_motion import ToolMotion
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.flippers.flipper_teleop import FlipperTeleop
from telex_teleop.joints.coupled_teleop import CoupledTeleop
from telex_teleop.joints.joint_settings import GripperTeleopSettings
from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.limits import JointBounds

Limits = Mapping[str, JointBounds]


@dataclass(frozen=True)
class ArmCore:
    """The arm's core, and what belongs to it.

    Attributes
    ----------
    core
        Still without what leads the tool; see `tool_motion`.
    chain
        From base to tool; None where the robot has no such arm.
    problems
        What is left out, and why.
    """

    core: ArmTeleop
    chain: Optional[Chain]
    problems: List[str]


def arm_core(settings: ArmTeleopSettings, limits: Limits, description: str) -> ArmCore:
    """Return the core that moves the arm of the robot with this URDF."""
    axes = settings.axes(limits)
    chain, carrier, problems = carrier_of(settings, description, axes)
    core = ArmTeleop(
        axes,
        carrier,
        settings.command_timeout,
        settings.longest_step,
        settings.speed_scale(),
        ProximityGuard(settings.proximity),
        BasePose(settings.frames.base_pose_max_age),
    )
    return ArmCore(core, chain, problems)


def tool_motion(core: ArmTeleop, chain: Chain, settings: ToolSettings) -> ToolMotion:
    """Return what leads the tool, its kinematics compiled: seconds the first time."""
    motions = [core.axes[joint].settings.motion for joint in chain.joint_names]
    kinematics = IKKinematics(chain, motions)
    kinematics.warm_up()
    return ToolMotion(
        chain.joint_names,
        motions,
        [joint.kind == "prismatic" for joint in chain.joints],
        kinematics,
        settings,
    )


def flipper_core(settings: FlipperTeleopSettings, limits: Limits) -> FlipperTeleop:
    """Return the core that jogs the flippers, and leads them to presets."""
    axes = settings.axes(limits)
    return FlipperTeleop(
        axes=axes,
        presets=settings.preset_table(axes),
        goal_rules=settings.goal_rules(),
        command_timeout=settings.command_timeout,
        longest_step=settings.longest_step,
        speed=settings.speed_scale(),
    )


def gripper_core(settings: GripperTeleopSettings, limits: Limits) -> JointTeleop:
    """Return the core that moves the fingers; without limits, that of a robot without any."""
    if not limits:
        return JointTeleop(
            {}, settings.command_timeout, settings.longest_step, settings.speed_scale()
        )
    group = settings.coupling
    fingers = settings.axes(limits)
    return CoupledTeleop(
        joints=fingers,
        group=settings.axis(group.name, group.limits(fingers)),
        coupling=group.coupling(),
        command_timeout=settings.command_timeout,
        longest_step=settings.longest_step,
        speed=settings.speed_scale(),
    )
