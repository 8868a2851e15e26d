"""Common parts of the elements of a beam line; the beam runs along x."""

from __future__ import annotations

import math

from ...model import Vector3
from .. import materials as look
from ..shapes import LYING_X, Parts, box, cylinder, rod, seen_only, steel_post

BEAM_HEIGHT = 0.95
"""Usual height of the beam over the floor (m)."""


def flanged_pipe(start: float, end: float, radius: float, height: float) -> Parts:
    """Pipe along x with a flange at either end."""
    length, middle = end - start, 0.5 * (start + end)
    flange = 0.024
    bolts = []
    for at in (start + 0.5 * flange, end - 0.5 * flange):
        for index in range(8):
            angle = 2.0 * math.pi * index / 8
            y, z = 1.45 * radius * math.cos(angle), 1.45 * radius * math.sin(angle)
            bolts.append(
                cylinder(0.08 * radius, flange + 0.012, (at, y, height + z), look.STEEL, LYING_X)
            )
    return (
        cylinder(radius, length, (middle, 0.0, height), look.STAINLESS, LYING_X),
        *(
            cylinder(1.75 * radius, flange, (at, 0.0, height), look.STAINLESS, LYING_X)
            for at in (start + 0.5 * flange, end - 0.5 * flange)
        ),
        *seen_only(bolts),
    )


def saddle(at: float, top: float, width: float) -> Parts:
    """Make a stand for what is `width` wide and has its underside at `top`."""
    return (
        box((0.28, 0.28, 0.015), (at, 0.0, 0.0075), look.DARK_STEEL),
        steel_post(top - 0.075, 0.08, (at, 0.0, 0.015), look.GRAY_PAINT),
        box((0.1, width + 0.06, 0.02), (at, 0.0, top - 0.05), look.STEEL),
        *(
            box((0.05, 0.02, 0.09), (at, side * 0.5 * width, top), look.STEEL)
            for side in (-1.0, 1.0)
        ),
    )


def jack(at: Vector3, width: float, height: float) -> Parts:
    """Adjustable foot under a magnet: a concrete block, a plate and three screws."""
    x, y, _ = at
    block = 0.7 * height
    parts = [
        box((0.3, width, block), (x, y, 0.5 * block), look.CONCRETE),
        box((0.26, width - 0.04, 0.02), (x, y, height - 0.01), look.STEEL),
    ]
    for side in (-1.0, 1.0):
        foot = (x, y + side * 0.35 * width, block)
        top = (x, y + side * 0.35 * width, height - 0.02)
        parts.append(rod(foot, top, 0.025, look.STEEL))
    return tuple(parts)
