"""Drives of belts: a motor with limited force, power and acceleration, and its brake."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

from telex_control.common.params import Declared, number
from telex_control.common.stateful import Stateful
from telex_control.hardware.joint_limits import clamp


@dataclass(frozen=True)
class BeltDriveConfig(Declared):
    """A motor and the belts that it drives, all seen at the belt."""

    force: float = number(540.0, "Largest of the motor (N).", maximum=1.0e6, above=0.0)
    power: float = number(
        250.0,
        "Largest that the motor gives (W); it may take more, as a brake.",
        maximum=1.0e6,
        above=0.0,
    )
    acceleration: float = number(
        5.0, "With which the motor's controller changes the speed (m/s2).", maximum=1.0e6, above=0.0
    )
    inertia: float = number(15.0, "Of rotor, gear, wheels and belts (kg).", 0.01, 1.0e6)
    brake_force: float = number(
        900.0,
        "Of the parking brake, which also stops the belt in an emergency (N).",
        maximum=1.0e6,
        above=0.0,
    )


class BeltDrive(Stateful):
    """A motor and what it drives, at one speed.

    The motor's own controller follows a speed. The equation of motion is solved for the speed at
    the end of the step, together with the traction at that speed: however stiff the bristles, a
    light belt does not shake.

    Parameters
    ----------
    friction, damping : float
        Dry and viscous friction of gear and belts, at the belt (N, N s/m).
    step_size : float
        s.

    Attributes
    ----------
    speed : float
        Of the belts (m/s).
    force : float
        Of the motor, or of the brake, in the last step (N).
    """

    __slots__ = (
        "_change",
        "_config",
        "_damping",
        "_dry",
        "_inertia",
        "force",
        "speed",
    )
    SAVED = ("force", "speed")

    def __init__(
        self, config: BeltDriveConfig, friction: float, damping: float, step_size: float
    ) -> None:
        self._config = config
        self._dry = friction
        self._damping = damping
        self._change = config.acceleration * step_size
        self._inertia = config.inertia / step_size
        self.speed = 0.0
        self.force = 0.0

    def follow(self, command: float, traction: Callable[[float], float]) -> None:
        """Advance by a step towards a speed.

        Parameters
        ----------
        command : float
            m/s.
        traction : callable
            Force along the belts that they would give the robot at a speed of this step (N, of
            m/s); it must not decrease with the speed. Its last call is that with `speed`.
        """
        change = self._change
        target = self.speed + clamp(command - self.speed, -change, change)
        self._reach(target, traction, self._strength)

    def push(self, force: float, traction: Callable[[float], float]) -> None:
        """Advance by a step with a motor force (N), within its limits; `traction` as before."""

        def limit(speed: float) -> float:
            if force >= 0.0:
                return min(force, self._strength(speed))
            return -min(-force, self._strength(-speed))

        self._settle(self.speed, self._needed(self.speed, traction), limit, traction)

    def brake(self, traction: Callable[[float], float]) -> None:
        """Advance by a step with the brake set; `traction` as before."""
        self._reach(0.0, traction, lambda speed: self._config.brake_force)

    def _strength(self, speed: float) -> float:
        """Largest force of the motor in the direction of a speed that is positive (N)."""
        config = self._config
        return config.force if speed * config.force <= config.power else config.power / speed

    def _needed(self, speed: float, traction: Callable[[float], float]) -> float:
        """Motor force that leads to a speed (N), without dry friction."""
        return self._inertia * (speed - self.speed) + traction(speed) + self._damping * speed

    def _with_friction(self, force: float, speed: float) -> float:
        """Add dry friction, which at rest bears what it can."""
        if speed == 0.0:
            return force - clamp(force, -self._dry, self._dry)
        return force + math.copysign(self._dry, speed)

    def _reach(
        self,
        target: float,
        traction: Callable[[float], float],
        strength: Callable[[float], float],
    ) -> None:
        """Go to a speed, or as near as the force suffices."""
        needed = self._needed(target, traction)
        force = self._with_friction(needed, target)
        # A motor that drives is at most as strong as one that brakes.
        if abs(force) <= strength(abs(target)):
            self.speed, self.force = target, force
        elif force > strength(target):
            self._settle(target, needed, strength, traction)
        elif force < -strength(-target):
            self._settle(target, needed, lambda speed: -strength(-speed), traction)
        else:
            self.speed, self.force = target, force

    def _settle(
        self,
        speed: float,
        needed: float,
        limit: Callable[[float], float],
        traction: Callable[[float], float],
    ) -> None:
        """Find the speed that a motor force leads to.

        What is needed beyond the force grows with the speed by the inertia at least: this gives
        the other end of an interval for regula falsi, after Illinois.

        Parameters
        ----------
        speed : float
            To begin with (m/s); `traction` was last called with it.
        needed : float
            See `_needed`, at this speed.
        limit : callable
            Motor force at a speed; it does not increase with it.
        """
        excess = self._with_friction(needed - limit(speed), speed)
        other = speed - excess / self._inertia
        dry = math.copysign(self._dry, speed or other)
        if speed > 0.0 > other or speed < 0.0 < other:
            at_rest = self._needed(0.0, traction) - limit(0.0)
            if abs(at_rest) <= self._dry:
                self.speed, self.force = 0.0, limit(0.0)
                return
            if (at_rest > 0.0) is (excess > 0.0):
                # The root lies beyond standstill.
                speed, dry = 0.0, -dry
                excess = at_rest + dry
            else:
                other = 0.0
        found = other
        left = self._needed(found, traction) + dry - limit(found)
        for _ in range(_ITERATIONS):
            if abs(left) <= _TOLERANCE:
                break
            between = (speed * left - found * excess) / (left - excess)
            value = self._needed(between, traction) + dry - limit(between)
            if (value > 0.0) is (left > 0.0):
                excess *= 0.5
            else:
                speed, excess = found, left
            found, left = between, value
        self.speed, self.force = found, limit(found)


_ITERATIONS = 30
_TOLERANCE = 0.1
"""Of the force balance (N)."""
