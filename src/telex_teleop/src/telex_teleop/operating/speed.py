"""Steps of the speed scale: the same for keyboard and gamepad, and for the console."""

from __future__ import annotations

import math

STEP = 0.1
"""Of the full speed; the console's ``commander.js`` has the same."""
STEP_RANGE = (0.01, 0.5)
"""Smallest and largest step that can be set."""


def stepped(scale: float, direction: int, step: float, lowest: float, highest: float) -> float:
    """Return the next multiple of a step above (`direction` 1) or below (-1) a scale, in bounds."""
    steps = scale / step
    # A scale between two multiples goes to the next one, which is less than a step away.
    wanted = math.floor(steps + 1.0 + 1e-6) if direction > 0 else math.ceil(steps - 1.0 - 1e-6)
    return max(lowest, min(highest, wanted * step))
