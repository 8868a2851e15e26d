"""Parts and how to place them: what the types of the library are built of."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterable, Optional, Sequence, Tuple

from telex_control.common.geometry.quaternions import about, product, rotate

from ..model import (
    ORIGIN,
    UPRIGHT,
    Color,
    Form,
    Geometry,
    Link,
    ObjectModel,
    Part,
    Quaternion,
    SceneObject,
    Surface,
    Vector3,
)
from .object_type import single

Parts = Tuple[Part, ...]

MESHES = "package://telex_sim/meshes/"
"""Where the meshes stand that `telex_sim.scene.library.mesh_shapes` makes."""

TUBE_INNER = 0.8
"""Inner over outer radius of the mesh of a tube."""
RING_THICKNESS = 0.125
"""Radius of the bar over the radius of the ring, of the mesh of a ring."""
CONE_TOP = 0.2
"""Radius on top over the radius below, of the mesh of a cone."""

BAND_TOP = 0.8
"""The same of the mesh of a band round a cone."""


def rolled(angle: float) -> Quaternion:
    """Rotation about x (rad)."""
    return about((1.0, 0.0, 0.0), angle)


def pitched(angle: float) -> Quaternion:
    """Rotation about y (rad): x turns downwards."""
    return about((0.0, 1.0, 0.0), angle)


def yawed(angle: float) -> Quaternion:
    """Rotation about z (rad)."""
    return about((0.0, 0.0, 1.0), angle)


LYING_X = pitched(0.5 * math.pi)
"""Lays what stands along z along x."""
LYING_Y = rolled(-0.5 * math.pi)
"""Lays what stands along z along y."""
TOWARDS_US = pitched(-0.5 * math.pi)
"""Turns z towards -x."""


def along_bend(along: float, aside: float, radius: float) -> Tuple[float, float, float]:
    """Find a place beside a line that begins to bend at the origin, where it leads along x.

    Parameters
    ----------
    along : float
        Way along the line from the origin (m).
    aside : float
        To the left of the line (m).
    radius : float
        Of the bend (m): positive to the left, negative to the right, 0 for a straight line.

    Returns
    -------
    tuple of 3 floats
        x, y (m) and the heading there (rad).
    """
    if radius == 0.0:
        return along, aside, 0.0
    heading = along / radius
    reach = radius - aside
    return reach * math.sin(heading), radius - reach * math.cos(heading), heading


def shifted(vector: Vector3, offset: Vector3) -> Vector3:
    """Sum of two vectors."""
    return (vector[0] + offset[0], vector[1] + offset[1], vector[2] + offset[2])


def placed(
    parts: Iterable[Part], position: Vector3 = ORIGIN, orientation: Quaternion = UPRIGHT
) -> Parts:
    """Turn parts as one, then shift them."""
    return tuple(
        replace(
            part,
            position=shifted(rotate(orientation, part.position), position),
            orientation=product(orientation, part.orientation),
        )
        for part in parts
    )


def seen_only(parts: Iterable[Part]) -> Parts:
    """Make parts that nothing touches."""
    return tuple(replace(part, solid=False) for part in parts)


def touched_only(parts: Iterable[Part]) -> Parts:
    """Make parts that nobody sees."""
    return tuple(replace(part, surface=None) for part in parts)


def box(
    size: Vector3,
    position: Vector3 = ORIGIN,
    surface: Optional[Surface] = None,
    orientation: Quaternion = UPRIGHT,
    *,
    solid: bool = True,
) -> Part:
    """Box with full extents; without a surface it is only touched."""
    return Part(Geometry(Form.BOX, size), position, orientation, surface, solid)


def cylinder(
    radius: float,
    length: float,
    position: Vector3 = ORIGIN,
    surface: Optional[Surface] = None,
    orientation: Quaternion = UPRIGHT,
    *,
    solid: bool = True,
) -> Part:
    """Cylinder about z; without a surface it is only touched."""
    geometry = Geometry(Form.CYLINDER, (radius, 0.0, length))
    return Part(geometry, position, orientation, surface, solid)


def sphere(
    radius: float,
    position: Vector3 = ORIGIN,
    surface: Optional[Surface] = None,
    *,
    solid: bool = True,
) -> Part:
    """Sphere; without a surface it is only touched."""
    return Part(Geometry(Form.SPHERE, (radius, 0.0, 0.0)), position, UPRIGHT, surface, solid)


def mesh(
    name: str,
    scale: Vector3,
    position: Vector3,
    surface: Surface,
    orientation: Quaternion = UPRIGHT,
) -> Part:
    """One of the library's meshes; nothing touches it."""
    geometry = Geometry(Form.MESH, scale, f"{MESHES}{name}.obj")
    return Part(geometry, position, orientation, surface, solid=False)


