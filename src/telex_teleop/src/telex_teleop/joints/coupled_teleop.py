"""Core of the gripper's teleoperation: finger joints that move together, or one by one.

A parallel jaw keeps its pads parallel when its joints keep fixed ratios (paper, end of section 4.2:
six revolute joints moved together). One pseudo joint stands for the group; its value s asks joint j
for ``ratio_j * s``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, FrozenSet, Mapping, Tuple

from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.reference import MotionLimits, ReferenceGenerator
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks


@dataclass(frozen=True)
class Coupling:
    """How a group of joints moves as one.

    Attributes
    ----------
    name
        The pseudo joint that a jog names to move the group.
    ratios
        Joint to its position per unit of the group's value; none is zero.
    measured_by
        Joints whose mean of position / ratio is the measured value of the group.
    align_velocity
        Rate (rad/s or m/s) at which joints that had been moved one by one return to their ratio.
    align_acceleration
        Its acceleration limit.
    """

    name: str
    ratios: Dict[str, float]
    measured_by: Tuple[str, ...]
    align_velocity: float
    align_acceleration: float

    def value(self, positions: Mapping[str, float]) -> float:
        """Return the measured value of the group."""
        parts = [positions[joint] / self.ratios[joint] for joint in self.measured_by]
        return sum(parts) / len(parts)


class CoupledTeleop(JointTeleop):
    """Jogs a group of joints as one, or each of them by itself; the newest command wins.

    Parameters
    ----------
    joints
        Joint to the bounds of its own motion.
    group
        Bounds of the group's value.
    command_timeout, longest_step, speed
        See `JointTeleop`.
    """

    def __init__(
        self,
        joints: Mapping[str, AxisSettings],
        group: AxisSettings,
        coupling: Coupling,
        command_timeout: float,
        longest_step: float,
        speed: SpeedScale,
    ) -> None:
        super().__init__({coupling.name: group, **joints}, command_timeout, longest_step, speed)
        self._coupling = coupling
        self._joints = tuple(joints)
        self._group = self.axes[coupling.name]
        self._offsets = {joint: _offset_generator(coupling) for joint in joints}
        self._group_moving = False

    @property
    def measured_joints(self) -> Tuple[str, ...]:
        """Joints whose positions every update needs."""
        return self._joints

    @property
    def output_joints(self) -> Tuple[str, ...]:
        """Joints whose controllers get references."""
        return self._joints

    def receive(self, jog: JogCommand, wall: float, caller: str = "") -> FrozenSet[str]:
        """Take a jog of the group or of single joints; see `JointTeleop.receive`."""
        wanted = {**jog.velocities, **jog.displacements}
        moving = {name for name, value in wanted.items() if value != 0.0}
        group = self._coupling.name
        if group in moving and len(moving) > 1:
            others = ", ".join(sorted(moving - {group}))
            raise InvalidCommand(
                f"joint_names: {group} moves all its joints; send it without {others}"
            )
        obeying = super().receive(jog, wall, caller)
        if obeying:
            for name in self._joints if group in obeying else (group,):
                self.axes[name].yield_to_another()
        return obeying

    def _references(
        self, dt: float, now: Clocks, positions: Mapping[str, float]
    ) -> Dict[str, float]:
        scale = self.speed.value
        singles_moving = any(self.axes[joint].generator.moving for joint in self._joints)
        value = self._group.update(
            dt, now, self._coupling.value(positions), scale, blocked=singles_moving
        )
        references: Dict[str, float] = {}
        for joint in self._joints:
            reference = self.axes[joint].update(
                dt, now, positions[joint], scale, blocked=value is not None
            )
            if reference is not None:
                references[joint] = reference
        if value is not None:
            return self._couple(dt, value, positions, self._group.obeying(now))
        self._group_moving = False
        if references:
            # the joints leave their ratios, so the group's own reference is no longer valid
            self._group.generator.drop()
        return references

    def _couple(
        self, dt: float, value: float, positions: Mapping[str, float], commanded: bool
    ) -> Dict[str, float]:
        """Return the references of all joints: ratio times value, and an offset that dies away.

        The offset is what each joint is off its ratio when the group begins to move; without it a
        joint that had been moved alone would get a step.
        """
        references: Dict[str, float] = {}
        for joint in self._joints:
            generator, offset = self.axes[joint].generator, self._offsets[joint]
            coupled = self._coupling.ratios[joint] * value
            if not self._group_moving:
                offset.rest_at(generator.start_from(positions[joint]) - coupled)
            wanted = coupled + self._align(offset, dt, commanded)
            limits = self.axes[joint].settings.motion
            references[joint] = max(limits.lower, min(limits.upper, wanted))
            # a later motion of this joint alone goes on from here
            generator.rest_at(references[joint])
        self._group_moving = True
        return references

    def _align(self, offset: ReferenceGenerator, dt: float, commanded: bool) -> float:
        present = offset.reference or 0.0
        if not commanded:
            offset.stop()
        elif present != 0.0 and not offset.displacing:
            offset.displace(-present)
        moved = offset.update(dt, present, self.speed.value)
        return present if moved is None else moved


def _offset_generator(coupling: Coupling) -> ReferenceGenerator:
    """Return a generator without position limits and lead, as nothing measures an offset."""
    unlimited = math.inf
    return ReferenceGenerator(
        MotionLimits(
            lower=-unlimited,
            upper=unlimited,
            max_velocity=coupling.align_velocity,
            max_acceleration=coupling.align_acceleration,
            max_lead=unlimited,
            hold_tolerance=unlimited,
        )
    )
