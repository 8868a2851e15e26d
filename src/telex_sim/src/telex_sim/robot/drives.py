"""The drives of a simulated robot: what each joint is commanded by, and what that makes of it."""

from __future__ import annotations

import dataclasses
import enum
import math
from typing import Dict, Optional, Tuple, Type

from telex_control.common.stateful import Stateful
from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    JointCommandInterface,
    JointHandle,
    JointStateHandle,
    PositionJointInterface,
    VelocityJointInterface,
)
from telex_control.hardware.joint_limits import JointLimits, SoftJointLimits, clamp
from telex_control.hardware.joint_limits_interface import JointLimitsHandle, limits_handle
from telex_control.laws.pid import Pid
from telex_control.urdf.joints import CONTINUOUS, UrdfJoint


class DriveMode(enum.Enum):
    """How the commands of a joint are carried out.

    EFFORT: as a torque or force. VELOCITY, POSITION: by a motor as strong as the joint's effort
    limit. VELOCITY_PID, POSITION_PID: by a PID loop whose effort is bounded to that limit.
    """

    EFFORT = enum.auto()
    VELOCITY = enum.auto()
    POSITION = enum.auto()
    VELOCITY_PID = enum.auto()
    POSITION_PID = enum.auto()


_MODES: Dict[Type[JointCommandInterface], Tuple[DriveMode, DriveMode]] = {
    EffortJointInterface: (DriveMode.EFFORT, DriveMode.EFFORT),
    VelocityJointInterface: (DriveMode.VELOCITY, DriveMode.VELOCITY_PID),
    PositionJointInterface: (DriveMode.POSITION, DriveMode.POSITION_PID),
}


@dataclasses.dataclass(frozen=True)
class Impairment:
    """What does not work of a drive.

    Attributes
    ----------
    share : float
        Of its motor's effort that is left.
    slip : float
        Effort at which the clutch between drive and joint slips (N m, N).
    jammed : bool
        The joint cannot move; the drive may try.
    limp : bool
        Neither motor nor brake holds the joint.
    """

    share: float = 1.0
    slip: float = math.inf
    jammed: bool = False
    limp: bool = False


WHOLE = Impairment()


class JointDrive(Stateful):
    """A driven joint: its description, its handles and its place in PyBullet.

    Parameters
    ----------
    interface : class
        Through which it is commanded.
    velocity_tolerance : float
        Factor on the velocity limit at which an effort joint stops accelerating, and which a
        position joint's motor may reach to catch up.
    overtravel : float
        How far beyond the limits the end stops lie, and with them the soft limits (rad, m).
        Position commands stay within the limits.

    Attributes
    ----------
    index : int
        Of the joint in PyBullet's body; set with the body.
    braked : bool
        Whether its brake holds it, whatever is commanded.
    held : float
        Where its brake holds it (rad, m); of no meaning without.
    force : float
        Effort that was last applied to a joint with `takes_effort` (Nm, N).
    max_effort, max_velocity : float
        Of its motor (Nm, N; rad/s, m/s).
    rated_effort : float
        Of its motor while it works (Nm, N).
    impairment : Impairment
        What does not work of it; set by `impair`.
    """

    __slots__ = (
        "_previous",
        "braked",
        "description",
        "force",
        "handle",
        "held",
        "impairment",
        "index",
        "interface",
        "limits",
        "max_effort",
        "max_velocity",
        "mode",
        "pid",
        "rated_effort",
        "state",
        "takes_effort",
    )
    SAVED = ("_previous", "braked", "force", "held")
    SAVED_PARTS = ("handle", "limits", "pid", "state")

    def __init__(
        self,
        description: UrdfJoint,
        interface: Type[JointCommandInterface],
        limits: JointLimits,
        soft_limits: Optional[SoftJointLimits],
        velocity_tolerance: float,
        pid: Optional[Pid] = None,
        overtravel: float = 0.0,
    ) -> None:
        if overtravel and interface is not PositionJointInterface:
            limits, soft_limits = _moved_out(limits, soft_limits, overtravel)
        self.description = description
        self.interface = interface
        self.mode = _MODES[interface][pid is not None]
        self.pid = pid
        self.takes_effort = self.mode not in (DriveMode.VELOCITY, DriveMode.POSITION)
        self.braked = True
        self.held = 0.0
        self.force = 0.0
        self.index = -1
        self.max_effort = self.rated_effort = limits.max_effort
        self.impairment = WHOLE
        self.max_velocity = limits.max_velocity * velocity_tolerance
        self.state = JointStateHandle(description.name)
        self.handle = JointHandle(self.state)
        self.limits: Tuple[JointLimitsHandle, ...]
        if interface is EffortJointInterface:
            self.limits = _effort_limits(self.handle, limits, soft_limits, velocity_tolerance)
        else:
            self.limits = (limits_handle(interface, self.handle, limits, soft_limits),)
        self._previous = 0.0

    def impair(self, impairment: Impairment) -> None:
        """Let it work as far as an impairment allows."""
        self.impairment = impairment
        share = 0.0 if impairment.limp else impairment.share
        # An effort without limit would make a nan of nothing.
        effort = self.rated_effort if share == 1.0 else share * min(self.rated_effort, _STRONG)
        self.max_effort = min(effort, impairment.slip)

    @property
    def stands(self) -> bool:
        """Whether its joint is held where it is, by the brake or because it is jammed."""
        return self.braked or self.impairment.jammed

    @property
    def enforced(self) -> Tuple[JointLimitsHandle, ...]:
        """Its limits, and the bound of a motor that lacks effort."""
        if self.interface is not EffortJointInterface or self.impairment == WHOLE:
            return self.limits
        return (*self.limits, _EffortBound(self.handle, self.max_effort))

    def reset(self) -> None:
        """Forget the past and ask for standstill where the joint is."""
        self.force = 0.0
        positional = self.mode in (DriveMode.POSITION, DriveMode.POSITION_PID)
        self.handle.command = self._previous = self.state.position if positional else 0.0
        for handle in self.limits:
            handle.reset()
        if self.pid is not None:
            self.pid.reset()

    def effort(self, period: float) -> float:
        """Effort that carries the command out now (Nm, N), of a joint with `takes_effort`.

        Parameters
        ----------
        period : float
            Time since the last call (s).
        """
        command = self.handle.command
        pid = self.pid
        if pid is None:
            self.force = command
            return command
        if self.mode is DriveMode.VELOCITY_PID:
            error = command - self.state.velocity
        else:
            error = command - self.state.position
            if self.description.kind == CONTINUOUS:
                error = math.remainder(error, 2.0 * math.pi)
        self.force = clamp(pid.update(error, period), -self.max_effort, self.max_effort)
        return self.force

    def reference_velocity(self, period: float) -> float:
        """Velocity of a position command since the last call (rad/s, m/s).

        0 without a velocity limit: a command may jump then.
        """
        command = self.handle.command
        moved, self._previous = command - self._previous, command
        return moved / period if self.max_velocity < math.inf and period > 0.0 else 0.0

    def resistance(self) -> float:
        """Amount of dry and viscous friction in the drive (Nm, N)."""
        return resistance(self.description, self.state.velocity)

    def drag(self) -> float:
        """Friction in the drive while it moves, against its motion (Nm, N)."""
        velocity = self.state.velocity
        if abs(velocity) < _STANDSTILL:
            return 0.0
        return -math.copysign(self.resistance(), velocity)

    @property
    def motor_velocity(self) -> float:
        """Largest velocity of its position motor (rad/s, m/s); PyBullet takes no infinity."""
        return self.max_velocity if math.isfinite(self.max_velocity) else _STRONG

    @property
    def motor_force(self) -> float:
        """Largest force of its motor (Nm, N); PyBullet takes no infinity."""
        return self.max_effort if math.isfinite(self.max_effort) else _STRONG

    @property
    def holding_force(self) -> float:
        """Largest force of its brake, or of what jams it (Nm, N)."""
        force = min(self.rated_effort, _STRONG)
        return min(_JAM * force if self.impairment.jammed else force, self.impairment.slip)


