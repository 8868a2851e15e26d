"""Whole beam lines."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Tuple, Union

from telex_control.common.params import require

from ...model import SceneObject
from ..object_type import ObjectType
from ..parameters import number, parameter
from ..shapes import along_bend, yawed
from .beam_parts import BEAM_HEIGHT
from .magnets import Cryostat, Dipole, Quadrupole
from .vacuum import BeamPipe, GateValve, VacuumPump

_Element = Union[BeamPipe, Dipole, Quadrupole, Cryostat, VacuumPump, GateValve]


_ELEMENTS: Dict[str, Tuple[Callable[[float], _Element], float]] = {
    "pipe": (lambda height: BeamPipe(height=height), 2.0),
    "short_pipe": (lambda height: BeamPipe(1.0, height=height, stands=1), 1.0),
    "dipole": (lambda height: Dipole(height=height), 2.4),
    "quadrupole": (lambda height: Quadrupole(height=height), 1.2),
    "cryostat": (lambda height: Cryostat(height=height), 5.0),
    "pump": (lambda height: VacuumPump(height=height), 0.5),
    "valve": (lambda height: GateValve(height=height), 0.4),
}
"""How each element of a beam line is made, and its length from flange to flange (m)."""


@dataclass(frozen=True)
class BeamLine(ObjectType):
    """Elements one behind the other along x, straight or in a bend, about its middle."""

    elements: Tuple[str, ...] = parameter(
        ("pipe", "pump", "dipole", "valve", "quadrupole", "pipe"),
        "pipe, short_pipe, dipole, quadrupole, cryostat, pump and valve, in their order along x.",
    )
    radius: float = number(
        0.0, "Of the bend (m): positive to the left, negative to the right, 0 for a straight line."
    )
    height: float = number(BEAM_HEIGHT, "Of the beam over the floor (m).", 0.7, 2.0)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            bool(self.elements) and set(self.elements) <= set(_ELEMENTS),
            f"elements is {list(self.elements)}; some of {', '.join(_ELEMENTS)} are needed",
        )
        length = self.length
        require(
            self.radius == 0.0 or abs(self.radius) >= length / math.pi,
            f"radius is {self.radius}; for {length:g} m of elements it must be 0, or at least"
            f" {length / math.pi:.1f} to either side",
        )

    @property
    def length(self) -> float:
        """Of all elements (m)."""
        return sum(_ELEMENTS[name][1] for name in self.elements)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        objects = []
        counts: Dict[str, int] = {}
        start = -0.5 * self.length
        for name in self.elements:
            make, length = _ELEMENTS[name]
            counts[name] = counts.get(name, 0) + 1
            (made,) = make(self.height).build(folder)
            x, y, heading = along_bend(start + 0.5 * length, 0.0, self.radius)
            called = f"{name}_{counts[name]}"
            objects.append(SceneObject(called, made.model, (x, y, 0.0), yawed(heading)))
            start += length
        return tuple(objects)


TYPES = {
    "beam_line": BeamLine,
}
