"""A link: its solids by material, its convex collision shapes, its mass properties.

Coordinates in the frame of the link (m).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple, Union

import numpy as np
from manifold3d import Manifold

from .materials import MATERIALS
from .solids import union

Vector = Tuple[float, float, float]


@dataclass(frozen=True)
class BoxShape:
    """Box with its centre and its roll, pitch, yaw (rad)."""

    size: Vector
    at: Vector
    rpy: Vector


@dataclass(frozen=True)
class CylinderShape:
    """Cylinder along z of its own frame, with its centre and roll, pitch, yaw (rad)."""

    radius: float
    length: float
    at: Vector
    rpy: Vector


@dataclass(frozen=True)
class HullShape:
    """Convex hull of points (n, 3)."""

    points: np.ndarray


Shape = Union[BoxShape, CylinderShape, HullShape]

_RPY_ONTO: Dict[str, Vector] = {
    "x": (0.0, math.pi / 2, 0.0),
    "y": (math.pi / 2, 0.0, 0.0),
    "z": (0.0, 0.0, 0.0),
}


@dataclass(frozen=True)
class MassProperties:
    """Mass (kg), centre (3, m), inertia about the centre (3, 3, kg m^2).

    density_scale: the mass over what the densities of the materials alone would give.
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    density_scale: float


class LinkModel:
    """One link under construction.

    Parameters
    ----------
    name
        Of the link, or of the body where several links share one.
    mass
        Mass budget (kg). The densities of the materials say how it is spread.
    """

    def __init__(self, name: str, mass: float) -> None:
        self.name = name
        self.mass = mass
        # Material of what runs around its wheels as a belt; empty: nothing does.
        self.belt = ""
        self.shapes: List[Shape] = []
        self._drawn: Dict[str, List[Manifold]] = {}
        self._inside: Dict[str, List[Manifold]] = {}

    def add(self, material: str, *solids: Manifold) -> LinkModel:
        """Add solids that are drawn and weigh."""
        self._drawn.setdefault(_known(material, self.name), []).extend(solids)
        return self

    def add_inside(self, material: str, *solids: Manifold) -> LinkModel:
        """Add solids that weigh but are not drawn: batteries, drives, electronics."""
        self._inside.setdefault(_known(material, self.name), []).extend(solids)
        return self

    def collide_box(
        self,
        size: Sequence[float],
        at: Sequence[float] = (0, 0, 0),
        rpy: Sequence[float] = (0, 0, 0),
    ) -> None:
        """Add a box to the collision shapes."""
        self.shapes.append(BoxShape(_vector(size), _vector(at), _vector(rpy)))

    def collide_cylinder(
        self, radius: float, length: float, axis: str = "z", at: Sequence[float] = (0, 0, 0)
    ) -> None:
        """Add a cylinder along an axis to the collision shapes."""
        self.shapes.append(CylinderShape(radius, length, _vector(at), _RPY_ONTO[axis]))

    def collide_hull(self, points: Sequence[Sequence[float]]) -> None:
        """Add the convex hull of points to the collision shapes."""
        self.shapes.append(HullShape(np.asarray(points, dtype=float)))

    def merged(self) -> Dict[str, Manifold]:
        """Return what is drawn: one solid per material, in the order of their names."""
        return {material: union(solids) for material, solids in sorted(self._drawn.items())}

    def mass_properties(self) -> MassProperties:
        """Return mass, centre and inertia of drawn and inner solids together.

        Raises
        ------
        ValueError
            When the solids make no body: no volume, or moments that no body has.
        """
        volume = 0.0
        first, second = np.zeros(3), np.zeros((3, 3))
        for group in (self._drawn, self._inside):
            for material, solids in sorted(group.items()):
                density = MATERIALS[material].density
                part = volume_moments(union(solids))
                volume += density * part[0]
                first += density * part[1]
                second += density * part[2]
        if volume <= 0:
            raise ValueError(f"{self.name}: its solids have no volume")
        scale = self.mass / volume
        centre = first / volume
        about_centre = scale * second - self.mass * np.outer(centre, centre)
        inertia = np.trace(about_centre) * np.eye(3) - about_centre
        moments = np.linalg.eigvalsh(inertia)
        if moments[0] <= 0 or moments[0] + moments[1] < moments[2]:
            raise ValueError(f"{self.name}: no body has the principal moments {moments} kg m^2")
        return MassProperties(self.mass, centre, inertia, scale)


def volume_moments(solid: Manifold) -> Tuple[float, np.ndarray, np.ndarray]:
    """Return a solid's volume (m^3), first (3, m^4) and second moments (3, 3, m^5), about 0.

    Sums over the tetrahedra between the origin and each triangle (a, b, c): their volume is
    v = det(a, b, c) / 6, their centre (a + b + c) / 4, and the integral of x x^T over one is
    v / 20 (s s^T + a a^T + b b^T + c c^T) with s = a + b + c.
    """
    mesh = solid.to_mesh64()
    corners = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)]
    volumes = np.linalg.det(corners) / 6
    sums = corners.sum(axis=1)
    second = np.einsum("t,ti,tj->ij", volumes, sums, sums)
    second += np.einsum("t,tki,tkj->ij", volumes, corners, corners)
    return float(volumes.sum()), volumes @ sums / 4, second / 20


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def _known(material: str, link: str) -> str:
    if material not in MATERIALS:
        raise ValueError(f"{link}: no material '{material}'; there are {', '.join(MATERIALS)}")
    return material