def tube(
    radius: float,
    length: float,
    position: Vector3,
    surface: Surface,
    orientation: Quaternion = UPRIGHT,
) -> Part:
    """Look of a hollow tube about z, its wall a fifth of the radius."""
    return mesh("tube", (radius, radius, length), position, surface, orientation)


def cone(radius: float, height: float, position: Vector3, surface: Surface) -> Part:
    """Look of a cone about z, `position` at its foot; its top is a fifth as wide."""
    return mesh("cone", (radius, radius, height), position, surface)


def band(radius: float, height: float, position: Vector3, surface: Surface) -> Part:
    """Look of a band round a cone, `position` at its foot; its top is four fifths as wide."""
    return mesh("band", (radius, radius, height), position, surface)


def ring(
    radius: float,
    position: Vector3,
    surface: Surface,
    orientation: Quaternion = UPRIGHT,
) -> Part:
    """Look of a ring of round bar about z."""
    return mesh("ring", (radius, radius, radius), position, surface, orientation)


SHEET = 0.0006
"""Thickness of a picture (m): so little that its edges, which show it too, are not seen."""


def sheet(width: float, height: float, at: Vector3, surface: Surface) -> Part:
    """Picture that looks towards -x, its back at `at`; nothing touches it."""
    middle = (at[0] - 0.5 * SHEET, at[1], at[2])
    return box((SHEET, width, height), middle, surface, solid=False)


def rod(
    start: Vector3, end: Vector3, radius: float, surface: Optional[Surface], *, solid: bool = True
) -> Part:
    """Cylinder from one point to another."""
    length, direction, middle = _span(start, end)
    return cylinder(radius, length, middle, surface, _turn_from_z(direction), solid=solid)


def beam(
    start: Vector3,
    end: Vector3,
    width: float,
    height: float,
    surface: Optional[Surface],
    *,
    solid: bool = True,
) -> Part:
    """Bar from one point to another; `height` is measured as nearly upwards as it can be.

    Its own x axis lies along it, so that the grain of wood does, too.
    """
    length, direction, middle = _span(start, end)
    yaw = math.atan2(direction[1], direction[0])
    pitch = -math.atan2(direction[2], math.hypot(direction[0], direction[1]))
    orientation = product(yawed(yaw), pitched(pitch))
    return box((length, width, height), middle, surface, orientation, solid=solid)


def _span(start: Vector3, end: Vector3) -> Tuple[float, Vector3, Vector3]:
    dx, dy, dz = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    middle = (start[0] + 0.5 * dx, start[1] + 0.5 * dy, start[2] + 0.5 * dz)
    return length, (dx / length, dy / length, dz / length), middle


def _turn_from_z(direction: Vector3) -> Quaternion:
    yaw = math.atan2(direction[1], direction[0])
    tilt = math.atan2(math.hypot(direction[0], direction[1]), direction[2])
    return product(yawed(yaw), pitched(tilt))


