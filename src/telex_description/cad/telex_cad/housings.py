"""Housings of cameras and lamps, as solids by material.

Both look along x; the origin is the front of the lens, and nothing stands before it: a camera
does not see itself, and a lamp does not shade itself. Lengths in m.
"""

from __future__ import annotations

import math
from typing import Dict, List, Sequence

from manifold3d import Manifold

from .link_model import LinkModel
from .solids import box, prism, ring, turned

Parts = Dict[str, List[Manifold]]


def camera_housing() -> Parts:
    """Return a camera: body 36 x 38 x 34 mm, slim visor over the lens."""
    side = [
        (-0.040, -0.012),
        (-0.036, -0.016),
        (-0.008, -0.016),
        (-0.006, -0.012),
        (-0.006, 0.014),
        (-0.010, 0.0165),
        (-0.036, 0.0165),
        (-0.040, 0.012),
    ]
    visor = prism(
        [(-0.034, 0.0165), (-0.001, 0.0175), (-0.001, 0.0188), (-0.034, 0.0188)], 0.036, 0.0
    )
    cheeks = [
        prism(
            [(-0.010, 0.018), (-0.002, 0.018), (-0.005, 0.004), (-0.010, 0.000)],
            0.0018,
            0.0,
            at=(0, y, 0),
        )
        for y in (-0.0171, 0.0171)
    ]
    return {
        "dark": [
            prism(side, 0.036, 0.003),
            ring(0.0142, 0.0110, 0.0065, "x", (-0.0042, 0, 0), 0.0, 16),
        ],
        "panel": [visor, *cheeks, box((0.0012, 0.026, 0.022), (-0.0400, 0, 0), 0.0)],
        "glass": [
            turned(
                [(0, -0.004), (0.0112, -0.004), (0.0080, 0.002), (0, 0.0032)],
                "x",
                (-0.0046, 0, 0),
                16,
            )
        ],
        "metal": [box((0.0020, 0.006, 0.004), (-0.0406, 0, -0.006), 0.0)],
    }


def lamp_housing(radius: float) -> Parts:
    """Return a round lamp with a cooling fin behind it; radius of its rim."""
    body = [
        (0.0, -0.0250),
        (0.62, -0.0250),
        (0.62, -0.0215),
        (0.94, -0.0215),
        (0.94, -0.0195),
        (0.70, -0.0195),
        (0.70, -0.0165),
        (0.96, -0.0150),
        (0.96, -0.0090),
        (1.0, -0.0080),
        (1.0, -0.0010),
        (0.95, 0.0),
        (0.80, 0.0),
        (0.80, -0.0070),
        (0.0, -0.0070),
    ]
    glass = [(0.0, -0.0072), (0.80, -0.0072), (0.62, -0.0036), (0.0, -0.0022)]
    return {
        "dark": [turned([(radius * part, x) for part, x in body], "x", segments=12)],
        "lamp": [turned([(radius * part, x) for part, x in glass], "x", segments=12)],
    }


def mount(
    link: LinkModel, parts: Parts, at: Sequence[float], pitch: float = 0.0, yaw: float = 0.0
) -> None:
    """Add a housing to a link: its front at `at`, turned by the pitch, then by the yaw (rad)."""
    for material, solids in parts.items():
        for solid in solids:
            turned_solid = solid.rotate((0.0, math.degrees(pitch), math.degrees(yaw)))
            link.add(material, turned_solid.translate(tuple(at)))