_STANDSTILL = 1.0e-6
"""Speed below which a joint rests (rad/s, m/s); PyBullet's solver leaves some noise."""
_STRONG = 1.0e6
_JAM = 10.0
"""Effort that a jammed joint bears, over that of its drive."""


def resistance(joint: UrdfJoint, velocity: float) -> float:
    """Amount of dry and viscous friction in a joint at a velocity (Nm, N)."""
    return joint.friction + joint.damping * abs(velocity)


class _EffortBound(JointLimitsHandle):
    """Bounds an effort."""

    __slots__ = ("_most",)

    def __init__(self, joint: JointHandle, most: float) -> None:
        super().__init__(joint)
        self._most = most

    def enforce(self, period: float) -> None:
        """See `JointLimitsHandle.enforce`."""
        joint = self._joint
        joint.command = clamp(joint.command, -self._most, self._most)


def _moved_out(
    limits: JointLimits, soft_limits: Optional[SoftJointLimits], distance: float
) -> Tuple[JointLimits, Optional[SoftJointLimits]]:
    """Return limits whose ends lie `distance` further out."""
    limits = dataclasses.replace(
        limits,
        min_position=limits.min_position - distance,
        max_position=limits.max_position + distance,
    )
    if soft_limits is not None:
        soft_limits = dataclasses.replace(
            soft_limits,
            min_position=soft_limits.min_position - distance,
            max_position=soft_limits.max_position + distance,
        )
    return limits, soft_limits


def _effort_limits(
    handle: JointHandle,
    limits: JointLimits,
    soft_limits: Optional[SoftJointLimits],
    tolerance: float,
) -> Tuple[JointLimitsHandle, ...]:
    """Limits of an effort joint.

    By itself the soft limits' handle takes effort away from every joint that nears its rated
    velocity, wherever it stands: at this velocity none is left to carry a load. Here that begins
    where the whole effort is still there at the rated velocity; towards the soft limits, nothing
    differs. The hard limits' handle takes all effort away at once, so that a joint which moves a
    load would have all and nothing by turns, and shake: it begins where the other leaves nothing.
    """
    fastest = limits.max_velocity * tolerance
    if soft_limits is None:
        tolerated = dataclasses.replace(limits, max_velocity=fastest)
        return (limits_handle(EffortJointInterface, handle, tolerated),)
    droop = limits.max_effort / soft_limits.k_velocity if soft_limits.k_velocity else 0.0
    unslowed = dataclasses.replace(limits, max_velocity=limits.max_velocity + droop)
    bound = dataclasses.replace(limits, max_velocity=max(fastest, unslowed.max_velocity))
    return (
        limits_handle(EffortJointInterface, handle, bound),
        limits_handle(EffortJointInterface, handle, unslowed, soft_limits),
    )
