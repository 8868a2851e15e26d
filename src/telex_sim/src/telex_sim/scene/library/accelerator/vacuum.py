"""Vacuum system of an accelerator; the beam runs along x."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from ...model import SceneObject
from .. import materials as look
from ..object_type import ObjectType
from ..parameters import number
from ..shapes import LYING_X, box, cylinder, rod, seen_only, standing
from .beam_parts import BEAM_HEIGHT, flanged_pipe, saddle


@dataclass(frozen=True)
class BeamPipe(ObjectType):
    """Section of beam pipe with flanges, on stands."""

    length: float = number(2.0, "m.", 0.2, 20.0)
    radius: float = number(0.05, "m.", 0.01, 0.3)
    height: float = number(
        BEAM_HEIGHT, "Of the beam over the floor (m).", lambda own: 3.0 * own.radius, 3.0
    )
    stands: int = number(2, "How many carry it.", 0, 10)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        half = 0.5 * self.length
        parts = list(flanged_pipe(-half, half, self.radius, self.height))
        for index in range(self.stands):
            at = (index + 0.5) * self.length / self.stands - half
            parts.extend(saddle(at, self.height - self.radius, 2.6 * self.radius))
        return standing("pipe", tuple(parts))


@dataclass(frozen=True)
class SupportStand(ObjectType):
    """Stand with a saddle for a pipe."""

    height: float = number(0.9, "Of the saddle over the floor (m).", 0.2, 3.0)
    width: float = number(0.13, "Of the saddle (m).", 0.05, 1.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        return standing("stand", saddle(0.0, self.height, self.width))


@dataclass(frozen=True)
class VacuumPump(ObjectType):
    """Ion pump under a piece of beam pipe, with its cable."""

    height: float = number(BEAM_HEIGHT, "Of the beam over the floor (m).", 0.7, 3.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        h = self.height
        low = h - 0.42
        parts = (
            *flanged_pipe(-0.25, 0.25, 0.05, h),
            cylinder(0.04, 0.2, (0.0, 0.0, h - 0.12), look.STAINLESS),
            cylinder(0.075, 0.024, (0.0, 0.0, h - 0.19), look.STAINLESS),
            box((0.34, 0.22, 0.24), (0.0, 0.0, low + 0.08), look.STAINLESS),
            box((0.26, 0.30, 0.18), (0.0, 0.0, low + 0.08), look.GRAY_PAINT),
            *saddle(0.0, low, 0.19),
            *seen_only(
                (
                    cylinder(0.02, 0.06, (0.2, 0.0, low + 0.1), look.STEEL, LYING_X),
                    rod((0.23, 0.0, low + 0.1), (0.3, 0.0, 0.1), 0.009, look.RED_PAINT),
                    rod((0.3, 0.0, 0.1), (0.33, 0.12, 0.012), 0.009, look.RED_PAINT),
                    box((0.12, 0.302, 0.06), (0.0, 0.0, low + 0.1), look.WHITE),
                )
            ),
        )
        return standing("pump", parts)


@dataclass(frozen=True)
class GateValve(ObjectType):
    """Valve in the beam pipe, with its drive on top."""

    height: float = number(BEAM_HEIGHT, "Of the beam over the floor (m).", 0.4, 3.0)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        h = self.height
        parts = (
            *flanged_pipe(-0.2, 0.2, 0.05, h),
            box((0.07, 0.2, 0.34), (0.0, 0.0, h + 0.06), look.STAINLESS),
            box((0.09, 0.22, 0.03), (0.0, 0.0, h + 0.24), look.STAINLESS),
            cylinder(0.05, 0.26, (0.0, 0.0, h + 0.38), look.BLUE_PAINT),
            cylinder(0.056, 0.02, (0.0, 0.0, h + 0.504), look.DARK_STEEL),
            box((0.05, 0.08, 0.08), (0.06, 0.0, h + 0.36), look.BLACK),
            *saddle(0.0, h - 0.11, 0.16),
            box(
                (0.004, 0.012, 0.012),
                (0.087, 0.0, h + 0.38),
                look.plain(0.2, 0.95, 0.3, glow=0.9),
                solid=False,
            ),
        )
        return standing("valve", parts)


TYPES = {
    "beam_pipe": BeamPipe,
    "support_stand": SupportStand,
    "vacuum_pump": VacuumPump,
    "gate_valve": GateValve,
}
