"""A source to be fetched, the pot that it goes into, and a monitor of radiation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Tuple

from telex_control.common.params import require

from ....radiation.nuclides import NUCLIDES
from ...model import MOST_ACTIVE, Joint, Link, Motion, ObjectModel, Part, SceneObject, Source
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, kilograms, number, parameter
from ..shapes import (
    Parts,
    box,
    cylinder,
    placed,
    rod,
    seen_only,
    sheet,
    sphere,
    standing,
    staves,
    tube,
)

_LID = 0.035
_LID_MASS = 4.0
_LID_OPEN = math.radians(105.0)


@dataclass(frozen=True)
class SourceContainer(ObjectType):
    """Pot of lead with a lid; the lid lies on it freely, or swings on a hinge."""

    radius: float = number(0.13, "Outside, without the lid (m).", 0.05, 1.0)
    height: float = number(0.28, "Outside, without the lid (m).", 0.05, 1.0)
    hole: float = number(0.07, "Radius of the space inside (m).", 0.02)
    lid: str = choice("free", ("free", "hinged", "none"))
    lid_angle: float = number(0.0, "Of a hinged lid at the start (rad).", 0.0, _LID_OPEN)
    mass: float = kilograms(60.0, "Of the pot (kg).")
    static: bool = parameter(True, "Whether it stands fast; a hinged lid needs that.")

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.hole <= 0.75 * self.radius,
            f"hole is {self.hole}; in a pot of radius {self.radius} it can be at most"
            f" {0.75 * self.radius:g}",
        )
        require(
            self.static or self.lid != "hinged", "static is False; a hinged lid needs a static pot"
        )
        require(
            self.lid == "hinged" or not self.lid_angle,
            f"lid_angle is {self.lid_angle}; the lid is {self.lid}, and only a hinged one has it",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        pot = Link("pot", self.mass, self._pot())
        if self.lid == "hinged":
            # The hinge lies in the lid's lower face, behind the pot.
            behind = self.radius + 0.02
            hinge = Joint(
                "lid_hinge",
                Motion.HINGE,
                "pot",
                "lid",
                position=(behind, 0.0, self.height),
                axis=(0.0, 1.0, 0.0),
                upper=_LID_OPEN,
                start=self.lid_angle,
                friction=0.3,
                damping=0.1,
            )
            strap = box((0.05, 0.06, 0.012), (self.radius, 0.0, 0.5 * _LID), look.STEEL)
            parts = placed((*self._lid(), strap), (-behind, 0.0, 0.0))
            return single(ObjectModel((pot, Link("lid", _LID_MASS, parts)), (hinge,), static=True))
        objects = [SceneObject("pot", ObjectModel((pot,), static=self.static))]
        if self.lid == "free":
            # A plug under the lid keeps it on the hole.
            depth = 0.02
            plug = cylinder(self.hole - 0.004, depth, (0.0, 0.0, -0.5 * depth), look.LEAD)
            parts = (*self._lid(), *_of_lead(plug))
            lid = ObjectModel((Link("lid", _LID_MASS, parts),))
            objects.append(SceneObject("lid", lid, (0.0, 0.0, self.height)))
        return tuple(objects)

    def _pot(self) -> Parts:
        r, h = self.radius, self.height
        bottom = 0.2 * h
        deep = h - bottom
        middle = (0.0, 0.0, bottom + 0.5 * deep)
        # The tubes' walls are a fifth of their radius: as many as reach the hole.
        linings = []
        outer = 0.8 * r
        while outer > 1.25 * self.hole:
            linings.append(tube(outer, deep - 0.002, middle, look.LEAD))
            outer *= 0.8
        linings.append(tube(1.25 * self.hole, deep - 0.002, middle, look.LEAD))
        edge = 0.55 * h
        label = look.picture("sign?text=RADIOACTIVE&symbol=radiation")
        return (
            *_of_lead(
                cylinder(r, bottom, (0.0, 0.0, 0.5 * bottom), look.YELLOW_PAINT),
                *placed(staves(self.hole, r, deep, 16), middle),
            ),
            tube(r, deep, middle, look.YELLOW_PAINT),
            *linings,
            *seen_only(
                (
                    cylinder(self.hole, 0.002, (0.0, 0.0, bottom + 0.001), look.STEEL),
                    cylinder(1.012 * r, 0.02, (0.0, 0.0, 0.01), look.BLACK),
                    box((0.004, edge + 0.01, edge + 0.01), (-r, 0.0, 0.5 * h), look.ALUMINIUM),
                    sheet(edge, edge, (-r - 0.002, 0.0, 0.5 * h), label),
                    *(
                        box((0.1, 0.02, 0.025), (0.0, side * (r + 0.01), 0.7 * h), look.STEEL)
                        for side in (-1.0, 1.0)
                    ),
                )
            ),
        )

    def _lid(self) -> Parts:
        """Lid with a bar to grip, its lower face at z = 0."""
        r = self.radius
        bar, free = 0.025, 0.05
        return (
            *_of_lead(cylinder(r, _LID, (0.0, 0.0, 0.5 * _LID), look.YELLOW_PAINT)),
            cylinder(1.004 * r, 0.01, (0.0, 0.0, 0.5 * _LID), look.BLACK, solid=False),
            box((bar, 0.14, bar), (0.0, 0.0, _LID + free + 0.5 * bar), look.STEEL),
            *(
                box(
                    (bar, bar, free + bar),
                    (0.0, side * (0.07 + 0.5 * bar), _LID + 0.5 * (free + bar)),
                    look.STEEL,
                )
                for side in (-1.0, 1.0)
            ),
        )


def _of_lead(*parts: Part) -> Parts:
    return tuple(replace(part, shield="lead") for part in parts)


@dataclass(frozen=True)
class SourceCapsule(ObjectType):
    """Sealed source: a steel capsule with a knob to grip, standing; a dummy without activity."""

    radius: float = number(0.02, "Of the capsule, without its knob (m).", 0.005, 0.2)
    length: float = number(0.09, "Of the capsule, without its knob (m).", 0.02, 0.5)
    mass: float = kilograms(0.4)
    nuclide: str = choice("Co-60", tuple(NUCLIDES))
    activity: float = number(
        0.0, "Of the nuclide, in the capsule's middle (Bq); 0: it is a dummy.", 0.0, MOST_ACTIVE
    )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        r, length = self.radius, self.length
        parts = (
            cylinder(r, length, (0.0, 0.0, 0.5 * length), look.STAINLESS),
            cylinder(0.35 * r, 0.6 * r, (0.0, 0.0, length + 0.3 * r), look.STAINLESS),
            sphere(0.7 * r, (0.0, 0.0, length + 1.1 * r), look.STAINLESS),
            *seen_only(
                (
                    cylinder(1.01 * r, 0.2 * length, (0.0, 0.0, 0.7 * length), look.YELLOW_PAINT),
                    cylinder(1.01 * r, 0.06 * length, (0.0, 0.0, 0.3 * length), look.RED_PAINT),
                )
            ),
        )
        source = None
        if self.activity:
            source = Source(self.nuclide, self.activity, (0.0, 0.0, 0.5 * length))
        link = Link("capsule", self.mass, parts, rolling_friction=0.0005, source=source)
        return single(ObjectModel((link,)))


@dataclass(frozen=True)
class IonisationChamber(ObjectType):
    """Monitor of radiation on a tripod."""

    height: float = number(1.1, "Of the chamber's middle over the floor (m).", 0.5, 3.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        h = self.height
        legs = []
        for index in range(3):
            angle = 2.0 * math.pi * index / 3 + 0.3
            foot = (0.26 * math.cos(angle), 0.26 * math.sin(angle), 0.012)
            legs.append(rod(foot, (0.0, 0.0, 0.45 * h), 0.011, look.ALUMINIUM))
        parts = (
            *legs,
            rod((0.0, 0.0, 0.4 * h), (0.0, 0.0, h - 0.16), 0.016, look.ALUMINIUM),
            cylinder(0.09, 0.32, (0.0, 0.0, h), look.YELLOW_PAINT),
            *seen_only(
                (
                    cylinder(0.092, 0.03, (0.0, 0.0, h - 0.1), look.BLACK),
                    cylinder(0.092, 0.03, (0.0, 0.0, h + 0.1), look.BLACK),
                    cylinder(0.06, 0.03, (0.0, 0.0, h + 0.175), look.DARK_STEEL),
                    cylinder(0.02, 0.05, (0.0, 0.0, h + 0.21), look.STEEL),
                    box((0.01, 0.05, 0.05), (-0.088, 0.0, h), look.WHITE),
                )
            ),
        )
        return standing("chamber", parts)


TYPES = {
    "source_container": SourceContainer,
    "source_capsule": SourceCapsule,
    "ionisation_chamber": IonisationChamber,
}
