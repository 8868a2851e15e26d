"""Materials of the robot: colours, and densities for the mass properties."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Optional, Tuple


@dataclass(frozen=True)
class Material:
    """One material.

    Attributes
    ----------
    colour
        Red, green, blue, 0 to 1; None where it is inside the housings and never seen.
    density
        kg/m^3, of the part as built: a casting of aluminium is hollow, a housing is full of things.
    """

    colour: Optional[Tuple[float, float, float]]
    density: float


MATERIALS: Dict[str, Material] = {
    "hull": Material((0.205, 0.220, 0.225), 2700.0),
    "panel": Material((0.115, 0.125, 0.130), 2700.0),
    "shell": Material((0.640, 0.660, 0.660), 2700.0),
    "dark": Material((0.150, 0.160, 0.170), 2700.0),
    "metal": Material((0.480, 0.500, 0.520), 7800.0),
    "rubber": Material((0.055, 0.055, 0.060), 1200.0),
    "accent": Material((0.930, 0.520, 0.030), 2700.0),
    "black": Material((0.020, 0.020, 0.022), 1400.0),
    "glass": Material((0.030, 0.060, 0.110), 2500.0),
    "lamp": Material((0.960, 0.950, 0.860), 2500.0),
    "red": Material((0.700, 0.040, 0.030), 1400.0),
    "battery": Material(None, 2000.0),
    "drive": Material(None, 4500.0),
    "electronics": Material(None, 1000.0),
}
