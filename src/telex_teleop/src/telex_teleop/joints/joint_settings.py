"""Parameters of the joint teleoperation nodes, and the limits that follow with the URDF's."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Collection, Dict, Mapping, Optional, Tuple

from telex_control.common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    require,
    require_names,
    required,
    word,
)
from telex_control.urdf.joints import PRISMATIC, REVOLUTE, joints, parse_urdf
from telex_teleop.joints.coupled_teleop import Coupling
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.limits import JointBounds, limits_from_urdf
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.teleop_settings import TeleopSettings


@dataclass(frozen=True)
class MotionRules(Declared):
    """How the reference of a joint may move, beside the joint's own limits; rad or m.

    The defaults are those of revolute joints.
    """

    acceleration_time: float = number(0.3, "Time (s) from rest to the largest velocity.", above=0.0)
    max_lead: float = number(
        0.35, "How far the reference may be ahead of the measured position.", above=0.0
    )
    hold_tolerance: float = number(
        0.02,
        "A resting joint that leaves its reference by more than this was moved by somebody else.",
        above=0.0,
    )
    limit_margin: float = number(
        0.002, "Distance that the reference keeps from the position limits.", 0.0
    )
    max_displacement: float = number(0.5, "Largest one-shot increment.", above=0.0)


@dataclass(frozen=True)
class PrismaticRules(MotionRules):
    """The same with the defaults of prismatic joints (m)."""

    max_lead: float = 0.03
    hold_tolerance: float = 0.005
    limit_margin: float = 0.0005
    max_displacement: float = 0.1


@dataclass(frozen=True)
class JointRules(Declared):
    """Rules of one joint that differ from those of its kind; None keeps the kind's."""

    max_velocity: Optional[float] = number(
        None, "Bound below the URDF's (per second); None for the URDF's own.", above=0.0
    )
    acceleration_time: Optional[float] = number(None, "See `MotionRules`.", above=0.0)
    max_lead: Optional[float] = number(None, "See `MotionRules`.", above=0.0)
    hold_tolerance: Optional[float] = number(None, "See `MotionRules`.", above=0.0)
    limit_margin: Optional[float] = number(None, "See `MotionRules`.", 0.0)
    max_displacement: Optional[float] = number(None, "See `MotionRules`.", above=0.0)

    def applied_to(self, rules: MotionRules) -> MotionRules:
        """Return the rules of the kind with what this joint does otherwise."""
        values = {}
        for each in fields(MotionRules):
            own = getattr(self, each.name)
            values[each.name] = getattr(rules, each.name) if own is None else own
        return MotionRules(**values)


@dataclass(frozen=True)
class JointTeleopSettings(TeleopSettings):
    """Parameters of a joint teleoperation node, beside those of every node.

    Attributes
    ----------
    joints
        Joints that the node moves, in the order of its status.
    optional_joints
        Those of them that a variant of the robot may lack.
    revolute, prismatic
        Rules for the joints of either kind.
    joint_settings
        Rules of single joints.
    """

    joints: Tuple[str, ...] = field(default_factory=required)
    optional_joints: Tuple[str, ...] = ()
    revolute: MotionRules = field(default_factory=MotionRules)
    prismatic: PrismaticRules = field(default_factory=PrismaticRules)
    joint_settings: Dict[str, JointRules] = field(default_factory=dict)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        super().check()
        require_names(self, "joints")
        for name in self.optional_joints:
            require(
                name in self.joints,
                f"optional_joints names '{name}'; known are {', '.join(self.joints)}",
            )
        axes = self.axis_names()
        for name in self.joint_settings:
            require(name in axes, f"joint_settings/{name} is unknown; known are {', '.join(axes)}")

    def axis_names(self) -> Tuple[str, ...]:
        """Return what can be jogged: the joints, and in a derived class also groups of them."""
        return self.joints

    def lacking(self, movable: Collection[str]) -> Tuple[str, ...]:
        """Return the optional joints that a robot with these movable joints lacks."""
        return tuple(name for name in self.optional_joints if name not in movable)

    def axes(self, limits: Mapping[str, JointBounds]) -> Dict[str, AxisSettings]:
        """Return the bounds of motion of every joint whose limits are given.

        Raises
        ------
        telex_control.common.params.ConfigError
            When the rules do not fit a joint's limits.
        """
        return {name: self.axis(name, limits[name]) for name in self.joints if name in limits}

    def axis(self, name: str, limits: JointBounds) -> AxisSettings:
        """Return the bounds of motion of one joint or group with the given limits."""
        own = self.joint_settings.get(name, JointRules())
        rules = own.applied_to(self.prismatic if limits.kind == PRISMATIC else self.revolute)
        velocity = limits.max_velocity
        if own.max_velocity is not None:
            require(
                own.max_velocity <= velocity,
                f"joint_settings/{name}/max_velocity is {own.max_velocity:g}; it must be at most "
                f"{velocity:g}, what the robot allows",
            )
            velocity = own.max_velocity
        try:
            motion = MotionLimits(
                lower=limits.lower + rules.limit_margin,
                upper=limits.upper - rules.limit_margin,
                max_velocity=velocity,
                max_acceleration=velocity / rules.acceleration_time,
                max_lead=rules.max_lead,
                hold_tolerance=rules.hold_tolerance,
            )
        except ValueError as error:
            raise ConfigError(f"joint {name}: {error}") from error
        return AxisSettings(motion, rules.max_displacement)


