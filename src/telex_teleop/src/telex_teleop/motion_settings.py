"""Parameters of the joint teleoperation nodes, and the limits that follow with the URDF's."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, Mapping, Optional, Tuple

from telex_teleop.axis import AxisSettings
from telex_teleop.coupled_teleop import Coupling
from telex_teleop.limits import PRISMATIC, REVOLUTE, JointLimits
from telex_teleop.reference import MotionLimits
from telex_teleop.settings import Section, SettingsError

__all__ = ["CoupledSettings", "JointTeleopSettings", "MotionRules"]


@dataclass(frozen=True)
class MotionRules:
    """How the reference of a joint may move, beside the joint's own limits; rad or m.

    Attributes
    ----------
    max_velocity
        Bound below the URDF's (per second), None for the URDF's own.
    acceleration_time
        Time (s) from rest to the largest velocity.
    max_lead
        How far the reference may be ahead of the measured position.
    hold_tolerance
        A resting joint that leaves its reference by more than this was moved by somebody else.
    limit_margin
        Distance that the reference keeps from the position limits.
    max_displacement
        Largest one-shot increment.
    """

    max_velocity: Optional[float]
    acceleration_time: float
    max_lead: float
    hold_tolerance: float
    limit_margin: float
    max_displacement: float

    @classmethod
    def defaults(cls, kind: str) -> MotionRules:
        """Return the rules for ``"revolute"`` (rad) or ``"prismatic"`` (m) joints."""
        if kind == PRISMATIC:
            return cls(None, 0.3, 0.03, 0.005, 0.0005, 0.1)
        return cls(None, 0.3, 0.35, 0.02, 0.002, 0.5)

    def overridden(self, settings: Section, *, velocity: bool) -> MotionRules:
        """Return these rules with what a section gives instead.

        Parameters
        ----------
        settings
            Any of the attributes.
        velocity
            Whether `max_velocity` may be among them.
        """
        rules = replace(
            self,
            acceleration_time=settings.number(
                "acceleration_time", self.acceleration_time, positive=True
            ),
            max_lead=settings.number("max_lead", self.max_lead, positive=True),
            hold_tolerance=settings.number("hold_tolerance", self.hold_tolerance, positive=True),
            limit_margin=settings.number("limit_margin", self.limit_margin, minimum=0.0),
            max_displacement=settings.number(
                "max_displacement", self.max_displacement, positive=True
            ),
        )
        if velocity and settings.has("max_velocity"):
            rules = replace(rules, max_velocity=settings.number("max_velocity", positive=True))
        settings.finish()
        return rules


@dataclass(frozen=True)
class JointTeleopSettings:
    """Parameters of a joint teleoperation node.

    Attributes
    ----------
    source
        Where they came from, for messages.
    joints
        Joints that the node moves, in the order of its status.
    command_timeout
        Age (s) at which a command that is not repeated ends.
    longest_step
        Joint states further apart than this (s of sim time) start everything anew.
    status_rate
        Status messages per second of wall time.
    kinds
        Rules for revolute and prismatic joints.
    overrides
        Sections of single joints.
    """

    source: str
    joints: Tuple[str, ...]
    command_timeout: float
    longest_step: float
    status_rate: float
    kinds: Dict[str, MotionRules]
    overrides: Dict[str, Section]

    @classmethod
    def from_settings(cls, settings: Section, *groups: str) -> JointTeleopSettings:
        """Read the parameters that all joint nodes have.

        Parameters
        ----------
        settings
            The node's parameters; the caller finishes it after reading its own.
        groups
            Pseudo joints that `joint_settings` may also name.

        Raises
        ------
        SettingsError
            When one is missing or out of range.
        """
        joints = settings.names("joints")
        by_joint = settings.section("joint_settings")
        overrides = {
            name: by_joint.section(name) for name in (*joints, *groups) if by_joint.has(name)
        }
        by_joint.finish()
        return cls(
            source=settings.source,
            joints=joints,
            command_timeout=settings.number("command_timeout", 0.28, positive=True, maximum=0.3),
            longest_step=settings.number("longest_step", 0.5, positive=True),
            status_rate=settings.number("status_rate", 10.0, positive=True, maximum=100.0),
            kinds={
                kind: MotionRules.defaults(kind).overridden(settings.section(kind), velocity=False)
                for kind in (REVOLUTE, PRISMATIC)
            },
            overrides=overrides,
        )

    def axes(self, limits: Mapping[str, JointLimits]) -> Dict[str, AxisSettings]:
        """Return the bounds of motion of every joint.

        Raises
        ------
        SettingsError
            When the rules do not fit a joint's limits.
        """
        return {name: self.axis(name, limits[name]) for name in self.joints}

    def axis(self, name: str, limits: JointLimits) -> AxisSettings:
        """Return the bounds of motion of one joint or group with the given limits."""
        rules = self._rules(name, limits.kind)
        source = f"{self.source}/joint_settings/{name}"
        velocity = limits.max_velocity
        if rules.max_velocity is not None:
            if rules.max_velocity > velocity:
                raise SettingsError(
                    f"{source}/max_velocity: is {rules.max_velocity:g}; must be at most "
                    f"{velocity:g}, what the robot allows"
                )
            velocity = rules.max_velocity
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
            raise SettingsError(f"{self.source}: joint {name}: {error}") from error
        return AxisSettings(motion, rules.max_displacement)

    def _rules(self, name: str, kind: str) -> MotionRules:
        rules = self.kinds[kind]
        section = self.overrides.get(name)
        return rules if section is None else rules.overridden(section, velocity=True)


@dataclass(frozen=True)
class CoupledSettings:
    """Section ``coupling`` of a gripper node: how a group of joints moves as one."""

    name: str
    ratios: Dict[str, float]
    measured_by: Tuple[str, ...]
    align_velocity: float
    align_time: float

    @classmethod
    def from_settings(cls, settings: Section, joints: Tuple[str, ...]) -> CoupledSettings:
        """Read the section; every one of `joints` must have a ratio."""
        ratios_section = settings.section("ratios", required=True)
        ratios = {joint: ratios_section.number(joint) for joint in joints}
        ratios_section.finish()
        for joint, ratio in ratios.items():
            if ratio == 0.0:
                raise ratios_section.error(joint, ratio, "a number other than 0")
        measured_by = settings.names("measured_by")
        if not set(measured_by) <= set(joints):
            raise settings.error("measured_by", list(measured_by), "names out of joints")
        coupled = cls(
            name=settings.text("name", "gripper"),
            ratios=ratios,
            measured_by=measured_by,
            align_velocity=settings.number("align_velocity", 0.1, positive=True),
            align_time=settings.number("align_time", 0.3, positive=True),
        )
        settings.finish()
        return coupled

    @property
    def coupling(self) -> Coupling:
        """The coupling that these settings describe."""
        return Coupling(
            name=self.name,
            ratios=self.ratios,
            measured_by=self.measured_by,
            align_velocity=self.align_velocity,
            align_acceleration=self.align_velocity / self.align_time,
        )

    def limits(self, joints: Mapping[str, AxisSettings]) -> JointLimits:
        """Return the limits of the group's value that all its joints allow.

        Raises
        ------
        SettingsError
            When no value suits all joints, or aligning leaves no speed for the common motion.
        """
        lower, upper, rate = -math.inf, math.inf, math.inf
        for joint, ratio in self.ratios.items():
            motion = joints[joint].motion
            ends = sorted((motion.lower / ratio, motion.upper / ratio))
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
            rate = min(rate, (motion.max_velocity - self.align_velocity) / abs(ratio))
        if not lower < upper:
            raise SettingsError(
                f"coupling/ratios: no value of {self.name} suits the position limits of all its "
                "joints; check the signs"
            )
        if rate <= 0.0:
            raise SettingsError(
                f"coupling/align_velocity: is {self.align_velocity!r}; must leave speed for the "
                "common motion, so be below the slowest joint's"
            )
        return JointLimits(REVOLUTE, lower, upper, rate)
