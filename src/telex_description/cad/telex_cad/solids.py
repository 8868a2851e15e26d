"""Bevelled primitives on manifold3d. Lengths in m, angles of `segments` and `sides` per full turn.

Every function returns a closed solid. Solids are placed by their centre unless stated otherwise.
"""

from __future__ import annotations

from typing import Iterable, List, Sequence, Tuple

import numpy as np
from manifold3d import CrossSection, JoinType, Manifold, OpType

Vector = Sequence[float]
Outline = Sequence[Sequence[float]]

# Euler angles (degrees) that turn +z onto an axis
_ONTO = {"x": (0.0, 90.0, 0.0), "y": (-90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}
# How far printed or glued-on surfaces stand proud, so that renderers do not let them flicker
PROUD = 0.0003


def union(solids: Iterable[Manifold]) -> Manifold:
    """Return all solids as one."""
    return Manifold.batch_boolean(list(solids), OpType.Add)


def box(size: Vector, at: Vector = (0, 0, 0), bevel: float = 0.004) -> Manifold:
    """Return a box whose twelve edges are bevelled; a bevel of 0 leaves them sharp."""
    x, y, z = size
    cut = min(bevel, 0.45 * min(size))
    if cut <= 0:
        return Manifold.cube((x, y, z), True).translate(tuple(at))
    cores = [
        Manifold.cube((x - 2 * cut, y - 2 * cut, z), True),
        Manifold.cube((x - 2 * cut, y, z - 2 * cut), True),
        Manifold.cube((x, y - 2 * cut, z - 2 * cut), True),
    ]
    return Manifold.batch_hull(cores).translate(tuple(at))


def turned(
    profile: Outline, axis: str = "z", at: Vector = (0, 0, 0), segments: int = 32
) -> Manifold:
    """Return a solid of revolution.

    Parameters
    ----------
    profile
        Outline as (radius, height along the axis), counterclockwise in that plane.
    axis
        "x", "y" or "z".
    at
        Where the profile's origin lies.
    """
    section = CrossSection([[tuple(point) for point in profile]])
    return Manifold.revolve(section, segments).rotate(_ONTO[axis]).translate(tuple(at))


def cylinder(
    radius: float,
    length: float,
    axis: str = "z",
    at: Vector = (0, 0, 0),
    bevel: float = 0.002,
    segments: int = 32,
) -> Manifold:
    """Return a cylinder with bevelled rims; a bevel of 0 leaves them sharp."""
    return ring(radius, 0, length, axis, at, bevel, segments)


def ring(
    outer: float,
    inner: float,
    length: float,
    axis: str = "z",
    at: Vector = (0, 0, 0),
    bevel: float = 0.0015,
    segments: int = 32,
) -> Manifold:
    """Return a tube between two radii, its outer rims bevelled."""
    cut = min(bevel, 0.45 * length, 0.45 * (outer - inner))
    end = length / 2
    rim = [(outer, -end), (outer, end)]
    if cut > 0:
        rim = [(outer - cut, -end), (outer, cut - end), (outer, end - cut), (outer - cut, end)]
    return turned([(inner, -end), *rim, (inner, end)], axis, at, segments)


def bolt(at: Vector, axis: str = "z", radius: float = 0.0045, height: float = 0.003) -> Manifold:
    """Return a hexagon head on a face; as much of it is sunk in as stands out."""
    return cylinder(radius, 2 * height, axis, at, 0.0, 6)


def prism(
    points: Outline,
    width: float,
    bevel: float = 0.004,
    plane: str = "xz",
    at: Vector = (0, 0, 0),
) -> Manifold:
    """Return a convex outline extruded to both sides by half the width, its rims bevelled.

    Parameters
    ----------
    points
        Corners (2), in either direction round.
    plane
        "xz" extrudes along y, "xy" along z.
    """
    return slab(outline_of(points), width, bevel, plane, at)


def outline_of(points: Outline) -> CrossSection:
    """Return the polygon with these corners, whichever way round they are given."""
    corners = [tuple(point) for point in points]
    section = CrossSection([corners])
    if section.is_empty() or section.area() <= 0:
        section = CrossSection([corners[::-1]])
    return section


def slab(
    section: CrossSection,
    width: float,
    bevel: float = 0.0,
    plane: str = "xz",
    at: Vector = (0, 0, 0),
) -> Manifold:
    """Extrude a section to both sides by half the width.

    A bevel needs a convex section; without one the section may have any shape, holes included.
    """
    solid = _extruded(section, width)
    if bevel > 0:
        inner = section.offset(-bevel, JoinType.Miter)
        solid = Manifold.batch_hull(
            [_extruded(section, width - 2 * bevel), _extruded(inner, width)]
        )
    if plane == "xz":
        solid = solid.rotate((90.0, 0.0, 0.0))
    return solid.translate(tuple(at))


def _extruded(section: CrossSection, width: float) -> Manifold:
    return section.extrude(width).translate((0.0, 0.0, -width / 2))


def hose(points: Sequence[Vector], radius: float, sides: int = 8, samples: int = 5) -> Manifold:
    """Return a round hose along a Catmull-Rom spline.

    Parameters
    ----------
    points
        Points (3) that the hose runs through.
    samples
        Straight pieces from one point to the next.
    """
    path = _spline(np.asarray(points, dtype=float), samples)
    ball = Manifold.sphere(radius, sides)
    pieces = [
        Manifold.batch_hull([ball.translate(tuple(start)), ball.translate(tuple(end))])
        for start, end in zip(path, path[1:])
    ]
    return union(pieces)


def _spline(points: np.ndarray, samples: int) -> List[np.ndarray]:
    """Return points on the uniform Catmull-Rom spline; the ends continue straight."""
    knots = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    path = []
    for before, start, end, after in zip(knots, knots[1:], knots[2:], knots[3:]):
        slope, slope_end = (end - before) / 2, (after - start) / 2
        for t in np.linspace(0.0, 1.0, samples, endpoint=False):
            path.append(
                (2 * t**3 - 3 * t**2 + 1) * start
                + (t**3 - 2 * t**2 + t) * slope
                + (3 * t**2 - 2 * t**3) * end
                + (t**3 - t**2) * slope_end
            )
    path.append(points[-1])
    return path


def warning_stripes(
    length: float, height: float, depth: float, pitch: float = 0.05
) -> Tuple[Manifold, Manifold]:
    """Return a plate and its slanted bars, centred at the origin.

    The plate lies in the x-z plane; the bars stand proud of both its faces.
    """
    plate = box((length, depth, height), bevel=0)
    thickness = depth + 2 * PROUD
    bars = []
    for k in range(-int(height / pitch) - 2, int(length / pitch) + 2):
        x = k * pitch - length / 2
        corners = [
            (x, -height / 2),
            (x + pitch / 2, -height / 2),
            (x + pitch / 2 + height, height / 2),
            (x + height, height / 2),
        ]
        bars.append(slab(CrossSection([corners]), thickness))
    return plate, union(bars) ^ box((length, 2 * thickness, height), bevel=0)
