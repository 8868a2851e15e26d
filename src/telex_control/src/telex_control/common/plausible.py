"""Largest numbers that a command can mean.

What lies somewhat beyond a limit is clamped to it, as upstream's controllers do. A number that
lies beyond all reason comes from a fault (another unit, a broken float), and the joint would run to
its stop for it: such a command is refused where it comes in.
"""

from __future__ import annotations

import math

LARGEST_POSITION = 1.0e4
"""rad, m; of what has no position limits."""
LARGEST_SPEED = 1.0e3
"""rad/s, m/s; of what has no speed limit, or a higher one."""
LARGEST_ACCELERATION = 1.0e5
"""rad/s2, m/s2."""
LARGEST_EFFORT = 1.0e6
"""N m, N."""
LONGEST = 86400.0
"""s; no trajectory takes longer."""
_BEYOND = 100.0
"""How far (rad, m) beyond its limits a position may lie that is meant for them."""
_TIMES = 100.0
"""How many times the limit a speed may be that is meant for it."""


def number_problem(value: float, largest: float) -> str:
    """Why a number can be no command, in words that follow it; empty where it can.

    Parameters
    ----------
    largest : float
        Magnitude that is possible.
    """
    if not math.isfinite(value):
        return "is not finite"
    return f"is beyond {largest:g}" if abs(value) > largest else ""


def position_problem(value: float, lower: float = -math.inf, upper: float = math.inf) -> str:
    """Why a number can be no position (rad, m) of a joint with these limits; empty where it can."""
    if not math.isfinite(value):
        return "is not finite"
    low = -LARGEST_POSITION if lower == -math.inf else lower - _BEYOND
    high = LARGEST_POSITION if upper == math.inf else upper + _BEYOND
    if low <= value <= high:
        return ""
    if math.isinf(lower) and math.isinf(upper):
        return f"is beyond {LARGEST_POSITION:g}"
    return f"is more than {_BEYOND:g} beyond the limits, {lower:g} to {upper:g},"


def speed_problem(value: float, limit: float = math.inf) -> str:
    """Why a number can be no speed (rad/s, m/s) where this is the limit; empty where it can.

    A limit of 0, as CAD exporters write it, tells nothing of what is meant.
    """
    if not math.isfinite(value):
        return "is not finite"
    if limit <= 0.0:
        limit = math.inf
    if abs(value) <= min(LARGEST_SPEED, _TIMES * limit):
        return ""
    if _TIMES * limit < LARGEST_SPEED:
        return f"is more than {_TIMES:g} times the limit, {limit:g},"
    return f"is beyond {LARGEST_SPEED:g}"


def effort_problem(value: float) -> str:
    """Why a number can be no effort (N m, N); empty where it can."""
    return number_problem(value, LARGEST_EFFORT)
