"""One jogged axis: its command stream and the reference that follows it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Union

from telex_teleop.motion.reference import MotionLimits, ReferenceGenerator
from telex_teleop.motion.stream import Clocks, CommandStream


@dataclass(frozen=True)
class AxisSettings:
    """Limits of one axis.

    Attributes
    ----------
    motion
        Bounds of the reference.
    max_displacement
        Largest one-shot increment (rad or m): it runs without a key held, so it must stay small.
    """

    motion: MotionLimits
    max_displacement: float


@dataclass(frozen=True)
class _Rate:
    value: float


@dataclass(frozen=True)
class _Increment:
    value: float


class Axis:
    """Commands in, references out, for one joint or one group of coupled joints.

    Parameters
    ----------
    command_timeout
        Age (s) at which a command that is not repeated ends.
    """

    def __init__(self, settings: AxisSettings, command_timeout: float) -> None:
        self.settings = settings
        self.generator = ReferenceGenerator(settings.motion)
        self.stream: CommandStream[Union[_Rate, _Increment]] = CommandStream(command_timeout)
        self.position: Optional[float] = None
        self._jogging = False

    @property
    def reference(self) -> Optional[float]:
        """What the controller is asked to hold (rad or m), as far as this node knows."""
        reference = self.generator.reference
        return self.position if reference is None else reference

    def jog(self, rate: float, now: Clocks, caller: str, validity: Optional[float]) -> bool:
        """Take a rate (rad/s or m/s), 0 to stop; return whether it is obeyed and moves something.

        See `CommandStream.receive`.
        """
        if rate == 0.0:
            self.stop(caller)
            return False
        return self.stream.receive(_Rate(rate), now, caller, validity)

    def displace(self, increment: float, now: Clocks, caller: str) -> bool:
        """Take a one-shot increment of the reference (rad or m); return whether it is obeyed."""
        if increment == 0.0:
            return False
        # two of them between two joint states add up
        waiting = self.stream.command(now)
        if isinstance(waiting, _Increment):
            increment += waiting.value
        return self.stream.receive(_Increment(increment), now, caller)

    def stop(self, caller: str) -> None:
        """Take a command to stop: the reference comes to rest along its braking distance."""
        self.stream.end(caller)
        self.generator.stop()

    def yield_to_another(self) -> None:
        """Come to rest, because a newer command of another axis wins; the latch stays."""
        self.stream.discard()
        self.generator.stop()

    def drop(self) -> None:
        """Forget command and reference; a stream that goes on stays ignored until it pauses."""
        self.stream.latch()
        self.generator.drop()
        self._jogging = False

    def inhibit(self, inhibited: bool) -> None:
        """Begin or end an emergency stop."""
        self.stream.inhibit(inhibited)
        if inhibited:
            self.generator.drop()
            self._jogging = False

    def commanded(self, now: Clocks) -> bool:
        """Tell whether a command of its own holds."""
        return self.stream.command(now) is not None

    def obeying(self, now: Clocks) -> bool:
        """Tell whether a command is being carried out."""
        return self.commanded(now) or self.generator.displacing

    def wanted_rate(self, now: Clocks) -> float:
        """Return the rate (per second, at speed scale 1) at which the axis is to move now."""
        fastest = self.settings.motion.max_velocity
        command = self.stream.command(now)
        if isinstance(command, _Rate):
            return max(-fastest, min(fastest, command.value))
        if isinstance(command, _Increment):
            return math.copysign(fastest, command.value)
        if self.generator.displacing:
            return math.copysign(fastest, self.generator.velocity)
        return 0.0

    def thrown(self, dt: float, position: float) -> bool:
        """Tell whether the joint is further from where it was than it can have moved in a step.

        Then it was put there, and a reference from before would send it back.
        """
        motion = self.settings.motion
        farthest = motion.max_lead + motion.max_velocity * dt
        return self.position is not None and abs(position - self.position) > farthest

    def update(
        self,
        dt: float,
        now: Clocks,
        position: float,
        speed_scale: float,
        blocked: bool = False,
        goal: Optional[float] = None,
    ) -> Optional[float]:
        """Move the reference by one step.

        Parameters
        ----------
        dt
            Time since the last joint state (s).
        position
            Measured position (rad or m).
        blocked
            Come to rest first, because another axis still moves the same joints.
        goal
            Where to go (rad or m) while no command of this axis' own holds; None for nowhere.

        Returns
        -------
        float or None
            The reference to send, None while idle.
        """
        self.position = position
        command = self.stream.command(now)
        if isinstance(command, _Rate) and not blocked:
            self.generator.jog(command.value)
            self._jogging = True
        elif command is None and goal is not None and not blocked:
            self.generator.seek(goal)
            self._jogging = True
        elif self._jogging or blocked:
            self.generator.stop()
            self._jogging = False
        if isinstance(command, _Increment) and not blocked:
            self.generator.displace(command.value)
            self.stream.discard()
        return self.generator.update(dt, position, speed_scale)
