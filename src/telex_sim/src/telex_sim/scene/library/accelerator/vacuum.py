"""Vacuum system of an accelerator; the beam runs along x."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

from telex_control.common.params import require

from ...model import Leak, Link, ObjectModel, SceneObject
from ...sealed import seed_of
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import number, token
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


_NUMBER = (0.09, 0.06)
"""Width and height of a flange's number (m)."""
_LITRE = 1.0e-3  # m3
_MINUTE = 60.0  # s


@dataclass(frozen=True)
class FlangeLine(ObjectType):
    """Pipe of sections along x, whose flanges are numbered from -x on, on stands; one may leak."""

    flanges: int = number(8, "How many.", 1, 20)
    spacing: float = number(0.7, "Between flanges (m).", 0.3, 5.0)
    radius: float = number(0.05, "m.", 0.02, 0.2)
    height: float = number(
        BEAM_HEIGHT, "Of the pipe over the floor (m).", lambda own: 3.0 * own.radius, 3.0
    )
    leak: int = number(0, "Number of the flange that leaks, on its top; 0: none does.", 0, 20)
    sealed: str = token(
        "A token in place of the number, which tells nobody which; see `scene.sealed`."
    )
    flow: float = number(1.2, "Of the leak (l/min).", 0.001, 1000.0)
    drift: float = number(0.1, "Of the air around it, along x (m/s).", -5.0, 5.0)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.leak <= self.flanges,
            f"leak is {self.leak}; there are {self.flanges} flanges, and 0 stands for no leak",
        )

    def leaking(self) -> int:
        """Return the number of the flange that leaks, from 1; 0: none."""
        return 1 + seed_of(self.sealed) % self.flanges if self.sealed else self.leak

    def places(self) -> List[float]:
        """Where the flanges are along x (m)."""
        middle = 0.5 * (self.flanges - 1)
        return [(index - middle) * self.spacing for index in range(self.flanges)]

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        h, r = self.height, self.radius
        parts: List = []
        ends = [at - 0.5 * self.spacing for at in self.places()]
        ends.append(ends[-1] + self.spacing)
        parts.append(
            cylinder(
                r, ends[-1] - ends[0], (0.5 * (ends[0] + ends[-1]), 0.0, h), look.STAINLESS, LYING_X
            )
        )
        for index, at in enumerate(self.places()):
            parts.append(cylinder(1.75 * r, 0.048, (at, 0.0, h), look.STAINLESS, LYING_X))
            text = look.picture(f"label?text={index + 1}&aspect={_NUMBER[0] / _NUMBER[1]:g}")
            for side in (-1.0, 1.0):
                middle = (at, side * (1.75 * r + 0.002), h + 1.75 * r + 0.5 * _NUMBER[1])
                parts.append(box((_NUMBER[0], 0.002, _NUMBER[1]), middle, text, solid=False))
        for at in ends[1:-1:2] if self.flanges > 1 else [0.25 * self.spacing]:
            parts.extend(saddle(at, h - r, 2.6 * r))
        leak = None
        if self.leaking():
            place = (self.places()[self.leaking() - 1], 0.0, h + 1.75 * r)
            leak = Leak(self.flow * _LITRE / _MINUTE, place, (self.drift, 0.0, 0.0))
        return single(ObjectModel((Link("pipe", 0.0, tuple(parts), leak=leak),), static=True))


TYPES = {
    "beam_pipe": BeamPipe,
    "flange_line": FlangeLine,
    "support_stand": SupportStand,
    "vacuum_pump": VacuumPump,
    "gate_valve": GateValve,
}
