"""Parameters of arm_teleop, and what follows from them with the robot's URDF."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Mapping, Optional, Tuple

from telex_control.common.params import (
    Declared,
    choice,
    number,
    parameter,
    require,
    require_choice,
    word,
)
from telex_control.kinematics import Chain, KinematicsError
from telex_control.urdf.joints import UrdfError
from telex_teleop.arm.arm_teleop import Carrier
from telex_teleop.arm.proximity import ProximitySettings
from telex_teleop.arm.tool_command import FrameNames
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.joints.joint_settings import JointTeleopSettings
from telex_teleop.motion.axis import AxisSettings

# Distance (rad or m) by which a pose may be outside a reference's limits: a pose on a joint's own
# limit is inside it by the margin that references keep.
POSE_MARGIN = 0.01


@dataclass(frozen=True)
class FrameSettings(Declared):
    """Names of frames."""

    tool: str = word(
        "tool_link", "Link that is the tool centre point; the arm's kinematics end here."
    )
    base: str = word("base_link", "Link in which the arm's kinematics begin.")
    world: str = word("world", "Frame that does not move with the robot.")
    default: str = parameter(
        "tool_link", "One of the three, which an empty ``frame_id`` stands for."
    )
    base_pose: str = choice(
        "sim",
        ("sim", "odom"),
        "What tells where the base is in the world: ``sim/base_pose``, the simulator's truth, or "
        "``track_controller/odom``, as a robot without anything better has it.",
    )
    base_pose_max_age: float = number(
        0.25, "A report of it that is older (s of sim time) counts as none.", above=0.0
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        names = (self.tool, self.base, self.world)
        require(len(set(names)) == 3, f"tool, base and world are {', '.join(names)}; must differ")
        require_choice(self, "default", names)

    def names(self) -> FrameNames:
        """Return them as commands are checked against."""
        return FrameNames(self.tool, self.base, self.world, self.default)


@dataclass(frozen=True)
class ArmTeleopSettings(JointTeleopSettings):
    """Parameters of the arm's node, beside those of every joint node.

    Attributes
    ----------
    proximity
        How the arm keeps its distance from what is near.
    poses
        Name of a pose to joint to position (rad or m); joints that do not carry the tool are not
        looked at.
    """

    frames: FrameSettings = field(default_factory=FrameSettings)
    cartesian: ToolSettings = field(default_factory=ToolSettings)
    proximity: ProximitySettings = field(default_factory=ProximitySettings)
    poses: Dict[str, Dict[str, float]] = field(default_factory=dict)


def carrier_of(
    settings: ArmTeleopSettings, description: str, axes: Mapping[str, AxisSettings]
) -> Tuple[Optional[Chain], Carrier, List[str]]:
    """Return the arm that carries the tool.

    Parameters
    ----------
    axes
        Joints that the node moves.

    Returns
    -------
    chain, carrier, problems
        No chain where the robot has none that this node could move; what else is left out, and
        why.
    """
    frames = settings.frames
    try:
        chain = Chain.from_urdf(description, frames.base, frames.tool)
    except (KinematicsError, UrdfError) as error:
        return None, Carrier(lacking=f"not available for this robot: {error}"), []
    if not (chain.lower < chain.upper).any():
        lacking = (
            f"not available for this robot: no joint from {frames.base} to {frames.tool} can move"
        )
        return None, Carrier(lacking=lacking), []
    foreign = [joint for joint in chain.joint_names if joint not in axes]
    if foreign:
        lacking = (
            f"not available for this robot: {', '.join(foreign)} carry {frames.tool}, but are not "
            "among this node's joints"
        )
        return None, Carrier(lacking=lacking), []
    poses: Dict[str, List[float]] = {}
    problems: List[str] = []
    for name, positions in settings.poses.items():
        problem = _pose_problem(positions, chain.joint_names, axes)
        if problem:
            problems.append(f"pose {name} is left out: {problem}")
            continue
        poses[name] = [
            max(axes[joint].motion.lower, min(axes[joint].motion.upper, positions[joint]))
            for joint in chain.joint_names
        ]
    return chain, Carrier(tuple(chain.joint_names), poses), problems


def _pose_problem(
    positions: Mapping[str, float], joints: Tuple[str, ...], axes: Mapping[str, AxisSettings]
) -> str:
    missing = [joint for joint in joints if joint not in positions]
    if missing:
        return f"it says nothing of {', '.join(missing)}"
    for joint in joints:
        motion = axes[joint].motion
        if not motion.lower - POSE_MARGIN <= positions[joint] <= motion.upper + POSE_MARGIN:
            return (
                f"{joint} is {positions[joint]:g}; this robot's may be from {motion.lower:.4g} to "
                f"{motion.upper:.4g}"
            )
    return ""
