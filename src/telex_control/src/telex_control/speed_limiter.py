"""Limits of velocity, acceleration and jerk on a commanded speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional

from .joint_limits import clamp
from .params import ConfigError, read_value

_QUANTITIES = ("velocity", "acceleration", "jerk")


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
    """

    velocity: Optional[Range] = None
    acceleration: Optional[Range] = None
    jerk: Optional[Range] = None

    @classmethod
    def from_params(cls, params: Mapping[str, Any], name: str) -> SpeedLimiter:
        """Read ``has_velocity_limits``, ``max_velocity``, ``min_velocity`` (default -max), ….

        Raises
        ------
        ConfigError
            A key is unknown or missing, or no finite number; the message names it in `name`.
        """
        known = {
            f"{kind}_{quantity}{plural}"
            for quantity in _QUANTITIES
            for kind, plural in (("has", "_limits"), ("max", ""), ("min", ""))
        }
        unknown = sorted(set(params) - known)
        if unknown:
            raise ConfigError(
                f"parameter {name}/{unknown[0]} is unknown; known are {', '.join(sorted(known))}"
            )

        def limits(quantity: str) -> Optional[Range]:
            def read(kind: Any, key: str, default: Any) -> Any:
                return read_value(kind, params.get(key, default), f"parameter {name}/{key}")

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

        return cls(limits("velocity"), limits("acceleration"), limits("jerk"))

    def limit(self, speed: float, last: float, before_last: float, period: float) -> float:
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
        """
        if self.jerk is not None:
            # Second difference of the speed: jerk is its half over the period squared, upstream's
            # convention.
            change = speed - last
            last_change = last - before_last
            scale = 2.0 * period * period
            change = clamp(change - last_change, self.jerk.low * scale, self.jerk.high * scale)
            speed = last + last_change + change
        if self.acceleration is not None:
            change = clamp(
                speed - last, self.acceleration.low * period, self.acceleration.high * period
            )
            speed = last + change
        if self.velocity is not None:
            speed = self.velocity(speed)
        return speed
