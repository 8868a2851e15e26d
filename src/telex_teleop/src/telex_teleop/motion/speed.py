"""The operator's speed: a factor on every commanded rate, its steps, and the speed of the zoom."""

from __future__ import annotations

import math

STEP = 0.1
"""Of the full speed, by one press; the console's page gets it with ``/actions.json``."""
STEP_RANGE = (0.01, 0.5)
"""Smallest and largest step that can be set."""
ZOOM_RATE = 0.8
"""Rate (1/s) of the logarithm of a camera's zoom factor: twice as near in 0.9 s."""
MAX_ZOOM = 6.0
"""Largest zoom factor, where the robot does not say what its camera has."""


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


def stepped(scale: float, direction: int, step: float, lowest: float, highest: float) -> float:
    """Return the next multiple of a step above (`direction` 1) or below (-1) a scale, in bounds."""
    steps = scale / step
    # A scale between two multiples goes to the next one, which is less than a step away.
    wanted = math.floor(steps + 1.0 + 1e-6) if direction > 0 else math.ceil(steps - 1.0 - 1e-6)
    return max(lowest, min(highest, wanted * step))
