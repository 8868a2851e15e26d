"""Appearance of the library's objects."""

from __future__ import annotations

from ..model import Surface

WOOD = Surface((0.80, 0.63, 0.42, 1.0), "generated:wood", 0.8)
OLD_WOOD = Surface((0.66, 0.53, 0.38, 1.0), "generated:wood", 0.6)
PLYWOOD = Surface((0.90, 0.77, 0.57, 1.0), "generated:wood", 1.6)
CARDBOARD = Surface((0.76, 0.60, 0.42, 1.0), "generated:cardboard", 0.5)
CONCRETE = Surface((0.78, 0.78, 0.76, 1.0), "generated:concrete?slabs=0", 2.0)
PLASTER = Surface((0.86, 0.86, 0.83, 1.0), "generated:plaster", 2.0)
BRICK = Surface((0.72, 0.50, 0.42, 1.0), "generated:brick", 1.0)
TILES = Surface((0.85, 0.86, 0.86, 1.0), "generated:tiles", 1.0)
TREAD_PLATE = Surface((0.62, 0.64, 0.66, 1.0), "generated:tread_plate", 0.4)
HAZARD = Surface((1.0, 1.0, 1.0, 1.0), "generated:hazard_stripes", 0.25)
RUBBER = Surface((0.13, 0.13, 0.14, 1.0), "generated:rubber", 0.3)
TUNNEL_WALL = Surface((0.72, 0.72, 0.70, 1.0), "generated:tunnel_wall", 2.0)

STEEL = Surface((0.55, 0.57, 0.60, 1.0), "generated:brushed_metal", 0.5)
STAINLESS = Surface((0.70, 0.71, 0.73, 1.0), "generated:brushed_metal", 0.5)
ALUMINIUM = Surface((0.75, 0.76, 0.78, 1.0))
DARK_STEEL = Surface((0.30, 0.31, 0.33, 1.0))
COPPER = Surface((0.78, 0.46, 0.28, 1.0))
LEAD = Surface((0.42, 0.43, 0.46, 1.0))
BLACK = Surface((0.08, 0.08, 0.09, 1.0))
WHITE = Surface((0.93, 0.93, 0.92, 1.0))

_PAINTED = "generated:painted_metal"
YELLOW_PAINT = Surface((0.93, 0.75, 0.12, 1.0), _PAINTED, 1.0)
RED_PAINT = Surface((0.72, 0.12, 0.10, 1.0), _PAINTED, 1.0)
BLUE_PAINT = Surface((0.15, 0.30, 0.58, 1.0), _PAINTED, 1.0)
GREEN_PAINT = Surface((0.16, 0.42, 0.26, 1.0), _PAINTED, 1.0)
GRAY_PAINT = Surface((0.56, 0.58, 0.60, 1.0), _PAINTED, 1.0)
LIGHT_PAINT = Surface((0.80, 0.82, 0.83, 1.0), _PAINTED, 1.0)
ORANGE = Surface((0.95, 0.38, 0.08, 1.0))


def picture(name: str, glow: float = 0.0) -> Surface:
    """Make a generated picture, stretched once over each face."""
    return Surface((1.0, 1.0, 1.0, 1.0), f"generated:{name}", 0.0, glow)


def plain(red: float, green: float, blue: float, glow: float = 0.0) -> Surface:
    """Make a smooth surface of one colour."""
    return Surface((red, green, blue, 1.0), "", 1.0, glow)
