"""Surfaces under the tracks: PyBullet's bodies as the traction law sees them."""

from __future__ import annotations

from typing import Callable, Dict, List, Optional, Sequence, Tuple

import pybullet

from ..engine.world import GRAVITY
from .law import Vector
from .track_config import TrackConfig

BodyLink = Tuple[int, int]
"""PyBullet's numbers of a body and of a link in it."""
Twist = Tuple[Vector, Vector, Vector]
"""A point of a body and its velocity, and the angular velocity, in the world."""


class GroundSurface:
    """One link that a track can touch.

    Attributes
    ----------
    along, across, flank : float
        Friction coefficients of belts on its faces, along and across them, and of their flanks.
    mass, weight : float
        kg, N; 0 where it stands fast.
    faces : tuple of Vector
        Normals of its boxes' faces, one of two that are opposite: in the world where it stands
        fast, else in the link's inertial frame.
    """

    __slots__ = ("across", "along", "faces", "flank", "mass", "weight")

    def __init__(
        self,
        config: TrackConfig,
        friction: float,
        material: str,
        mass: float,
        faces: Tuple[Vector, ...],
    ) -> None:
        along, across = config.grip(material)
        self.along = along * friction
        self.across = across * friction
        self.flank = config.side_friction * friction
        self.mass = mass
        self.weight = mass * GRAVITY
        self.faces = faces


class Surfaces:
    """All links that tracks have touched.

    Parameters
    ----------
    client : int
        Of PyBullet.
    material_of : callable, optional
        Material of a link.
    """

    def __init__(
        self,
        client: int,
        config: TrackConfig,
        material_of: Optional[Callable[[int, int], str]] = None,
    ) -> None:
        self._client = client
        self._config = config
        self._material_of = material_of
        self._known: Dict[BodyLink, GroundSurface] = {}
        self._poses: Dict[BodyLink, Tuple[Twist, Sequence[float]]] = {}

    def forget(self) -> None:
        """Look at every link anew: PyBullet gives a new body the number of one that went."""
        self._known.clear()

    def begin_step(self) -> None:
        """Look at all motions anew."""
        self._poses.clear()

    def of(self, link: BodyLink) -> GroundSurface:
        """Return what is known of a link."""
        found = self._known.get(link)
        if found is None:
            found = self._known[link] = self._look(link)
        return found

    def velocity(self, link: BodyLink, point: Vector) -> Vector:
        """Velocity of a point that moves with a loose link (m/s)."""
        (a, b, c), (u, v, w), (p, q, r) = self._pose(link)[0]
        x, y, z = point
        x, y, z = x - a, y - b, z - c
        return (u + q * z - r * y, v + r * x - p * z, w + p * y - q * x)

    def steepness(self, link: BodyLink, surface: GroundSurface, normal: Vector) -> float:
        """Cosine of the angle between a normal and the nearest normal of a face; 1 without any."""
        faces = surface.faces
        if not faces:
            return 1.0
        x, y, z = normal
        if surface.mass > 0.0:
            a, b, c, d, e, f, g, h, i = self._pose(link)[1]
            x, y, z = a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z
        nearest = 0.0
        for p, q, r in faces:
            cosine = p * x + q * y + r * z
            cosine = cosine if cosine > 0.0 else -cosine
            nearest = cosine if cosine > nearest else nearest
        return nearest

    def _pose(self, link: BodyLink) -> Tuple[Twist, Sequence[float]]:
        found = self._poses.get(link)
        if found is None:
            found = self._poses[link] = self._measure(link)
        return found

    def _measure(self, link: BodyLink) -> Tuple[Twist, Sequence[float]]:
        uid, index = link
        if index < 0:
            centre, turned = pybullet.getBasePositionAndOrientation(
                uid, physicsClientId=self._client
            )
            linear, angular = pybullet.getBaseVelocity(uid, physicsClientId=self._client)
        else:
            state = pybullet.getLinkState(
                uid,
                index,
                computeLinkVelocity=1,
                computeForwardKinematics=1,
                physicsClientId=self._client,
            )
            centre, turned, linear, angular = state[0], state[1], state[6], state[7]
        return (centre, linear, angular), pybullet.getMatrixFromQuaternion(turned)

    def _look(self, link: BodyLink) -> GroundSurface:
        dynamics = pybullet.getDynamicsInfo(*link, physicsClientId=self._client)
        mass, friction = dynamics[0], dynamics[1]
        turned: Optional[Sequence[float]] = None
        if mass <= 0.0:
            turned = self._orientation(link)
        material = self._material_of(*link) if self._material_of else ""
        return GroundSurface(self._config, friction, material, mass, self._faces(link, turned))

    def _orientation(self, link: BodyLink) -> Sequence[float]:
        uid, index = link
        if index < 0:
            return pybullet.getBasePositionAndOrientation(uid, physicsClientId=self._client)[1]
        return pybullet.getLinkState(uid, index, physicsClientId=self._client)[1]

    def _faces(self, link: BodyLink, turned: Optional[Sequence[float]]) -> Tuple[Vector, ...]:
        """Normals of the boxes among a link's shapes, each direction once."""
        faces: List[Vector] = []
        for shape in pybullet.getCollisionShapeData(*link, physicsClientId=self._client):
            if shape[2] != pybullet.GEOM_BOX:
                continue
            orientation = shape[6]
            if turned is not None:
                orientation = pybullet.multiplyTransforms(
                    (0.0, 0.0, 0.0), turned, (0.0, 0.0, 0.0), orientation
                )[1]
            rotation = pybullet.getMatrixFromQuaternion(orientation)
            for axis in range(3):
                face = (rotation[axis], rotation[axis + 3], rotation[axis + 6])
                if all(abs(sum(a * b for a, b in zip(face, known))) < _SAME for known in faces):
                    faces.append(face)
        return tuple(faces)


_SAME = 0.9999
"""Cosine of the angle up to which two normals count as one."""
