"""``telex_controllers/ParallelGripperController``: two fingers of three joints, as one gripper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple

from ..common.params import Declared, number, read_config, require, required
from ..common.stateful import Stateful
from ..hardware.hardware_interface import EffortJointInterface, JointHandle, RobotHW
from ..hardware.joint_limits import clamp
from ..laws.gravity import JointGravity
from ..manager.controller import ControllerInitError
from ..ros.node_handle import NodeHandle
from .gripper_action_controller import GripperCommandController, GripperState
from .joint_description import joint_description, joint_gravity

RATIOS = (1.0, 1.0, -2.0)
"""Angles of base, middle and tip joint by the finger's angle; they keep the pads parallel."""

_THIN = 0.004
"""Opening (m) from which on something counts as between pads that close all the way."""


@dataclass(frozen=True)
class FingerGeometry(Declared):
    """Links of a finger; the finger's angle is that of its base joint, positive opens."""

    base: float = number(
        required, "Length of the link at the hand, from joint to joint (m).", above=0.0
    )
    middle: float = number(required, "The same of the middle link (m).", above=0.0)
    lean: float = number(
        required,
        "How far both lean inwards at angle 0, where the pads meet (rad).",
        -math.pi / 2,
        math.pi / 2,
    )
    pad: float = number(
        required, "From the tip's joint to the middle of its pad, along the pad (m).", above=0.0
    )
    max_angle: float = number(required, "Of the open gripper (rad).", above=0.0)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        # Beyond, an opening has two angles.
        require(
            2.0 * self.max_angle - self.lean < math.pi / 2,
            f"max_angle is {self.max_angle}; 2 max_angle - lean must be below pi / 2",
        )

    def opening(self, angle: float) -> float:
        """Return the distance of the pads (m)."""
        sine, lean = math.sin, self.lean
        return 2.0 * (
            self.base * (sine(lean) - sine(lean - angle))
            + self.middle * (sine(lean) - sine(lean - 2.0 * angle))
        )

    def opening_rate(self, angle: float) -> float:
        """Return the derivative of the opening by the angle (m/rad), above 0."""
        base, middle, _ = self._reaches(angle)
        return 2.0 * (base + 2.0 * middle)

    def angle(self, opening: float) -> float:
        """Return the angle of an opening (m) between those of 0 and `max_angle`, by bisection."""
        low, high = 0.0, self.max_angle
        for _ in range(40):
            middle = 0.5 * (low + high)
            if self.opening(middle) < opening:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def levers(self, angle: float) -> Tuple[float, float, float]:
        """Return the levers of a force across the pad about base, middle and tip joint (m)."""
        base, middle, pad = self._reaches(angle)
        return base + middle + pad, middle + pad, pad

    def _reaches(self, angle: float) -> Tuple[float, float, float]:
        return (
            self.base * math.cos(self.lean - angle),
            self.middle * math.cos(self.lean - 2.0 * angle),
            self.pad,
        )


@dataclass(frozen=True)
class JointGains(Declared):
    """Stiffness p and damping d of a joint (Nm/rad, Nms/rad)."""

    p: float = number(required, "", above=0.0)
    d: float = number(required, "", 0.0)


@dataclass(frozen=True)
class GripperConfig(Declared):
    """How fingers are driven."""

    base: JointGains
    middle: JointGains
    tip: JointGains
    velocity: float = number(0.08, "At which the gripper opens and closes (m/s).", above=0.0)
    stiffness: float = number(
        8000.0,
        "Force of the pads by the angle that the fingers are short of their reference (N/rad).",
        above=0.0,
    )
    align_velocity: float = number(
        0.05, "At which joints that stand out of line return to it (rad/s).", above=0.0
    )


class _Joint(Stateful):
    """One finger joint, and how far its reference still is from where the coupling wants it."""

    __slots__ = ("gains", "gravity", "handle", "offset", "ratio")
    SAVED = ("offset",)
    SAVED_PARTS = ("gravity",)

    def __init__(
        self,
        handle: JointHandle,
        gains: JointGains,
        ratio: float,
        gravity: Optional[JointGravity],
    ) -> None:
        self.handle = handle
        self.gravity = gravity
        self.gains = gains
        self.ratio = ratio
        self.offset = 0.0