def open_box(
    inner: Vector3, wall: float, surface: Optional[Surface], position: Vector3 = ORIGIN
) -> Parts:
    """Five boards round a space that is open above; `position` is the middle below.

    Parameters
    ----------
    inner : tuple of 3 floats
        Extents of the space (m).
    wall : float
        Thickness of the boards (m).
    """
    x, y, z = inner
    length, width = x + 2.0 * wall, y + 2.0 * wall
    boards = (
        box((length, width, wall), (0.0, 0.0, 0.5 * wall), surface),
        *(
            box((wall, width, z), (side * 0.5 * (x + wall), 0.0, wall + 0.5 * z), surface)
            for side in (-1.0, 1.0)
        ),
        *(
            box((x, wall, z), (0.0, side * 0.5 * (y + wall), wall + 0.5 * z), surface)
            for side in (-1.0, 1.0)
        ),
    )
    return placed(boards, position)


def staves(
    inner: float, outer: float, length: float, count: int, surface: Optional[Surface] = None
) -> Parts:
    """Boxes round a hollow cylinder about z, which leave a hole of radius `inner` free."""
    width = 2.0 * outer * math.tan(math.pi / count)
    middle = 0.5 * (inner + outer)
    parts = []
    for index in range(count):
        turn = yawed(2.0 * math.pi * index / count)
        parts.append(
            box((outer - inner, width, length), rotate(turn, (middle, 0.0, 0.0)), surface, turn)
        )
    return tuple(parts)


def wedge(length: float, width: float, height: float, surface: Surface, sides: Surface) -> Parts:
    """Make a ramp that rises along x from 0 to `height`, about the middle of its footprint.

    What carries are a slab along the slope and, so that nothing drives in beneath, blocks under
    it; what is seen are the slab's upper side and a wedge.
    """
    slope = math.hypot(length, height)
    angle = math.atan2(height, length)
    # A thin slab would end below the floor; a thick one would stick out behind.
    thickness = 0.02
    down = (math.sin(angle), 0.0, -math.cos(angle))
    middle = shifted(
        (0.0, 0.0, 0.5 * height), (0.5 * thickness * down[0], 0.0, 0.5 * thickness * down[2])
    )
    slab = box((slope, width, thickness), middle, surface, pitched(-angle))
    blocks = []
    count = max(2, math.ceil(length / 0.3))
    for index in range(1, count):
        # Each block ends under the slab where its lower corner lies.
        run = length / count
        top = height * index / count - thickness / math.cos(angle)
        if top > 0.0:
            blocks.append(
                box((run, width, top), (-0.5 * length + (index + 0.5) * run, 0.0, 0.5 * top))
            )
    # The slab's own side shows; the wedge stays just below its upper side.
    look = mesh("wedge", (length, width - 0.002, height), (0.0, 0.0, -0.003), sides)
    return (slab, *blocks, look)


def steel_post(height: float, edge: float, position: Vector3, surface: Surface) -> Part:
    """Upright square bar; `position` is the middle of its foot."""
    return box((edge, edge, height), shifted(position, (0.0, 0.0, 0.5 * height)), surface)


def recolored(surface: Surface, color: Sequence[float]) -> Surface:
    """Give a surface another colour (red, green, blue, and perhaps alpha)."""
    return replace(surface, color=opaque(color))


def opaque(color: Sequence[float]) -> Color:
    """Complete a colour by alpha 1 where it has none."""
    red, green, blue, *alpha = color
    return (red, green, blue, alpha[0] if alpha else 1.0)


def rigid(
    name: str,
    mass: float,
    parts: Parts,
    friction: float = 1.0,
    rolling_friction: float = 0.0,
    *,
    static: bool = False,
) -> Tuple[SceneObject, ...]:
    """Make one object of a single body; see `Link`."""
    link = Link(name, mass, parts, friction, rolling_friction)
    return single(ObjectModel((link,), static=static))


def standing(name: str, parts: Parts, friction: float = 1.0) -> Tuple[SceneObject, ...]:
    """Make one static object of parts, all of the same friction."""
    return rigid(name, 0.0, parts, friction, static=True)
