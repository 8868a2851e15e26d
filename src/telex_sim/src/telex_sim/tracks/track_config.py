"""Configuration of the tracks of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Tuple

from telex_control.common.params import Declared, number, parameter, require, required

from .belt_drive import BeltDriveConfig

# Least and largest: no robot has others, of which squares and quotients overflow or vanish.
_FRICTION, _RADIUS, _YIELDING = (1e-6, 10.0), (1e-3, 10.0), (1.0, 1e9)


@dataclass(frozen=True)
class Grip(Declared):
    """Friction coefficients of the belts on one material, of a surface with friction 1."""

    friction: float = number(required, "Along the belt.", maximum=10.0, above=0.0)
    lateral_friction: float = number(required, "Across the belt.", maximum=10.0, above=0.0)


@dataclass(frozen=True)
class TrackConfig(Declared):
    """Tracks; see `telex_sim.tracks`."""

    belts: Dict[str, float] = parameter(
        dict,
        "Belt joint and its drive radius (m). The track's shape is the collision shape "
        "of the link that carries the joint.",
    )
    drives: Dict[str, Tuple[str, ...]] = parameter(
        dict,
        "Motors, and the belt joints on the shaft of each. A belt in none of them has "
        "one of its own.",
    )
    drive: BeltDriveConfig = parameter(BeltDriveConfig, "Each motor.")
    friction: float = number(
        1.0,
        "Friction coefficient along the belt, on a surface with friction 1; with any "
        "other, it is the product.",
        *_FRICTION,
    )
    lateral_friction: float = number(0.7, "Across the belt.", *_FRICTION)
    materials: Dict[str, Grip] = parameter(
        dict,
        "In place of these two, by what the surface looks to be made of (see "
        "`telex_sim.scene.model.Surface.material`).",
    )
    side_friction: float = number(0.6, "Of the belt's flanks, in every direction.", *_FRICTION)
    edge_grip: float = number(
        1.2, "Factor on the friction along the belt where its cleats catch an edge.", 1.0, 10.0
    )
    stiffness: float = number(
        1.0e5, "Of a stuck track against the ground (N/m), each track.", *_YIELDING
    )
    damping: float = number(
        1500.0, "Of a stuck track against the ground (N s/m), each track.", *_YIELDING
    )
    contact_stiffness: float = number(
        1.0e5, "Of the contact normal to the surface (N/m).", *_YIELDING
    )
    contact_damping: float = number(
        6.0e3, "Of the contact normal to the surface (N s/m).", *_YIELDING
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        for name, radius in self.belts.items():
            require(
                _RADIUS[0] <= radius <= _RADIUS[1],
                f"belts/{name} is {radius} m; a radius of {_RADIUS[0]:g} to {_RADIUS[1]:g} m is "
                "needed",
            )
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
