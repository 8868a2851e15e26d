"""Friction, closers, dampers and detents of the joints inside objects.

Dry friction is a velocity motor that wants standstill: part of the constraint solver, it holds
exactly up to its limit and brakes with it beyond. A detent is a position motor within its notch,
no stronger than the notch. Springs and dampers are efforts, applied in every step; the damper is
implicit, since an explicit one diverges above ``2 * inertia / step``.
"""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

import pybullet

from telex_control.common.stateful import Stateful

from ..model import Closer, Detents, Joint
from .assembly import BodyPlan

_NOTCH_GAIN = 0.05
"""Share of its distance from a notch's middle that a joint is drawn back in each step."""
_NOTCH_SPEED = 1.0
"""Speed with which a notch draws a joint in, at most (rad/s, m/s)."""
_STILL = 1e-6
"""Speed (rad/s, m/s) below which a joint rests; without a closer it then needs nothing."""
_LOOK_EVERY = 2
"""Steps between two looks at the joints; to look costs more than to apply an effort again."""
_LOOK_AT_REST = 5
"""Steps between two looks at joints that rest."""
_RAMP = 1e-3
"""Distance from a closer's rest (rad, m) within which its preload fades, where it can swing."""


class _Spring:
    """Closer and damper of a joint, as an effort."""

    __slots__ = ("_damping", "_preload", "_ramp", "_rest", "_side", "_stiffness")

    def __init__(self, joint: Joint, inertia: float, period: float) -> None:
        closer = joint.closer or Closer(0.0)
        self._damping = joint.damping / (1.0 + joint.damping * period / inertia)
        self._preload = closer.preload
        self._stiffness = closer.stiffness
        self._rest = closer.rest
        # Against a stop the full preload presses; a rest in between would make it chatter.
        self._side = 0.0
        if closer.rest <= joint.lower or closer.rest >= joint.upper:
            self._side = 1.0 if closer.rest <= joint.lower else -1.0
        self._ramp = max(_RAMP, 4.0 * closer.preload * period**2 / inertia)

    def effort(self, position: float, velocity: float) -> float:
        away = position - self._rest
        side = self._side or max(-1.0, min(1.0, away / self._ramp))
        return -self._preload * side - self._stiffness * away - self._damping * velocity


class _Notches:
    """Detents of a joint: which one holds it now."""

    __slots__ = ("_effort", "_friction", "_positions", "_width", "held")

    def __init__(self, detents: Detents, friction: float) -> None:
        self._positions = detents.positions
        self._width = detents.width
        self._effort = detents.effort
        self._friction = friction
        self.held: Optional[float] = None

    def nearest(self, position: float) -> Optional[float]:
        """Middle of the notch that the joint is in."""
        for middle in self._positions:
            if abs(position - middle) <= self._width:
                return middle
        return None

    def hold(self, client: int, uid: int, index: int, middle: Optional[float]) -> None:
        """Set the joint's motor for a notch, or for none."""
        self.held = middle
        if middle is None:
            set_friction(client, uid, index, self._friction)
            return
        pybullet.setJointMotorControl2(
            uid,
            index,
            pybullet.POSITION_CONTROL,
            targetPosition=middle,
            positionGain=_NOTCH_GAIN,
            velocityGain=1.0,
            maxVelocity=_NOTCH_SPEED,
            force=self._friction + self._effort,
            physicsClientId=client,
        )


class Mechanism(Stateful):
    """The joints of one body that need attention in every step.

    Parameters
    ----------
    client, uid : int
        PyBullet's, of the body.
    step_size : float
        Time between calls of `apply` (s).
    """

    SAVED = ("_efforts", "_until_look")

    def __init__(self, client: int, uid: int, plan: BodyPlan, step_size: float) -> None:
        self._client = client
        self._uid = uid
        self._indices: List[int] = []
        self._controls: List[Tuple[Optional[_Spring], Optional[_Notches]]] = []
        self._driven: List[int] = []
        self._efforts: List[float] = []
        self._has_closer = False
        self._until_look = 0
        for number, segment in enumerate(plan.segments):
            joint = segment.joint
            if joint is None:
                continue
            set_friction(client, uid, number - 1, joint.friction)
            spring = notches = None
            self._has_closer |= joint.closer is not None
            if joint.closer or joint.damping:
                period = _LOOK_EVERY * step_size
                spring = _Spring(joint, plan.inertias[joint.name], period)
                self._driven.append(number - 1)
            if joint.detents:
                notches = _Notches(joint.detents, joint.friction)
            if spring or notches:
                self._indices.append(number - 1)
                self._controls.append((spring, notches))

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do for it in any step."""
        return not self._indices

    def save_state(self) -> Any:
        """Return the present state, with the notches that hold."""
        held = [notches.held for _, notches in self._controls if notches is not None]
        return super().save_state(), held

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; the joints are where they were."""
        state, held = saved
        super().restore_state(state, elapsed)
        notched = [
            (index, notches)
            for index, (_, notches) in zip(self._indices, self._controls)
            if notches is not None
        ]
        for (index, notches), middle in zip(notched, held):
            notches.hold(self._client, self._uid, index, middle)

    def apply(self) -> None:
        """Apply what acts in the next step."""
        if self._until_look:
            self._until_look -= 1
        else:
            self._look()
        if self._efforts:
            pybullet.setJointMotorControlArray(
                self._uid,
                self._driven,
                pybullet.TORQUE_CONTROL,
                forces=self._efforts,
                physicsClientId=self._client,
            )

    def _look(self) -> None:
        """Find out what acts until the next look."""
        uid, client = self._uid, self._client
        states = pybullet.getJointStates(uid, self._indices, physicsClientId=client)
        self._efforts = []
        for index, (spring, notches), state in zip(self._indices, self._controls, states):
            if notches is not None:
                middle = notches.nearest(state[0])
                if middle != notches.held:
                    notches.hold(client, uid, index, middle)
            if spring is not None:
                self._efforts.append(spring.effort(state[0], state[1]))
        self._until_look = _LOOK_EVERY - 1
        if all(-_STILL < state[1] < _STILL for state in states):
            self._until_look = _LOOK_AT_REST - 1
            if not self._has_closer:
                self._efforts = []


def set_friction(client: int, uid: int, index: int, friction: float) -> None:
    """Give a joint dry friction (N m, N); with 0 it is free, which PyBullet's joints are not."""
    pybullet.setJointMotorControl2(
        uid,
        index,
        pybullet.VELOCITY_CONTROL,
        targetVelocity=0.0,
        force=friction,
        physicsClientId=client,
    )
