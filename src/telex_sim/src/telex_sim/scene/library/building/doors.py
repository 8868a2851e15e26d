"""Doors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

from telex_control.common.params import require

from ...model import (
    Closer,
    Detents,
    Joint,
    Link,
    Motion,
    ObjectModel,
    SceneObject,
    Surface,
    Vector3,
)
from .. import materials as look
from ..object_type import ObjectType, single
from ..parameters import choice, kilograms, number, parameter, rgb
from ..shapes import LYING_X, Parts, box, cylinder, opaque, placed, seen_only

_SILL = 0.01
"""Gap under the leaf (m)."""
_GAP = 0.004
"""Gap round the leaf (m)."""
_THICKNESS = 0.04
_POST = 0.08
_PANE_FROM = 1.25
"""Height of the pane's lower edge (m)."""
_LEAST_PANE = 0.05
"""A leaf without room for a pane of this height has none (m)."""
_HANDLE_HEIGHT = 1.02
_HANDLE_INSET = 0.07
_SPRING = 0.6
"""Torque that lifts the handle back, and what each further radian adds (N m, N m/rad)."""


@dataclass(frozen=True)
class Door(ObjectType):
    """Door in its frame, across x, with a handle on both sides and a closer."""

    width: float = number(0.95, "Of the opening (m).", 0.4, 2.0)
    height: float = number(2.0, "Of the opening (m).", 1.3, 4.0)
    mass: float = kilograms(25.0, "Of the leaf (kg).")
    hinges: str = choice("left", ("left", "right"), "left or right, seen along x.")
    opening: str = choice("push", ("push", "pull"), "push or pull, for who comes along x.")
    angle: float = number(1.75, "How far it opens (rad).", 0.3, 3.0)
    start: float = number(0.0, "Angle at the start (rad).", 0.0, lambda own: own.angle)
    closer_torque: float = number(
        4.0, "Torque that closes it when it is nearly shut (N m); 0: no closer.", 0.0, 1000.0
    )
    closer_stiffness: float = number(6.0, "What each radian adds to it (N m/rad).", 0.0, 1000.0)
    damping: float = number(25.0, "Of the closer (N m s/rad).", 0.0, 1000.0)
    latch_torque: float = number(
        6.0, "What the latch resists when the door is shut (N m).", 0.0, 1000.0
    )
    friction: float = number(0.5, "Of the hinges (N m).", 0.0, 1000.0)
    frame_depth: float = number(0.14, "Along x (m).", 0.05, 1.0)
    window: bool = parameter(True, "A pane of glass at the height of the eyes.")
    color: Vector3 = rgb((0.30, 0.42, 0.50))

    def check(self) -> None:
        """Check what concerns several parameters; see `Declared.check`."""
        require(
            self.damping <= 500.0,
            f"damping is {self.damping}; above 500 the door would shake in steps of 2 ms",
        )

    @property
    def _left(self) -> float:
        """1 when the hinges are on the left (y > 0), else -1."""
        return 1.0 if self.hinges == "left" else -1.0

    @property
    def _away(self) -> float:
        """1 when the leaf swings towards x, else -1."""
        return 1.0 if self.opening == "push" else -1.0

    def build(self, folder: Path) -> Tuple[SceneObject, ...]:
        """Make it; see `ObjectType.build`."""
        # The axis lies in the face of the leaf on the side to which it opens, as real hinges do:
        # so the leaf's edge does not turn into the post.
        axis = self._left * self._away
        closer = Closer(self.closer_torque, self.closer_stiffness)
        leaf = Joint(
            "leaf_hinge",
            Motion.HINGE,
            "frame",
            "leaf",
            position=(self._away * 0.5 * _THICKNESS, self._left * 0.5 * self.width, 0.0),
            axis=(0.0, 0.0, axis),
            upper=self.angle,
            start=self.start,
            friction=self.friction,
            damping=self.damping,
            closer=closer if self.closer_torque > 0.0 or self.closer_stiffness > 0.0 else None,
            detents=Detents((0.0,), self.latch_torque, 0.03) if self.latch_torque > 0.0 else None,
        )
        handle = Joint(
            "handle_hinge",
            Motion.HINGE,
            "leaf",
            "handle",
            position=(
                -self._away * 0.5 * _THICKNESS,
                -self._left * (self.width - _HANDLE_INSET),
                _HANDLE_HEIGHT,
            ),
            # Pressed down, it turns by a positive angle.
            axis=(-self._left, 0.0, 0.0),
            upper=math.radians(45.0),
            friction=0.1,
            damping=0.02,
            closer=Closer(_SPRING, _SPRING),
        )
        links = (
            Link("frame", 0.0, self._frame()),
            Link("leaf", self.mass, self._leaf()),
            Link("handle", 0.6, self._handle()),
        )
        return single(ObjectModel(links, (leaf, handle), static=True))

    def _frame(self) -> Parts:
        paint = look.LIGHT_PAINT
        depth, high = self.frame_depth, self.height
        outer = self.width + 2.0 * _POST
        parts = [
            box((depth, outer, _POST), (0.0, 0.0, high + 0.5 * _POST), paint),
            *(
                box(
                    (depth, _POST, high),
                    (0.0, side * 0.5 * (self.width + _POST), 0.5 * high),
                    paint,
                )
                for side in (-1.0, 1.0)
            ),
        ]
        # The rebate that the leaf falls against lies on the side from which it opens.
        at = -self._away * (0.5 * _THICKNESS + 0.012)
        rebate = [
            box((0.02, self.width, 0.02), (at, 0.0, high - 0.01), paint),
            *(
                box((0.02, 0.02, high), (at, side * (0.5 * self.width - 0.01), 0.5 * high), paint)
                for side in (-1.0, 1.0)
            ),
        ]
        hinges = [
            cylinder(
                0.012,
                0.1,
                (
                    self._away * (0.5 * _THICKNESS + 0.004),
                    self._left * 0.5 * self.width,
                    share * high,
                ),
                look.STAINLESS,
            )
            for share in (0.1, 0.5, 0.9)
        ]
        return (*parts, *seen_only((*rebate, *hinges)))

    def _leaf(self) -> Parts:
        """Leaf about its hinge: its free edge lies towards -y with hinges on the left."""
        wide, high = self.width - 2.0 * _GAP, self.height - _SILL - _GAP
        middle = (-self._away * 0.5 * _THICKNESS, -self._left * 0.5 * self.width, 0.0)
        paint = Surface(opaque(self.color), "generated:painted_metal", 1.0)
        solid = box((_THICKNESS, wide, high), (0.0, 0.0, _SILL + 0.5 * high))
        pane_to = min(_PANE_FROM + 0.55, _SILL + high - 0.12)
        if self.window and pane_to - _PANE_FROM >= _LEAST_PANE:
            shown = self._glazed(wide, high, pane_to, paint)
        else:
            shown = (box((_THICKNESS, wide, high), (0.0, 0.0, _SILL + 0.5 * high), paint),)
        kick = box(
            (_THICKNESS + 0.004, wide - 0.06, 0.22), (0.0, 0.0, _SILL + 0.14), look.STAINLESS
        )
        plate_at = -self._left * (0.5 * self.width - _HANDLE_INSET)
        plate = box(
            (_THICKNESS + 0.006, 0.045, 0.2), (0.0, plate_at, _HANDLE_HEIGHT - 0.03), look.STAINLESS
        )
        closer = box(
            (_THICKNESS + 0.05, 0.22, 0.05),
            (self._away * 0.02, self._left * 0.25 * wide, self.height - 0.07),
            look.ALUMINIUM,
        )
        return placed((solid, *seen_only((*shown, kick, plate, closer))), middle)

    def _glazed(self, wide: float, high: float, upper: float, paint: Surface) -> Parts:
        low, stile, top = _PANE_FROM, 0.28 * wide, _SILL + high
        glass = Surface((0.55, 0.68, 0.72, 0.35))
        return (
            box((_THICKNESS, wide, low - _SILL), (0.0, 0.0, 0.5 * (low + _SILL)), paint),
            box((_THICKNESS, wide, top - upper), (0.0, 0.0, 0.5 * (top + upper)), paint),
            *(
                box(
                    (_THICKNESS, stile, upper - low),
                    (0.0, side * 0.5 * (wide - stile), 0.5 * (low + upper)),
                    paint,
                )
                for side in (-1.0, 1.0)
            ),
            box((0.008, wide - 2.0 * stile, upper - low), (0.0, 0.0, 0.5 * (low + upper)), glass),
        )

    def _handle(self) -> Parts:
        """Levers on both sides, about the spindle; they point to the hinges."""
        away, bar, reach = 0.05, 0.022, 0.13
        parts = []
        for side in (-1.0, 1.0):
            near = side * 0.5 * _THICKNESS
            far = side * (0.5 * _THICKNESS + away)
            middle = (0.5 * (near + far), 0.0, 0.0)
            parts.append(cylinder(0.5 * bar, away, middle, look.STAINLESS, LYING_X))
            lever = (far, self._left * 0.5 * (reach - bar), 0.0)
            parts.append(box((bar, reach, bar), lever, look.STAINLESS))
        return tuple(parts)


TYPES = {"door": Door}
