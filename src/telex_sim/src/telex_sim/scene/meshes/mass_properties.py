"""Mass, centre of mass and inertia of solids, exactly.

Inertia tensors are about the centre of mass, in the axes of the frame that the centre is given in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable, Tuple

import numpy as np

from telex_control.common.geometry.matrices import quaternion_tuple, rotation_matrix
from telex_control.common.geometry.quaternions import UPRIGHT, Pose, Quaternion, Vector3


@dataclass(frozen=True)
class MassProperties:
    """What a rigid body weighs, and how that is spread.

    Attributes
    ----------
    mass : float
        kg.
    center : numpy.ndarray
        Shape (3,), m.
    inertia : numpy.ndarray
        Shape (3, 3), kg m2.
    """

    mass: float
    center: np.ndarray
    inertia: np.ndarray

    def scaled(self, mass: float) -> MassProperties:
        """The same body of another density, so that it weighs `mass`."""
        return MassProperties(mass, self.center, self.inertia * (mass / self.mass))

    def placed(self, pose: Pose) -> MassProperties:
        """The same body in the frame that `pose` places it in."""
        turn = rotation_matrix(pose[1])
        center = np.array(pose[0]) + turn @ self.center
        return MassProperties(self.mass, center, turn @ self.inertia @ turn.T)

    def about_axis(self, point: np.ndarray, axis: np.ndarray) -> float:
        """Moment of inertia about a line (kg m2)."""
        arm = np.cross(axis, self.center - point)
        return float(axis @ self.inertia @ axis + self.mass * (arm @ arm))

    def principal(self) -> Tuple[Vector3, Quaternion]:
        """Principal moments (kg m2), and the orientation of their axes."""
        largest = float(np.abs(np.diag(self.inertia)).max())
        off_diagonal = self.inertia - np.diag(np.diag(self.inertia))
        if np.abs(off_diagonal).max() <= 1e-9 * largest:
            x, y, z = np.diag(self.inertia)
            return (float(x), float(y), float(z)), UPRIGHT
        values, axes = np.linalg.eigh(self.inertia)
        if np.linalg.det(axes) < 0.0:
            axes[:, 0] = -axes[:, 0]
        return (float(values[0]), float(values[1]), float(values[2])), quaternion_tuple(axes)


def combined(bodies: Iterable[MassProperties]) -> MassProperties:
    """Several bodies as one (parallel axis theorem)."""
    parts = list(bodies)
    mass = sum(part.mass for part in parts)
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.center - center
        inertia += part.inertia + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return MassProperties(mass, center, inertia)


def box(size: Vector3) -> MassProperties:
    """A box of density 1 kg/m3 about its middle; `size` is its full extents (m)."""
    x, y, z = (edge * edge for edge in size)
    mass = size[0] * size[1] * size[2]
    inertia = np.diag([y + z, x + z, x + y]) * (mass / 12.0)
    return MassProperties(mass, np.zeros(3), inertia)


def sphere(radius: float) -> MassProperties:
    """A sphere of density 1 kg/m3 about its middle."""
    mass = 4.0 / 3.0 * math.pi * radius**3
    return MassProperties(mass, np.zeros(3), np.eye(3) * (0.4 * mass * radius * radius))


def cylinder(radius: float, length: float) -> MassProperties:
    """A cylinder of density 1 kg/m3 about its middle, along z."""
    mass = math.pi * radius * radius * length
    across = (3.0 * radius * radius + length * length) / 12.0
    inertia = np.diag([across, across, 0.5 * radius * radius]) * mass
    return MassProperties(mass, np.zeros(3), inertia)


def closed_surface(triangles: np.ndarray) -> MassProperties:
    """What a closed surface encloses, at a density of 1 kg/m3.

    Sums the tetrahedra between the triangles and a point (Tonon 2004: the second moments of a
    tetrahedron with a corner in the origin are V/20 (sum of corners x sum + sum of squares)).

    Parameters
    ----------
    triangles : numpy.ndarray
        Shape (N, 3, 3) (m), counter-clockwise seen from outside.
    """
    reference = triangles.reshape(-1, 3).mean(axis=0)
    corners = triangles - reference
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    volume = float(volumes.sum())
    sums = corners.sum(axis=1)
    center = np.einsum("i,ij->j", volumes, sums) / (4.0 * volume)
    second = (
        np.einsum("i,ij,ik->jk", volumes, sums, sums)
        + np.einsum("i,icj,ick->jk", volumes, corners, corners)
    ) / 20.0
    second -= volume * np.outer(center, center)
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties(volume, reference + center, inertia)
