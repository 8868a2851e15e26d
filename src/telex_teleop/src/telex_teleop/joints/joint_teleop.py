"""Core of the joint teleoperation nodes: jogs in, references of position controllers out.

Free of ROS, not thread-safe: whoever owns it serialises the calls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, FrozenSet, List, Mapping, Optional, Set, Tuple

from telex_teleop.motion.axis import Axis, AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks
from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS, TeleopCore

JOINT_MODE = "JOINT"

# A motion begins with a step of at most so much (s), however long the node has rested before.
FIRST_STEP = 0.01


@dataclass(frozen=True)
class AxisState:
    """What a display shows of one axis: rad, rad/s (m, m/s for prismatic joints)."""

    name: str
    reference: float
    position: float
    max_velocity: float
    limited: bool


@dataclass(frozen=True)
class TeleopState:
    """What a display shows of the node.

    Attributes
    ----------
    active
        A command is being obeyed now.
    axes
        Empty before the first joint state.
    message
        Why commands are not obeyed, empty when they are.
    notice
        What else there is to know, such as what slows a motion; empty when nothing.
    commanders
        Whose commands those are.
    """

    active: bool
    axes: Tuple[AxisState, ...]
    message: str
    notice: str = ""
    commanders: Tuple[str, ...] = ()


class JointTeleop(TeleopCore):
    """Jogs a set of independent joints.

    Parameters
    ----------
    axes
        Joint name to the bounds of its motion.
    command_timeout, longest_step, speed
        See `TeleopCore`.
    """

    def __init__(
        self,
        axes: Mapping[str, AxisSettings],
        command_timeout: float,
        longest_step: float,
        speed: SpeedScale,
    ) -> None:
        super().__init__(command_timeout, longest_step, speed)
        self.axes: Dict[str, Axis] = {
            name: Axis(settings, command_timeout) for name, settings in axes.items()
        }
        self._commanded: Set[str] = set()  # got references with the last joint state
        self._to_hold: Set[str] = set()
        self._restarted = -math.inf
        self._inhibit()

    @property
    def commanded_names(self) -> Tuple[str, ...]:
        """Names that a jog may contain."""
        return tuple(self.axes)

    @property
    def measured_joints(self) -> Tuple[str, ...]:
        """Joints whose positions every update needs."""
        return tuple(self.axes)

    @property
    def output_joints(self) -> Tuple[str, ...]:
        """Joints whose controllers get references."""
        return tuple(self.axes)

    @property
    def idle(self) -> bool:
        """Whether the last joint state left nothing to move."""
        return not (self._commanded or self._to_hold)

    def receive(self, jog: JogCommand, wall: float, caller: str = "") -> FrozenSet[str]:
        """Take a jog.

        Parameters
        ----------
        wall
            Time of arrival (monotonic, s).
        caller
            Who sent it; see `CommandStream`.

        Returns
        -------
        frozenset
            Names that are to move and obey.

        Raises
        ------
        InvalidCommand
            When a displacement is too long; then no joint moves.
        """
        for name, increment in jog.displacements.items():
            longest = self.axes[name].settings.max_displacement
            if abs(increment) > longest:
                raise InvalidCommand(
                    f"displacements of {name} is {increment:g}; must be at most {longest:g} in one "
                    "message, because nobody holds a key for it"
                )
        if self._ticks.now is None:
            return frozenset()
        now = self._arrival(wall)
        obeying = {
            name: self.axes[name].jog(rate, now, caller, jog.validity)
            for name, rate in jog.velocities.items()
        }
        for name, increment in jog.displacements.items():
            obeying[name] = self.axes[name].displace(increment, now, caller)
        return frozenset(name for name, obeys in obeying.items() if obeys)

    def restart(self, stamp: float) -> None:
        """Forget all motion, because the robot was put somewhere else at `stamp` (s of sim time).

        A reference from before may still be on its way to a controller and would send the joint
        back, so what was moving is told once to stay where it is found afterwards.
        """
        self._drop()
        self._restarted = stamp
        self._to_hold |= self._commanded

    def update(self, stamp: float, wall: float, positions: Mapping[str, float]) -> Dict[str, float]:
        """Advance to a new joint state.

        Parameters
        ----------
        stamp
            Its stamp (s of sim time).
        wall
            Monotonic time (s) of its arrival.
        positions
            Measured position (rad or m) of each of `measured_joints`.

        Returns
        -------
        dict
            Joint to reference (rad or m); joints that are idle are not in it.
        """
        dt = self._advance(stamp, wall)
        if dt is None:
            return {}
        if any(self.axes[name].thrown(dt, positions[name]) for name in self.measured_joints):
            self.restart(stamp)
        if self.idle:
            dt = min(dt, FIRST_STEP)
        references = self._references(dt, Clocks(wall, stamp), positions)
        self._commanded = set(references)
        return {**self._held(stamp, positions), **references}

    def _held(self, stamp: float, positions: Mapping[str, float]) -> Dict[str, float]:
        # Not with the joint state of the throw itself: that may be one wrong measurement.
        if stamp <= self._restarted:
            return {}
        held = {name: positions[name] for name in self._to_hold}
        self._to_hold.clear()
        return held

    def _references(
        self, dt: float, now: Clocks, positions: Mapping[str, float]
    ) -> Dict[str, float]:
        references = {
            name: axis.update(dt, now, positions[name], self.speed.value)
            for name, axis in self.axes.items()
        }
        return {name: value for name, value in references.items() if value is not None}

    def _advance(self, stamp: float, wall: float) -> Optional[float]:
        """Return the step (s) to a new stamp; None when there is nothing to do in it."""
        if self._starting.ends(wall):
            self._inhibit()
        tick = self._ticks.advance(stamp)
        last_wall, self._last_wall = self._last_wall, wall
        if tick is None:
            return None
        if tick.jumped:
            self._drop()
            self._to_hold.clear()
            return None
        # After a pause of the simulation a displacement is no longer what the operator expects.
        if last_wall is not None and wall - last_wall > self._command_timeout:
            for axis in self.axes.values():
                if axis.generator.displacing:
                    axis.generator.stop()
        return tick.dt

    def _inhibit(self) -> None:
        for axis in self.axes.values():
            axis.inhibit(self._inhibited)

    def _drop(self) -> None:
        for axis in self.axes.values():
            axis.drop()

    def state(self, wall: float) -> TeleopState:
        """Return what a display shows at `wall` (monotonic time, s)."""
        message = self._inhibition(wall)
        if self._ticks.now is None or self._last_wall is None:
            return TeleopState(False, (), message)
        now = Clocks(wall, self._ticks.now)
        message = message or self._refusal(wall)
        commanders = () if message else tuple(sorted(self._commanders(now)))
        return TeleopState(
            bool(commanders), self._axis_states(), message, self._notice(now), commanders
        )

    def _inhibition(self, wall: float) -> str:
        if not self.axes:
            return "this robot has none of the joints of this node"
        return super()._inhibition(wall)

    def _refusal(self, wall: float) -> str:
        """Return why a command that is being sent at `wall` (monotonic, s) is not obeyed."""
        waiting = any(axis.stream.waiting(wall) for axis in self.axes.values())
        return NEEDS_NEW_PRESS if waiting else ""

    def _commanders(self, now: Clocks) -> Set[str]:
        """Return whose commands are being carried out."""
        return {axis.stream.obeyed for axis in self.axes.values() if axis.obeying(now)}

    def _notice(self, now: Clocks) -> str:
        """Return what else there is to know, empty where nothing."""
        del now
        return ""

    def _axis_states(self) -> Tuple[AxisState, ...]:
        states: List[AxisState] = []
        for name, axis in self.axes.items():
            if axis.position is None or axis.reference is None:
                continue
            limit = axis.settings.motion.max_velocity
            limited = axis.generator.limited
            states.append(AxisState(name, axis.reference, axis.position, limit, limited))
        return tuple(states)
