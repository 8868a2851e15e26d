"""The operator's speed: a factor on every commanded rate."""

from __future__ import annotations

import math

__all__ = ["SpeedScale"]


class SpeedScale:
    """Speed scale between two bounds.

    Parameters
    ----------
    initial
        First value.
    minimum, maximum
        Bounds, ``0 < minimum <= initial <= maximum <= 1``.
    """

    def __init__(self, initial: float = 1.0, minimum: float = 0.05, maximum: float = 1.0) -> None:
        if not 0.0 < minimum <= initial <= maximum <= 1.0:
            raise ValueError(
                f"speed scale: minimum {minimum:g}, initial {initial:g}, maximum {maximum:g}; "
                "must be 0 < minimum <= initial <= maximum <= 1"
            )
        self.minimum = minimum
        self.maximum = maximum
        self._value = initial

    @property
    def value(self) -> float:
        """Present scale."""
        return self._value

    def set(self, value: float) -> None:
        """Set the scale, clamped to its bounds.

        Raises
        ------
        ValueError
            For NaN and infinity.
        """
        if not math.isfinite(value):
            raise ValueError(
                f"speed_scale is {value!r}; must be a number from {self.minimum:g} to "
                f"{self.maximum:g}"
            )
        self._value = max(self.minimum, min(self.maximum, value))