def limits_of_present(
    settings: JointTeleopSettings, description: str
) -> Tuple[Dict[str, JointBounds], Tuple[str, ...]]:
    """Return the limits of those of a node's joints that a robot has, and the others' names.

    Raises
    ------
    telex_control.urdf.joints.UrdfError
        A joint that is not optional is missing, or one has no usable limit.
    """
    lacking = settings.lacking(joints(parse_urdf(description)))
    present = [name for name in settings.joints if name not in lacking]
    return limits_from_urdf(description, present), lacking


@dataclass(frozen=True)
class CouplingSettings(Declared):
    """How a group of joints moves as one."""

    ratios: Dict[str, float] = parameter(required, "See `coupled_teleop.Coupling`.")
    measured_by: Tuple[str, ...] = parameter(required, "See `coupled_teleop.Coupling`.")
    name: str = word("gripper", "See `coupled_teleop.Coupling`.")
    align_velocity: float = number(0.1, "See `coupled_teleop.Coupling`.", above=0.0)
    align_time: float = number(0.3, "Time (s) from rest to `align_velocity`.", above=0.0)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        for joint, ratio in self.ratios.items():
            require(ratio != 0.0, f"ratios/{joint} is {ratio}; a number other than 0 is needed")
        require_names(self, "measured_by")

    def coupling(self) -> Coupling:
        """Return the coupling that these settings describe."""
        return Coupling(
            name=self.name,
            ratios=self.ratios,
            measured_by=self.measured_by,
            align_velocity=self.align_velocity,
            align_acceleration=self.align_velocity / self.align_time,
        )

    def limits(self, joints: Mapping[str, AxisSettings]) -> JointBounds:
        """Return the limits of the group's value that all its joints allow.

        Raises
        ------
        telex_control.common.params.ConfigError
            When no value suits all joints, or aligning leaves no speed for the common motion.
        """
        lower, upper, rate = -math.inf, math.inf, math.inf
        for joint, ratio in self.ratios.items():
            motion = joints[joint].motion
            ends = sorted((motion.lower / ratio, motion.upper / ratio))
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
            rate = min(rate, (motion.max_velocity - self.align_velocity) / abs(ratio))
        require(
            lower < upper,
            f"coupling/ratios: no value of {self.name} suits the position limits of all its "
            "joints; check the signs",
        )
        require(
            rate > 0.0,
            f"coupling/align_velocity is {self.align_velocity!r}; it must leave speed for the "
            "common motion, so be below the slowest joint's",
        )
        return JointBounds(REVOLUTE, lower, upper, rate)


@dataclass(frozen=True)
class GripperTeleopSettings(JointTeleopSettings):
    """Parameters of the gripper's node, beside those of every joint node."""

    coupling: CouplingSettings = field(default_factory=required)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        super().check()
        ratios = self.coupling.ratios
        for joint in self.joints:
            require(joint in ratios, f"coupling/ratios/{joint} is missing")
        for joint in ratios:
            require(
                joint in self.joints,
                f"coupling/ratios/{joint} is unknown; known are {', '.join(self.joints)}",
            )
        measured_by = self.coupling.measured_by
        require(
            set(measured_by) <= set(self.joints),
            f"coupling/measured_by is {list(measured_by)}; names out of joints are needed",
        )

    def lacking(self, movable: Collection[str]) -> Tuple[str, ...]:
        """Return the joints that a robot without gripper lacks: all or none.

        Raises
        ------
        telex_control.common.params.ConfigError
            When it lacks some of them, for the others cannot keep the pads parallel.
        """
        lacking = super().lacking(movable)
        require(
            len(lacking) in (0, len(self.joints)),
            f"the robot has no {', '.join(lacking)}; it must have all joints of "
            f"{self.coupling.name}, or none",
        )
        return lacking

    def axis_names(self) -> Tuple[str, ...]:
        """Return what can be jogged: the joints and the group of them."""
        return (*self.joints, self.coupling.name)
