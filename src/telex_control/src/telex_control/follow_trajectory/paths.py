"""Paths for the tool: curves in space by their length."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path as File
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from . import FollowTrajectoryError

SAMPLE = 5e-4
"""Distance between the points that stand for a curve (m)."""
CORNER = math.radians(15.0)
"""A bend between neighbouring points that is sharper than this (rad) is a corner."""
MOST_POINTS = 2000000
"""A shape that takes more points fills the memory before anything can follow it."""
SHORTEST = 1e-3
"""Length (m) below which there is nothing to follow."""

PLANES: Dict[str, Tuple[Tuple[float, float, float], ...]] = {
    "xy": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "xz": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "yz": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
}
"""By name: the two directions that span a plane, and the one in which a path rises from it."""


class Path:
    """A curve through points, the same length of which is always the same way.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        m; points that coincide with their predecessor are dropped.

    Attributes
    ----------
    points : ndarray, shape (m, 3)
    lengths : ndarray, shape (m,)
        From the first point to each (m).
    stops : tuple of float
        Lengths at which there is a corner: nothing gets round it at a speed above 0 (m).

    Raises
    ------
    FollowTrajectoryError
        The points are not finite, or there is no way between them.
    """

    def __init__(self, points: Sequence[Sequence[float]]) -> None:
        given = np.asarray(points, dtype=float)
        if given.ndim != 2 or given.shape[1] != 3 or not np.isfinite(given).all():
            raise FollowTrajectoryError("a path is made of points of three finite numbers (m)")
        ways = np.linalg.norm(np.diff(given, axis=0), axis=1)
        self.points = given[np.concatenate(([True], ways > 1e-9))]
        ways = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        self.lengths = np.concatenate(([0.0], np.cumsum(ways)))
        if self.length < SHORTEST:
            raise FollowTrajectoryError(
                f"the path is {1000.0 * self.length:.3f} mm long; at least "
                f"{1000.0 * SHORTEST:g} mm are needed"
            )
        along = np.diff(self.points, axis=0) / ways[:, None]
        bends = np.arccos(np.clip(np.sum(along[1:] * along[:-1], axis=1), -1.0, 1.0))
        self.stops = tuple(float(each) for each in self.lengths[1:-1][bends > CORNER])

    @property
    def length(self) -> float:
        """Whole length (m)."""
        return float(self.lengths[-1])

    def position(self, length: np.ndarray) -> np.ndarray:
        """Points after some lengths, shape (n, 3); before its ends the path stands still."""
        return np.stack(
            [np.interp(length, self.lengths, self.points[:, axis]) for axis in range(3)], axis=-1
        )

    def moved(self, offset: Sequence[float]) -> Path:
        """Return the same path elsewhere."""
        return Path(self.points + np.asarray(offset, dtype=float))


@dataclass(frozen=True)
class Shape:
    """A path's size and place.

    Attributes
    ----------
    radius : float
        m; of a square half its side, of a figure of eight half its length.
    height : float
        By which the path rises out of its plane from begin to end (m); 0: it lies in its plane.
    turns : float
        How often it goes round.
    plane : str
        One of `PLANES`.
    centre : tuple of 3 floats
        m; a path that rises has half its height on either side of it.
    """

    radius: float = 0.15
    height: float = 0.0
    turns: float = 1.0
    plane: str = "xy"
    centre: Tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, value in (("radius", self.radius), ("turns", self.turns)):
            if not (math.isfinite(value) and value > 0.0):
                raise FollowTrajectoryError(f"{name} is {value}; it must be above 0")
        if not math.isfinite(self.height) or not all(map(math.isfinite, self.centre)):
            raise FollowTrajectoryError("height and centre must be finite")
        if self.plane not in PLANES:
            raise FollowTrajectoryError(
                f"plane is '{self.plane}'; {', '.join(PLANES)} are possible"
            )

    def place(self, flat: np.ndarray) -> Path:
        """Return the path through points of the plane, shape (n, 2), rising with their way."""
        first, second, normal = (np.array(axis) for axis in PLANES[self.plane])
        way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))))
        rise = self.height * (way / way[-1] - 0.5)
        points = np.outer(flat[:, 0], first) + np.outer(flat[:, 1], second)
        return Path(points + np.outer(rise, normal) + np.array(self.centre))

    def count(self, way: float) -> int:
        """How many points stand for a curve of some length (m)."""
        points = (way + abs(self.height)) / SAMPLE
        self.require_few(points)
        return max(2, math.ceil(points) + 1)

    def require_few(self, points: float) -> None:
        """Raise a `FollowTrajectoryError` where it takes too many points."""
        if points > MOST_POINTS:
            raise FollowTrajectoryError(
                f"turns is {self.turns:g}, radius is {self.radius:g} and height is "
                f"{self.height:g}: the path takes {points:.3g} points; at most {MOST_POINTS} are "
                "possible"
            )


def circle(shape: Shape) -> Path:
    """Round the centre, `turns` times; with a height it is a spiral."""
    whole = 2.0 * math.pi * shape.turns
    angle = np.linspace(0.0, whole, shape.count(whole * shape.radius))
    return shape.place(shape.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


def square(shape: Shape) -> Path:
    """Along the sides of a square, from one of its corners, `turns` times; it stops at each."""
    corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
    shape.require_few(4.0 * shape.turns)
    sides = max(1, round(4.0 * shape.turns))
    flat = np.array([corners[index % 4] for index in range(sides + 1)])
    return shape.place(shape.radius * flat)


def figure_8(shape: Shape) -> Path:
    """Gerono's lemniscate, from where it crosses itself."""
    whole = 2.0 * math.pi * shape.turns
    angle = np.linspace(0.0, whole, shape.count(6.1 * shape.turns * shape.radius))
    flat = np.stack([np.sin(angle), np.sin(angle) * np.cos(angle)], axis=-1)
    return shape.place(shape.radius * flat)


SHAPES = {"spiral": circle, "circle": circle, "square": square, "figure-8": figure_8}
"""Paths by name."""


def from_csv(file: File, offset: Optional[Sequence[float]] = None) -> Path:
    """Read a path from a file: a point a line, x, y and z in m.

    Three words in its first line are a head.

    Parameters
    ----------
    offset : sequence of 3 floats, optional
        Added to each point (m).

    Raises
    ------
    FollowTrajectoryError
        It cannot be read, or a line is no point; the message names both.
    """
    points: List[List[float]] = []
    try:
        with open(file, encoding="utf-8-sig", newline="") as text:
            for number, row in enumerate(csv.reader(text), 1):
                cells = [cell.strip() for cell in row]
                if not any(cells) or cells[0].startswith("#"):
                    continue
                values = [value for value in map(_value, cells) if value is not None]
                if number == 1 and len(cells) == 3 and not values:
                    continue
                if not len(cells) == len(values) == 3 or not all(map(math.isfinite, values)):
                    raise FollowTrajectoryError(
                        f"{file}, line {number} is '{','.join(cells)}'; x, y, z (m) are needed"
                    )
                points.append(values)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FollowTrajectoryError(f"{file}: {error}") from error
    if len(points) < 2:
        raise FollowTrajectoryError(f"{file} has {len(points)} points; at least 2 are needed")
    path = Path(points)
    return path if offset is None else path.moved(offset)


def _value(text: str) -> Optional[float]:
    """Return the number that a cell holds, which may be nan; None for a word."""
    try:
        return float(text)
    except ValueError:
        return None
