"""Mounts of valves, sockets and task panels: a plate on a wall or on a post.

Everything mounted looks towards -x; the back of its plate lies at x = 0, its front at
-`PLATE`.
"""

from __future__ import annotations

from typing import Tuple

from ...model import Surface
from .. import materials as look
from ..shapes import Parts, box

PLATE = 0.02
"""Thickness of the plate (m)."""

MOUNTS: Tuple[str, ...] = ("stand", "wall")

SEATED = 8.0
"""Sideways and inwards, a piece in a hole bears so much more than the pull that brings it out."""

_FOOT = 0.012
_POST = 0.08


def mount(
    kind: str, height: float, width: float, tall: float, surface: Surface = look.LIGHT_PAINT
) -> Parts:
    """Make a plate with its middle at `height`, and the post that carries it.

    Parameters
    ----------
    kind : str
        stand, or wall for a plate alone, to be put against a wall.
    height, width, tall : float
        Middle over the floor, extents along y and z (m). Where it would reach into the floor, the
        plate ends there.
    """
    top = height + 0.5 * tall
    bottom = max(height - 0.5 * tall, _FOOT)
    plate = box((PLATE, width, top - bottom), (-0.5 * PLATE, 0.0, 0.5 * (top + bottom)), surface)
    if kind == "wall":
        return (plate,)
    foot = max(0.4, 0.55 * width)
    length = max(top - 0.05, bottom + 0.05) - _FOOT
    return (
        plate,
        box((foot, foot, _FOOT), (0.5 * _POST, 0.0, 0.5 * _FOOT), look.DARK_STEEL),
        box((_POST, _POST, length), (0.5 * _POST, 0.0, _FOOT + 0.5 * length), look.GRAY_PAINT),
    )
