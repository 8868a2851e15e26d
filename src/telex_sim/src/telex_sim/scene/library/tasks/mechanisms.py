"""Valves, levers, connectors: what is turned, switched and plugged.

They look towards -x, as everything mounted (`telex_sim.scene.library.tasks.mounts`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from telex_control.common.geometry.quaternions import rotate
from telex_control.common.params import require, require_range

from ...model import Detents, Joint, Link, Motion, ObjectModel, SceneObject, Vector3
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, kilograms, number, parameter
from ..shapes import (
    LYING_X,
    LYING_Y,
    TOWARDS_US,
    Parts,
    beam,
    box,
    cylinder,
    placed,
    ring,
    rod,
    seen_only,
    sphere,
    staves,
    touched_only,
    yawed,
)
from .mounts import MOUNTS, PLATE, SEATED, mount


@dataclass(frozen=True)
class Valve(ObjectType):
    """Valve with a hand wheel or a lever on a pipe, which turns against friction."""

    radius: float = number(
        0.1, "Of the wheel's ring, or from the axis to the end of the lever (m).", 0.05, 0.5
    )
    height: float = number(0.8, "Of the wheel's middle over the floor (m).", 0.15, 2.5)
    facing: str = choice(
        "front", ("front", "up"), "front: the wheel looks towards -x; up: it lies level."
    )
    friction: float = number(5.0, "Torque below which it does not turn (N m).", 0.0)
    turns: float = number(4.0, "How many it has from the middle to either end.", 0.1, 100.0)
    start: float = number(
        0.0,
        "Angle at the start (rad).",
        lambda own: -2.0 * math.pi * own.turns,
        lambda own: 2.0 * math.pi * own.turns,
    )
    handle: str = choice("wheel", ("wheel", "lever"))

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.height >= self.radius + 0.05,
            f"height is {self.height}; a wheel of radius {self.radius} needs at least"
            f" {self.radius + 0.05:g}",
        )

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        front = self.facing == "front"
        centre: Vector3 = (-0.16, 0.0, self.height) if front else (0.0, 0.0, self.height)
        wheel = Joint(
            "wheel_hinge",
            Motion.HINGE,
            "body",
            "wheel",
            position=centre,
            orientation=TOWARDS_US if front else (0.0, 0.0, 0.0, 1.0),
            lower=-2.0 * math.pi * self.turns,
            upper=2.0 * math.pi * self.turns,
            start=self.start,
            friction=self.friction,
            damping=0.05,
        )
        body = self._body_in_front() if front else self._body_below()
        handle = self._wheel() if self.handle == "wheel" else self._lever()
        links = (Link("body", 0.0, body), Link("wheel", 2.0, handle))
        return single(ObjectModel(links, (wheel,), static=True))

    def _lever(self) -> Parts:
        """Flat bar from the axis along x, in the plane z = 0."""
        hub, bar = 0.02, (self.radius, 0.025, 0.025)
        return (
            cylinder(hub, 0.05, (0.0, 0.0, -0.01), look.RED_PAINT),
            box(bar, (0.5 * self.radius, 0.0, 0.0), look.RED_PAINT),
            cylinder(0.012, 0.012, (0.0, 0.0, 0.02), look.STEEL, solid=False),
        )

    def _wheel(self) -> Parts:
        """Wheel about z, the ring in the plane z = 0."""
        r = self.radius
        bar = max(0.022, 0.25 * r)
        count = 16
        rim = tuple(
            beam(
                rotate(yawed(2.0 * math.pi * index / count), (r, 0.0, 0.0)),
                rotate(yawed(2.0 * math.pi * (index + 1) / count), (r, 0.0, 0.0)),
                0.8 * bar,
                0.8 * bar,
                None,
            )
            for index in range(count)
        )
        spokes = tuple(
            beam(
                rotate(yawed(angle), (-r, 0.0, 0.0)),
                rotate(yawed(angle), (r, 0.0, 0.0)),
                0.022,
                0.022,
                look.RED_PAINT,
            )
            for angle in (0.25 * math.pi, 0.75 * math.pi)
        )
        return (
            *touched_only(rim),
            ring(r, (0.0, 0.0, 0.0), look.RED_PAINT),
            *spokes,
            cylinder(0.028, 0.05, (0.0, 0.0, -0.01), look.RED_PAINT),
            cylinder(0.012, 0.012, (0.0, 0.0, 0.02), look.STEEL, solid=False),
            # Shows how far it has turned.
            sphere(0.009, (r, 0.0, 0.11 * r), look.WHITE, solid=False),
        )

    def _body_in_front(self) -> Parts:
        h = self.height
        return (
            cylinder(0.05, h + 0.35, (0.0, 0.0, 0.5 * (h + 0.35)), look.GREEN_PAINT),
            *(
                cylinder(0.09, 0.02, (0.0, 0.0, at), look.GREEN_PAINT)
                for at in (0.01, h - 0.13, h - 0.108, h + 0.108, h + 0.13, h + 0.34)
                if at >= 0.01
            ),
            sphere(0.085, (0.0, 0.0, h), look.GREEN_PAINT),
            cylinder(0.035, 0.06, (-0.09, 0.0, h), look.GREEN_PAINT, LYING_X),
            cylinder(0.012, 0.06, (-0.125, 0.0, h), look.STAINLESS, LYING_X, solid=False),
        )

    def _body_below(self) -> Parts:
        h = self.height
        pipe = max(h - 0.28, 0.06)
        return (
            cylinder(0.05, 0.7, (0.0, 0.0, pipe), look.GREEN_PAINT, LYING_X),
            *(
                cylinder(0.09, 0.02, (at, 0.0, pipe), look.GREEN_PAINT, LYING_X)
                for at in (-0.34, -0.13, -0.108, 0.108, 0.13, 0.34)
                if pipe > 0.09
            ),
            sphere(0.085, (0.0, 0.0, pipe), look.GREEN_PAINT, solid=pipe > 0.085),
            cylinder(0.035, 0.1, (0.0, 0.0, pipe + 0.09), look.GREEN_PAINT),
            rod((0.0, 0.0, pipe), (0.0, 0.0, h - 0.036), 0.012, look.STAINLESS, solid=False),
            *(
                box((0.06, 0.08, pipe), (side * 0.25, 0.0, 0.5 * pipe), look.DARK_STEEL)
                for side in (-1.0, 1.0)
            ),
        )


@dataclass(frozen=True)
class Lever(ObjectType):
    """Switch with a lever that swings up and down between notches."""

    height: float = number(0.8, "Of the pivot over the floor (m).", 0.2, 2.5)
    length: float = number(0.16, "From the pivot to the knob (m).", 0.08, 0.6)
    notches: Tuple[float, ...] = parameter(
        (-0.7, 0.7), "Angles at which it rests (rad), rising; level is 0, up is positive."
    )
    start: float = parameter(-0.7, "Angle at the start (rad).")
    notch_torque: float = number(3.0, "What a notch resists (N m).", 0.0, 100.0)
    friction: float = number(1.0, "Between the notches (N m).", 0.0, 100.0)
    mounting: str = choice("stand", MOUNTS)

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        rising = all(a < b for a, b in zip(self.notches, self.notches[1:]))
        require(
            len(self.notches) >= 2 and rising and max(map(abs, self.notches)) <= 1.2,
            f"notches is {list(self.notches)}; at least two rising angles from -1.2 to 1.2 are"
            " needed",
        )
        require_range(self, "start", self.notches[0], self.notches[-1])

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        narrowest = min(b - a for a, b in zip(self.notches, self.notches[1:]))
        hinge = Joint(
            "lever_hinge",
            Motion.HINGE,
            "housing",
            "lever",
            position=(-PLATE - 0.06, 0.0, self.height),
            axis=(0.0, 1.0, 0.0),
            lower=self.notches[0] - 0.02,
            upper=self.notches[-1] + 0.02,
            start=self.start,
            friction=self.friction,
            damping=0.05,
            detents=(
                Detents(self.notches, self.notch_torque, min(0.15, 0.4 * narrowest))
                if self.notch_torque > 0.0
                else None
            ),
        )
        links = (Link("housing", 0.0, self._housing()), Link("lever", 0.5, self._lever()))
        return single(ObjectModel(links, (hinge,), static=True))

    def _housing(self) -> Parts:
        h = self.height
        depth = 0.07
        cheeks = tuple(
            box((depth, 0.03, 0.16), (-PLATE - 0.5 * depth, side * 0.04, h), look.GRAY_PAINT)
            for side in (-1.0, 1.0)
        )
        marks = tuple(
            box(
                (0.001, 0.024, 0.012),
                (-PLATE - 0.0005, 0.085, h + 0.12 * math.sin(angle)),
                look.GREEN_PAINT if angle == self.notches[-1] else look.RED_PAINT,
                solid=False,
            )
            for angle in self.notches
        )
        return (
            *mount(self.mounting, h, 0.24, 0.34, look.YELLOW_PAINT),
            *cheeks,
            cylinder(0.02, 0.13, (-PLATE - 0.06, 0.0, h), look.STEEL, LYING_Y, solid=False),
            *marks,
        )

    def _lever(self) -> Parts:
        return (
            box((self.length, 0.022, 0.022), (-0.5 * self.length, 0.0, 0.0), look.STEEL),
            sphere(0.024, (-self.length, 0.0, 0.0), look.RED_PAINT),
        )


@dataclass(frozen=True)
class Connector(ObjectType):
    """Plug in a socket, which a latch holds until it is pulled."""

    height: float = number(0.8, "Of the socket over the floor (m).", 0.15, 2.5)
    radius: float = number(0.022, "Of the socket's hole (m).", 0.01, 0.1)
    clearance: float = number(
        0.0025,
        "Gap round the plug (m); 0.002 to 0.005 is usual.",
        0.0005,
        lambda own: 0.5 * own.radius,
    )
    hold: float = number(60.0, "Pull at which the plug comes out (N).", 0.0, 1000.0)
    mass: float = kilograms(0.4, "Of the plug (kg).")
    mounting: str = choice("stand", MOUNTS)

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        latch = Joint(
            "latch",
            Motion.LATCH,
            "socket",
            "plug",
            position=(-PLATE - _SOCKET, 0.0, self.height),
            orientation=TOWARDS_US,
            hold=self.hold,
            across=SEATED,
        )
        links = (Link("socket", 0.0, self._socket()), Link("plug", self.mass, self._plug()))
        return single(ObjectModel(links, (latch,), static=True))

    def _socket(self) -> Parts:
        r, h = self.radius, self.height
        shell = staves(r, r + 0.008, _SOCKET, 8, look.DARK_STEEL)
        at = (-PLATE - 0.5 * _SOCKET, 0.0, h)
        return (
            *mount(self.mounting, h, 0.2, 0.2, look.GRAY_PAINT),
            *placed(shell, at, TOWARDS_US),
            *seen_only(
                (
                    cylinder(r, 0.002, (-PLATE - 0.001, 0.0, h), look.BLACK, LYING_X),
                    *(
                        cylinder(
                            0.006, 0.006, (-PLATE, y * 0.08, h + z * 0.08), look.STEEL, LYING_X
                        )
                        for y in (-1.0, 1.0)
                        for z in (-1.0, 1.0)
                    ),
                )
            ),
        )

    def _plug(self) -> Parts:
        """Plug that points along -z; z = 0 is the rim of the socket."""
        r = self.radius - self.clearance
        peg = _SOCKET - 0.006
        collar = 0.012
        grip = 0.09
        return (
            cylinder(r, peg + 0.001, (0.0, 0.0, 0.5 * (0.001 - peg)), look.ALUMINIUM),
            cylinder(self.radius + 0.012, collar, (0.0, 0.0, 0.001 + 0.5 * collar), look.ORANGE),
            box((0.05, 0.03, grip), (0.0, 0.0, 0.001 + collar + 0.5 * grip), look.RUBBER),
            *seen_only(
                (
                    *(
                        box((0.052, 0.031, 0.006), (0.0, 0.0, 0.03 + step * 0.018), look.BLACK)
                        for step in range(4)
                    ),
                    # What is left of its cable.
                    cylinder(0.011, 0.03, (0.0, 0.0, 0.113), look.BLACK),
                    rod((0.0, 0.0, 0.125), (-0.05, 0.0, 0.155), 0.008, look.ORANGE),
                    sphere(0.008, (-0.05, 0.0, 0.155), look.ORANGE),
                    rod((-0.05, 0.0, 0.155), (-0.12, 0.0, 0.155), 0.008, look.ORANGE),
                )
            ),
        )


_SOCKET = 0.045
"""Depth of a socket (m)."""

TYPES = {"valve": Valve, "lever": Lever, "connector": Connector}
