"""Small parts that occur all over the arm: bolt circles, cable glands, clips, connectors, ribs.

Lengths in m, in the frame of the link that carries the part.
"""

from __future__ import annotations

import math
from typing import List, Sequence, Tuple

from manifold3d import Manifold

from .solids import bolt, box, cylinder, turned, union

Vector = Tuple[float, float, float]
Point = Tuple[float, float]

# Indices of the two directions across an axis, in the order that turns right-handed about it.
_ACROSS = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}
_ALONG = {"x": 0, "y": 1, "z": 2}


def moved(at: Sequence[float], axis: str, distance: float) -> Vector:
    """Return the point `distance` further along the axis."""
    point = list(at)
    point[_ALONG[axis]] += distance
    return (point[0], point[1], point[2])


def around(
    count: int, radius: float, axis: str, at: Sequence[float], phase: float = 0.0
) -> List[Vector]:
    """Return `count` points evenly spaced on a circle about the axis through `at`.

    phase: angle of the first one, rad.
    """
    first, second = _ACROSS[axis]
    points = []
    for k in range(count):
        angle = phase + 2 * math.pi * k / count
        point = list(at)
        point[first] += radius * math.cos(angle)
        point[second] += radius * math.sin(angle)
        points.append((point[0], point[1], point[2]))
    return points


def bolt_circle(
    count: int,
    radius: float,
    axis: str,
    at: Sequence[float],
    phase: float = 0.0,
    head: float = 0.0035,
    height: float = 0.002,
) -> Manifold:
    """Return hexagon heads on a circle; half of each is sunk into the face that `at` lies on."""
    return union(bolt(p, axis, head, height) for p in around(count, radius, axis, at, phase))


def bolts(
    points: Sequence[Vector], axis: str, head: float = 0.003, height: float = 0.0015
) -> Manifold:
    """Return hexagon heads at the points of a face."""
    return union(bolt(p, axis, head, height) for p in points)


def gland(at: Sequence[float], axis: str, outward: int, hose_radius: float) -> Manifold:
    """Return a cable gland that stands on a face: hexagon nut, then a dome that grips the hose.

    outward: 1 or -1, the way along the axis in which the hose leaves.
    """
    r = hose_radius
    nut = cylinder(1.75 * r, 0.007, axis, moved(at, axis, outward * 0.0025), 0.0, 6)
    dome = [(0.0, 0.005), (1.5 * r, 0.005), (1.15 * r, 0.011), (0.0, 0.011)]
    return nut + _turned_outwards(dome, axis, outward, at, 8)


def clip(at: Sequence[float], axis: str, hose_radius: float, foot: Vector) -> Manifold:
    """Return a band round a hose and the foot, a box of this size below z of `at`, under it."""
    band = cylinder(hose_radius + 0.0020, 0.008, axis, tuple(at), 0.0, 8)
    x, y, z = at
    return band + box(foot, (x, y, z - hose_radius - foot[2] / 2), 0.0)


def cap(
    at: Sequence[float], axis: str, outward: int, radius: float, length: float, segments: int = 24
) -> Manifold:
    """Return a round cover on a face, its outer rim bevelled."""
    cut = min(0.0015, 0.45 * length)
    profile = [
        (0.0, 0.0),
        (radius, 0.0),
        (radius, length - cut),
        (radius - cut, length),
        (0.0, length),
    ]
    return _turned_outwards(profile, axis, outward, at, segments)


def connector(at: Sequence[float], axis: str, outward: int, radius: float) -> Manifold:
    """Return a round plug connector on a face: flange, sleeve, rim of its cap."""
    profile = [
        (0.0, 0.0),
        (1.35 * radius, 0.0),
        (1.35 * radius, 0.003),
        (radius, 0.003),
        (radius, 0.008),
        (1.12 * radius, 0.009),
        (1.12 * radius, 0.013),
        (0.0, 0.013),
    ]
    return _turned_outwards(profile, axis, outward, at, 10)


def finned_motor(
    at: Sequence[float],
    axis: str,
    outward: int,
    radius: float,
    length: float,
    segments: int = 24,
    fins: int = 4,
) -> Manifold:
    """Return a round motor housing that stands on a face: flange, cooling fins, rounded end."""
    flange, end = 0.2 * length, 0.2 * length
    pitch = (length - flange - end) / fins
    root, edge = 0.92 * radius, 0.985 * radius
    profile = [(0.0, 0.0), (radius, 0.0), (radius, flange)]
    for k in range(fins):
        profile += [(root, flange + (k + 0.25) * pitch), (edge, flange + (k + 0.75) * pitch)]
    profile += [(root, length - end), (0.78 * radius, length), (0.0, length)]
    return _turned_outwards(profile, axis, outward, at, segments)


def _turned_outwards(
    profile: Sequence[Point], axis: str, outward: int, at: Sequence[float], segments: int
) -> Manifold:
    """Turn (radius, height) points about the axis; heights count outwards from `at`."""
    if outward < 0:
        profile = [(radius, -height) for radius, height in reversed(profile)]
    return turned(profile, axis, at, segments)


def row_of_boxes(count: int, size: Vector, first: Vector, axis: str, pitch: float) -> Manifold:
    """Return equal boxes without bevels, each `pitch` further along the axis: cooling ribs."""
    return union(box(size, moved(first, axis, k * pitch), 0.0) for k in range(count))


def arc_points(centre: Point, radius: float, start: float, end: float, count: int) -> List[Point]:
    """Return `count` points on an arc from angle `start` to `end` (rad, from +x towards +z)."""
    return [
        (centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle))
        for angle in (start + (end - start) * k / (count - 1) for k in range(count))
    ]
