"""Rough ground: ramps that cross, and fields of posts."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, Dict, List

from telex_sim.scene.library.terrain import stepfield

from ..port import NotManagedError
from ..robot_size import AXLE_HEIGHT
from ..scripted_operator import Operator
from . import footing

SPEED = 0.15  # m/s

START = 1.0
"""Where the ground gets rough (m)."""

CLEARANCE = 0.03
"""Under the belly (m)."""

ROLLING = math.radians(15.0)
"""From which roll on the high side is let down."""

FREEING = ((0.45, 0.0), (-0.70, -0.70), (0.50, -0.90), (-0.90, 0.30))
"""Tried one after the other where the robot hangs, until it has come on a little."""

ARRIVED = (0.35, 0.35)

_PROGRESS = 0.02  # m, that tells progress from slipping
_PATIENCE = 2.0
"""How long the robot may hang before another setting is tried (s)."""
_FREE = 0.08
"""After how much way the flippers are set to the ground again (m)."""


@dataclass(frozen=True)
class CrossingRamps:
    """Two columns of ramps, side by side; where one rises, the other falls.

    Attributes
    ----------
    rows : int
        Ramps in a column.
    length, width : float
        Of a ramp (m).
    angle : float
        Of a ramp (rad).
    start : float
        Where they begin (m).
    """

    rows: int = 4
    length: float = 1.2
    width: float = 0.6
    friction: float = 1.0
    angle: float = math.radians(15.0)
    start: float = START

    @property
    def end(self) -> float:
        """Where they end (m)."""
        return self.start + (self.rows + 1) * self.length

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "crossing_ramps",
                "name": "ramps",
                "position": [0.5 * (self.start + self.end), 0.0, 0.0],
                "rows": self.rows,
                "length": self.length,
                "width": self.width,
                "angle": self.angle,
                "friction": self.friction,
            }
        ]

    def height(self, x: float, y: float) -> float:
        """Height of the ground (m); the left column begins a ramp later."""
        if abs(y) > self.width:
            return 0.0
        along = (x - self.start) / self.length - (1.0 if y > 0.0 else 0.0)
        if not 0.0 <= along <= self.rows:
            return 0.0
        ramp, share = divmod(along, 1.0)
        return self.length * math.tan(self.angle) * (share if ramp % 2.0 == 0.0 else 1.0 - share)


@dataclass(frozen=True)
class Stepfield:
    """Posts of 0.1 to 0.4 m, see the type of this name.

    Attributes
    ----------
    start : float
        Where it begins (m).
    """

    pattern: str = "hill"
    pallets: int = 1
    seed: int = 5
    friction: float = 1.0
    start: float = START

    @functools.cached_property
    def _field(self) -> stepfield.Stepfield:
        return stepfield.Stepfield(self.pattern, self.pallets, seed=self.seed)

    @functools.cached_property
    def _heights(self) -> List[List[List[int]]]:
        return self._field.heights()

    @property
    def end(self) -> float:
        """Where it ends (m)."""
        return self.start + self._field.pitch * self.pallets

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        return [
            {
                "type": "stepfield",
                "name": "posts",
                "position": [0.5 * (self.start + self.end), 0.0, 0.0],
                "pattern": self.pattern,
                "pallets": self.pallets,
                "seed": self.seed,
                "friction": self.friction,
            }
        ]

    def height(self, x: float, y: float) -> float:
        """Height of the posts, or of the frame round them (m)."""
        field = self._field
        pallet, along = divmod(x - self.start, field.pitch)
        if not 0 <= pallet < self.pallets or abs(y) > 0.5 * field.pitch:
            return 0.0
        row = math.floor((along - field.border) / field.post)
        column = math.floor((y + 0.5 * field.pitch - field.border) / field.post)
        posts = self._heights[int(pallet)]
        if 0 <= row < len(posts) and 0 <= column < len(posts[row]):
            return field.post * posts[row][column]
        return field.post


def from_behind(ground: footing.Ground, middle: float) -> footing.Ground:
    """Return ground as it lies before one who comes back, on the course from twice `middle` (m)."""
    return lambda x, y: ground(2.0 * middle - x, -y)


def cross(operator: Operator, ground: footing.Ground, end: float, speed: float = SPEED) -> None:
    """Drive straight over rough ground, each flipper set to what lies under it.

    Parameters
    ----------
    end : float
        Where it is level again (m).
    speed : float
        m/s.

    Raises
    ------
    NotManagedError
    """
    operator.keep_lane(speed)
    operator.until(
        lambda: operator.pose.x > end + 0.8,
        3.0 * (end + 0.8 - operator.pose.x) / speed,
        "the floor behind",
        _Feeling(operator, ground).look,
    )
    operator.flippers(*ARRIVED)
    operator.stop()
    operator.wait(1.0)
    if operator.pose.z > AXLE_HEIGHT + 0.03 or abs(operator.pose.rise) > 0.05:
        raise NotManagedError(f"does not stand on the floor; {operator.where()}")


class _Feeling:
    """Sets the flippers to the ground, and frees a robot that hangs by other settings."""

    def __init__(self, operator: Operator, ground: footing.Ground) -> None:
        self._operator = operator
        self._ground = ground
        self._best, self._since = operator.pose.x, operator.time
        self._tried = 0
        self._free_at = operator.pose.x

    def look(self) -> None:
        """Do what is to be done at a look."""
        operator = self._operator
        pose, now = operator.pose, operator.time
        if pose.x > self._best + _PROGRESS:
            self._best, self._since = pose.x, now
        elif now - self._since > _PATIENCE:
            operator.flippers(*FREEING[self._tried % len(FREEING)])
            self._tried, self._since = self._tried + 1, now
            self._free_at = pose.x + _FREE
        if pose.x >= self._free_at:
            angles = footing.settings(self._ground, pose.x, pose.y, CLEARANCE)
            if abs(pose.roll) > ROLLING:
                angles = footing.let_down(angles, "left" if pose.roll > 0.0 else "right")
            operator.move(**angles)
