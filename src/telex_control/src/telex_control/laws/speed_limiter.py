"""Limits of velocity, acceleration and jerk on a commanded speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple

from ..common.params import ConfigError, read_value
from ..hardware.joint_limits import clamp

_QUANTITIES = ("velocity", "acceleration", "jerk")
_DECELERATION = "max_deceleration"
_UNLIMITED = 1.0e9
"""Stands for infinity (unit/s): times a period of 0, it is a number."""


@dataclass(frozen=True)
class Range:
    """An interval of one quantity."""

    low: float
    high: float

    def __call__(self, value: float) -> float:
        """Return `value` bounded to the interval."""
        return clamp(value, self.low, self.high)


@dataclass(frozen=True)
class SpeedLimiter:
    """Bounds a speed by the two speeds commanded before it.

    Attributes
    ----------
    velocity, acceleration, jerk : Range or None
        Limits (unit, unit/s, unit/s2); None does not limit.
    deceleration : float or None
        Limit of changes towards standstill, from either direction, in place of that of the
        acceleration (unit/s); None: that one holds for them too.
    """

    velocity: Optional[Range] = None
    acceleration: Optional[Range] = None
    jerk: Optional[Range] = None
    deceleration: Optional[float] = None

    @classmethod
    def from_params(cls, params: Mapping[str, Any], name: str) -> SpeedLimiter:
        """Read ``has_velocity_limits``, ``max_velocity``, ``min_velocity`` (default -max), ….

        These are upstream's. Its ``min_acceleration`` bounds braking in forward motion, but
        starting in backward motion, too; ``max_deceleration`` bounds braking alone.

        Raises
        ------
        ConfigError
            A key is unknown or missing, or no finite number; the message names it in `name`.
        """
        known = {
            f"{kind}_{quantity}{plural}"
            for quantity in _QUANTITIES
            for kind, plural in (("has", "_limits"), ("max", ""), ("min", ""))
        } | {_DECELERATION}
        unknown = sorted(set(params) - known)
        if unknown:
            raise ConfigError(
                f"parameter {name}/{unknown[0]} is unknown; known are {', '.join(sorted(known))}"
            )

        def read(kind: Any, key: str, default: Any) -> Any:
            return read_value(kind, params.get(key, default), f"parameter {name}/{key}")

        def limits(quantity: str) -> Optional[Range]:
            if not read(bool, f"has_{quantity}_limits", False):
                return None
            high = read(float, f"max_{quantity}", None)
            low = read(float, f"min_{quantity}", -high)
            # A range without 0 would drive a robot that is told to stand.
            if not low <= 0.0 <= high:
                raise ConfigError(
                    f"parameter {name}: min_{quantity} {low} and max_{quantity} {high} must have "
                    "0 between them"
                )
            return Range(low, high)

        deceleration = None
        if _DECELERATION in params:
            deceleration = read(float, _DECELERATION, None)
            if deceleration <= 0.0:
                raise ConfigError(
                    f"parameter {name}/{_DECELERATION} is {deceleration}; it must be above 0"
                )
        return cls(limits("velocity"), limits("acceleration"), limits("jerk"), deceleration)

    def limit(
        self,
        speed: float,
        last: float,
        before_last: float,
        period: float,
        braking: float = math.inf,
    ) -> float:
        """Return `speed` within the limits.

        The order is that of diff_drive_controller: jerk, acceleration, velocity.

        Parameters
        ----------
        speed : float
            What is wanted.
        last, before_last : float
            What was commanded in the two cycles before.
        period : float
            Length of a cycle (s).
        braking : float
            Largest deceleration in this cycle, where it is less than the limit (unit/s).
        """
        if self.jerk is not None:
            # Second difference of the speed: jerk is its half over the period squared, upstream's
            # convention.
            change = speed - last
            last_change = last - before_last
            scale = 2.0 * period * period
            change = clamp(change - last_change, self.jerk.low * scale, self.jerk.high * scale)
            speed = last + last_change + change
        low, high = self._changes(last, braking)
        speed = last + clamp(speed - last, low * period, high * period)
        if self.velocity is not None:
            speed = self.velocity(speed)
        return speed

    def _changes(self, last: float, braking: float) -> Tuple[float, float]:
        """Return the least and the largest rate of change of the speed `last` (unit/s)."""
        low, high = -_UNLIMITED, _UNLIMITED
        if self.acceleration is not None:
            low, high = self.acceleration.low, self.acceleration.high
        if last > 0.0:
            low = -min(braking, -low if self.deceleration is None else self.deceleration)
        elif last < 0.0:
            high = min(braking, high if self.deceleration is None else self.deceleration)
        return low, high