class ParallelGripperController(GripperCommandController):
    """Opens and closes two fingers with parallel pads, and grips with a given force.

    Action: ``gripper_cmd``; position is the opening between the pads (m), max_effort the force of
    each pad (N). Parameters: those of `GripperCommandController`, with ``allow_stalling`` true
    (a goal that ends on an object is a grasp), ``goal_tolerance`` 0.002 m; ``max_effort`` (N) is
    required; ``left_joints`` and ``right_joints`` (base, middle, tip), ``geometry`` (see
    `FingerGeometry`) and ``drive`` (see `GripperConfig`); ``gravity_compensation`` (false) keeps
    the fingers' own weight from the pads' force.

    All six joints are coupled through one angle, the mean of both base joints, which the
    reference leads; the distance between them makes the force of the pads. It is turned into
    joint efforts by the levers of the pads, so that the fingers stay stiff against everything
    that does not open or close them, however hard they grip.
    """

    parameters = GripperCommandController.parameters | {
        "drive",
        "geometry",
        "gravity_compensation",
        "left_joints",
        "right_joints",
    }
    SAVED = ("_force", "_reference", "_target")
    SAVED_PARTS = ("_joints",)
    goal_tolerance = 0.002
    allow_stalling = True

    def _init_joints(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        if not math.isfinite(self._default_effort):
            raise ControllerInitError(
                f"parameter {node.resolve('max_effort')} is missing or 0; "
                "the largest force of a pad is needed (N)"
            )
        self._geometry = read_config(
            FingerGeometry, node.param("geometry", dict), node.resolve("geometry")
        )
        self._config = read_config(GripperConfig, node.param("drive", dict), node.resolve("drive"))
        interface = hw.get(EffortJointInterface)
        config = self._config
        compensated = node.param("gravity_compensation", bool, False)
        self._joints: List[_Joint] = []
        for side in ("left_joints", "right_joints"):
            names = node.names_param(side)
            if len(names) != len(RATIOS):
                raise ControllerInitError(
                    f"parameter {node.resolve(side)} names {len(names)} joints; base, middle and "
                    "tip are needed"
                )
            for name, gains, ratio in zip(names, (config.base, config.middle, config.tip), RATIOS):
                joint_description(root, name)
                gravity = joint_gravity(hw, root, name) if compensated else None
                self._joints.append(_Joint(interface.get_handle(name), gains, ratio, gravity))
        self._bases = (self._joints[0].handle.state, self._joints[3].handle.state)
        self._largest = self._geometry.opening(self._geometry.max_angle)
        self._reference = 0.0
        self._target = (math.nan, 0.0)
        self._force = 0.0

    def _limits(self) -> Tuple[float, float]:
        return 0.0, self._largest

    def _angle(self) -> float:
        left, right = self._bases
        return 0.5 * (left.position + right.position)

    def _measure(self) -> GripperState:
        left, right = self._bases
        angle = self._angle()
        rate = 0.5 * (left.velocity + right.velocity)
        return GripperState(
            self._geometry.opening(angle),
            rate * self._geometry.opening_rate(angle),
            abs(self._force),
        )

    def _start(self) -> None:
        angle = self._reference = self._angle()
        self._force = 0.0
        for joint in self._joints:
            joint.offset = joint.handle.state.position - joint.ratio * angle

    def _command(self, time: float, period: float, position: float, max_effort: float) -> None:
        geometry, config = self._geometry, self._config
        if position != self._target[0]:
            self._target = (position, geometry.angle(position))
        measured = self._angle()
        step = config.velocity / geometry.opening_rate(measured) * period
        target = self._target[1] - self._beyond_closed(position, measured, max_effort)
        reference = self._reference + clamp(target - self._reference, -step, step)
        self._force = force = clamp(
            (reference - measured) * config.stiffness, -max_effort, max_effort
        )
        # The reference does not run away from fingers that are held: they would jump when freed.
        self._reference = measured + force / config.stiffness
        levers = geometry.levers(measured)
        align = config.align_velocity * period
        for joint, lever in zip(self._joints, levers + levers):
            state, gains = joint.handle.state, joint.gains
            joint.offset -= clamp(joint.offset, -align, align)
            place = joint.ratio * measured + joint.offset
            # The damping acts on the velocity itself: the measured angle is in the place.
            effort = gains.p * (place - state.position) - gains.d * state.velocity + force * lever
            if joint.gravity is not None:
                effort += joint.gravity.effort(time)
            joint.handle.command = effort

    def _beyond_closed(self, position: float, measured: float, max_effort: float) -> float:
        """How far beyond closed the reference goes (rad), for the whole force on a thin thing.

        The stiffness alone would press the less on what is between the pads the thinner it is.
        """
        if position > 0.0:
            return 0.0
        between = clamp(self._geometry.opening(measured) / _THIN, 0.0, 1.0)
        return between * max_effort / self._config.stiffness

    def _release(self) -> None:
        self._force = 0.0
        for joint in self._joints:
            joint.handle.command = 0.0
