"""Configuration of the tracks of a robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Tuple

from telex_control.common.params import require, require_range

from .belt_drive import BeltDriveConfig


@dataclass(frozen=True)
class Grip:
    """Friction coefficients of the belts on one material, of a surface with friction 1.

    Attributes
    ----------
    friction, lateral_friction : float
        Along and across the belt.
    """

    friction: float
    lateral_friction: float

    def __post_init__(self) -> None:
        for name in ("friction", "lateral_friction"):
            require_range(self, name, maximum=10.0, above=0.0)


@dataclass(frozen=True)
class TrackConfig:
    """Tracks; see `telex_sim.tracks`.

    Attributes
    ----------
    belts : dict of str to float
        Belt joint and its drive radius (m). The track's shape is the collision shape of the
        link that carries the joint.
    drives : dict of str to tuple of str
        Motors, and the belt joints on the shaft of each. A belt in none of them has one of its
        own.
    drive : BeltDriveConfig
        Each motor.
    friction : float
        Friction coefficient along the belt, on a surface with friction 1; with any other, it is
        the product.
    lateral_friction : float
        Across the belt.
    materials : dict of str to Grip
        In place of these two, by what the surface looks to be made of (see
        `telex_sim.scene.model.Surface.material`).
    side_friction : float
        Of the belt's flanks, in every direction.
    edge_grip : float
        Factor on the friction along the belt where its cleats catch an edge.
    stiffness, damping : float
        Of a stuck track against the ground (N/m, N s/m), each track.
    contact_stiffness, contact_damping : float
        Of the contact normal to the surface (N/m, N s/m).
    """

    belts: Dict[str, float] = field(default_factory=dict)
    drives: Dict[str, Tuple[str, ...]] = field(default_factory=dict)
    drive: BeltDriveConfig = field(default_factory=BeltDriveConfig)
    friction: float = 1.0
    lateral_friction: float = 0.7
    materials: Dict[str, Grip] = field(default_factory=dict)
    side_friction: float = 0.6
    edge_grip: float = 1.2
    stiffness: float = 1.0e5
    damping: float = 1500.0
    contact_stiffness: float = 1.0e5
    contact_damping: float = 6.0e3

    def __post_init__(self) -> None:
        for name, radius in self.belts.items():
            require(radius > 0.0, f"belts/{name} is {radius} m; a radius above 0 is needed")
        for name in (
            "friction",
            "lateral_friction",
            "side_friction",
            "stiffness",
            "damping",
            "contact_stiffness",
            "contact_damping",
        ):
            value = getattr(self, name)
            require(value > 0.0, f"{name} is {value}; it must be above 0")
        require_range(self, "edge_grip", 1.0, 10.0)
        owners: Dict[str, str] = {}
        for drive, belts in self.drives.items():
            require(bool(belts), f"drives/{drive} is []; it needs a belt joint at least")
            for belt in belts:
                require(
                    belt in self.belts,
                    f"drives/{drive}: '{belt}' is not one of belts; there are: "
                    f"{', '.join(self.belts) or 'none'}",
                )
                require(
                    belt not in owners,
                    f"drives/{drive}: '{belt}' is in drives/{owners.get(belt)} already",
                )
                owners[belt] = drive

    def grip(self, material: str) -> Tuple[float, float]:
        """Friction coefficients along and across the belt on a material."""
        found = self.materials.get(material)
        if found is None:
            return self.friction, self.lateral_friction
        return found.friction, found.lateral_friction

    def groups(self) -> List[Tuple[str, ...]]:
        """Belts of each motor."""
        driven = {belt for belts in self.drives.values() for belt in belts}
        return [*self.drives.values(), *((belt,) for belt in self.belts if belt not in driven)]
