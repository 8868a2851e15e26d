"""Force-angle measure of tip-over stability.

E. G. Papadopoulos and D. A. Rey, "A new measure of tipover stability margin for mobile
manipulators", ICRA 1996, and "The force-angle measure of tipover stability margin for mobile
manipulators", Vehicle System Dynamics 33 (2000). For every edge of the support polygon, it takes
the angle by which the net force on the centre of mass passes the edge on its inner side, times that
force, times the distance between the force's line and the edge; the smallest product counts.

Vectors are in any one frame whose z axis is vertical. Nothing here knows of PyBullet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.vectors import cross, difference, dot
from telex_control.common.params import Declared, number

Vector = Tuple[float, float, float]

_COARSE = 5e-3
"""Points (m) closer than this are one, and corners that stick out less are none: the edge between
them would point anywhere, up and down too.
"""


@dataclass(frozen=True)
class StabilityConfig(Declared):
    """When a robot counts as unstable, as tipped over, and as stuck."""

    caution: float = number(
        0.5,
        "Margin below which the state is CAUTION; 1 is that of the robot as it stands "
        "level in its start pose.",
        0.0,
    )
    smoothing_time: float = number(0.3, "Of the margin (s); 0 leaves it as it is.", 0.0)
    warning_ahead: float = number(
        0.28,
        "Rotation over nose or rear (rad) with less than which left the robot is about to tip"
        " over, once that lasts for `warning_ahead_time`.",
        0.0,
        math.pi,
    )
    warning_ahead_time: float = number(0.7, "s: a robot that climbs rocks ahead and back.", 0.0)
    warning_sideways: float = number(
        0.35,
        "The same over a side (rad), once that lasts for `warning_sideways_time`.",
        0.0,
        math.pi,
    )
    warning_sideways_time: float = number(0.05, "s.", 0.0)
    warning_sideways_foresight: float = number(
        0.5,
        "For how long (s) the robot is taken to go on turning over a side as it does: "
        "what is left of that rotation then counts.",
        0.0,
    )
    warning_hold: float = number(0.5, "How long a warning stays after its cause is gone (s).", 0.0)
    tipped_angle: float = number(
        1.2,
        "Tilt beyond which the robot has tipped over (rad), once it lasts for `tipped_time` (s).",
        maximum=math.pi,
        above=0.0,
    )
    tipped_time: float = number(0.5, "See `tipped_angle` (s).", 0.0)
    stuck_time: float = number(
        2.0,
        "Time (s) over which a robot moves less than `stuck_ratio` of what its belts "
        "are told to run, until it counts as stuck.",
        above=0.0,
    )
    stuck_ratio: float = number(0.1, "See `stuck_time`.", maximum=1.0, above=0.0)
    stuck_speed: float = number(0.02, "Commanded belt speed (m/s) below which it only stands.", 0.0)


@dataclass(frozen=True)
class ForceAngle:
    """An edge of a support polygon, over which a robot may tip.

    Attributes
    ----------
    measure : float
        Force-angle measure (N m rad); below 0 the robot tips over it.
    angle : float
        By how much the net force may turn before it passes the edge (rad); negative beyond it.
    outward : tuple of 2 floats
        Unit vector in the horizontal plane, from the polygon over the edge.
    start : Vector
        Where the edge begins (m).
    """

    measure: float
    angle: float
    outward: Tuple[float, float]
    start: Vector


def support_polygon(points: Sequence[Vector]) -> List[Vector]:
    """Corners of the convex hull of `points` as seen from above, counter-clockwise.

    Heights stay as they are: the corners need not lie in one plane. Points in a line give its two
    ends. Seen from above, of points less than 5 mm apart the first is taken, and corners that stick
    out by less are left out.

    Parameters
    ----------
    points : sequence of Vector
        Where the robot is held up (m).
    """
    # Andrew's monotone chain.
    ordered = sorted(_distinct(points))
    if len(ordered) < 3:
        return ordered
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return _without_blunt_corners(lower[:-1] + upper[:-1])


def _distinct(points: Sequence[Vector]) -> List[Vector]:
    x, y, _ = np.reshape(points, (-1, 3)).T
    close = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2 < _COARSE**2
    kept: List[Vector] = []
    doubled = np.zeros(len(points), bool)
    for index, point in enumerate(points):
        if not doubled[index]:
            kept.append(point)
            doubled |= close[index]
    return kept


def _chain(points: Sequence[Vector]) -> List[Vector]:
    chain: List[Vector] = []
    for point in points:
        x, y, _ = point
        while len(chain) > 1:
            (ax, ay, _), (bx, by, _) = chain[-2:]
            if (bx - ax) * (y - ay) > (by - ay) * (x - ax):
                break
            chain.pop()
        chain.append(point)
    return chain


def _area(first: Vector, second: Vector, third: Vector) -> float:
    """Twice the area of a triangle as seen from above, positive counter-clockwise (m2)."""
    ax, ay = second[0] - first[0], second[1] - first[1]
    bx, by = third[0] - first[0], third[1] - first[1]
    return ax * by - ay * bx


def _without_blunt_corners(polygon: List[Vector]) -> List[Vector]:
    """Leave corners out, the bluntest first, until all stick out of the rest."""
    while len(polygon) > 2:
        heights = [
            _area(before, corner, after) / math.hypot(after[0] - before[0], after[1] - before[1])
            for before, corner, after in zip(
                (polygon[-1], *polygon), polygon, (*polygon[1:], polygon[0])
            )
        ]
        least = min(heights)
        if least >= _COARSE:
            break
        bluntest = heights.index(least)
        polygon = polygon[:bluntest] + polygon[bluntest + 1 :]
    return polygon


def force_angle(
    polygon: Sequence[Vector], center_of_mass: Vector, force: Vector, moment: Vector
) -> Optional[ForceAngle]:
    """Force-angle measure of a robot on its support.

    Parameters
    ----------
    polygon : sequence of Vector
        As `support_polygon` returns it (m).
    center_of_mass : Vector
        Of the robot (m).
    force, moment : Vector
        Sum of gravity, of inertia and of all that acts on the robot but its support (N), and its
        moment about the centre of mass (N m).

    Returns
    -------
    ForceAngle or None
        None when fewer than two points carry the robot.
    """
    edges = force_angles(polygon, center_of_mass, force, moment)
    return min(edges, key=lambda edge: edge.measure) if edges else None


def force_angles(
    polygon: Sequence[Vector], center_of_mass: Vector, force: Vector, moment: Vector
) -> List[ForceAngle]:
    """All edges of the support polygon, as `force_angle` looks at them; none of a single point."""
    if len(polygon) < 2:
        return []
    edges = zip(polygon, (*polygon[1:], polygon[0]))
    return [_edge(start, end, center_of_mass, force, moment) for start, end in edges]


def _edge(start: Vector, end: Vector, center: Vector, force: Vector, moment: Vector) -> ForceAngle:
    axis = _unit(difference(end, start))
    flat = math.hypot(axis[0], axis[1])
    outward = (axis[1] / flat, -axis[0] / flat)
    to_axis = _across(difference(end, center), axis)
    distance = math.sqrt(dot(to_axis, to_axis))
    if distance < 1e-9:
        return ForceAngle(0.0, 0.0, outward, start)
    # A moment about the edge counts as the force on the centre of mass that would have it.
    turning = dot(axis, moment) / (distance * distance)
    lever = cross(to_axis, axis)
    across = _across(force, axis)
    net = (
        across[0] + turning * lever[0],
        across[1] + turning * lever[1],
        across[2] + turning * lever[2],
    )
    strength = math.sqrt(dot(net, net))
    if strength < 1e-9:
        return ForceAngle(0.0, 0.0, outward, start)
    angle = math.atan2(dot(cross(to_axis, net), axis), dot(to_axis, net))
    share = dot(to_axis, net) / (strength * strength)
    aside = (
        to_axis[0] - share * net[0],
        to_axis[1] - share * net[1],
        to_axis[2] - share * net[2],
    )
    measure = angle * math.sqrt(dot(aside, aside)) * strength
    return ForceAngle(measure, angle, outward, start)


def _across(vector: Vector, axis: Vector) -> Vector:
    """Part of `vector` at right angles to the unit vector `axis`."""
    along = dot(vector, axis)
    return (
        vector[0] - along * axis[0],
        vector[1] - along * axis[1],
        vector[2] - along * axis[2],
    )


def _unit(a: Vector) -> Vector:
    length = math.sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length
