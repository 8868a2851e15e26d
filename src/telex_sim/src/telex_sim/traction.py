"""Traction of driven belts: contact points in, forces out.

PyBullet has no moving belts. Each track is one convex link without friction of its own, and this
law adds, at every contact point, the friction of a surface that runs with the belt. A track that
does not slip is held by a spring (the bristle of a LuGre-like model), so that a standing robot
stands still on a slope; a track that slips feels Coulomb friction within an ellipse, because a
belt grips better along than across.

Measured in the project's study of track models: direction of the force from the belt's tangent at
the contact, lateral stiffness scaled by the square of the friction ratio so that the slip
direction follows the ellipse.
"""

from __future__ import annotations

import math
from typing import Dict, List, Optional, Sequence, Tuple

import pybullet

from .config import TrackConfig
from .world import Body, Vector

_SIDE_CONTACT = 0.2
"""Sine of the angle between contact normal and axle below which the belt's flank is touched."""


class _Track:
    """One belt and its stick state (m, along and across the belt)."""

    __slots__ = ("across", "along", "link")

    def __init__(self, link: int) -> None:
        self.link = link
        self.along = 0.0
        self.across = 0.0


class Traction:
    """The tracks of one robot.

    Parameters
    ----------
    body : Body
    config : TrackConfig
    step_size : float
        Time between calls of `apply` (s).
    """

    def __init__(self, body: Body, config: TrackConfig, step_size: float) -> None:
        self._client = body.client
        self._uid = body.uid
        self._step_size = step_size
        self._config = config
        ratio = (config.lateral_friction / config.friction) ** 2
        self._lateral_stiffness = config.stiffness * ratio
        self._lateral_damping = config.damping * ratio
        self._tracks = [_Track(body.links[body.parents[belt]]) for belt in config.belts]
        self._links = [track.link for track in self._tracks]
        self._surfaces: Dict[Tuple[int, int], Tuple[bool, float]] = {}
        for link in self._links:
            pybullet.changeDynamics(
                self._uid,
                link,
                lateralFriction=0.0,
                contactStiffness=config.contact_stiffness,
                contactDamping=config.contact_damping,
                physicsClientId=self._client,
            )

    def forget_surfaces(self) -> None:
        """Look at every surface anew: PyBullet gives a new body the number of one that went."""
        self._surfaces.clear()

    def apply(self, belt_speeds: Sequence[float]) -> None:
        """Apply the forces for the next step.

        Parameters
        ----------
        belt_speeds : sequence of float
            Speed of each belt's lower run against its track (m/s), in the order of
            `TrackConfig.belts`; positive drives forward.
        """
        if not self._tracks:
            return
        uid = self._uid
        contacts: Dict[int, List[Tuple]] = {link: [] for link in self._links}
        for contact in pybullet.getContactPoints(uid, physicsClientId=self._client):
            if contact[9] <= 0.0 or contact[1] == contact[2]:
                continue
            mine = contact[3] if contact[1] == uid else contact[4]
            if mine in contacts:
                contacts[mine].append(contact)
        if not any(contacts.values()):
            for track in self._tracks:
                track.along = track.across = 0.0
            return
        states = pybullet.getLinkStates(
            uid,
            self._links,
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=self._client,
        )
        for track, speed, state in zip(self._tracks, belt_speeds, states):
            self._apply_to(track, contacts[track.link], speed, state)

    def _apply_to(self, track: _Track, contacts: List[Tuple], speed: float, state: Tuple) -> None:
        if not contacts:
            track.along = track.across = 0.0
            return
        rotation = pybullet.getMatrixFromQuaternion(state[1])
        points = []
        load = slip_along = slip_across = grip = 0.0
        for contact in contacts:
            mine_is_a = contact[1] == self._uid
            point = contact[5] if mine_is_a else contact[6]
            normal = contact[7]
            if not mine_is_a:
                normal = (-normal[0], -normal[1], -normal[2])
            directions = _belt_directions(rotation, normal)
            if directions is None:
                continue
            forward, sideways, runs = directions
            other = (contact[2], contact[4]) if mine_is_a else (contact[1], contact[3])
            dynamic, friction = self._surface(other)
            velocity = _point_velocity(point, state[0], state[6], state[7])
            if dynamic:
                moving = self._velocity_of(other, point)
                velocity = (
                    velocity[0] - moving[0],
                    velocity[1] - moving[1],
                    velocity[2] - moving[2],
                )
            along = _dot(velocity, forward) - (speed if runs else 0.0)
            across = _dot(velocity, sideways)
            force = contact[9]
            load += force
            grip += force * friction
            slip_along += force * along
            slip_across += force * across
            points.append((point, force, friction, along, across, forward, sideways, other))
        if load <= 0.0 or grip <= 0.0:
            track.along = track.across = 0.0
            return
        self._stretch(track, slip_along / load, slip_across / load, grip)
        for point, force, friction, along, across, forward, sideways, other in points:
            self._push(
                track,
                point,
                force / load,
                force * friction,
                along,
                across,
                forward,
                sideways,
                other,
            )

    def _stretch(self, track: _Track, slip_along: float, slip_across: float, grip: float) -> None:
        """Move the stick state with the mean slip, at most to where the whole track slips."""
        config = self._config
        track.along += slip_along * self._step_size
        track.across += slip_across * self._step_size
        excess = math.hypot(
            track.along * config.stiffness / (config.friction * grip),
            track.across * self._lateral_stiffness / (config.lateral_friction * grip),
        )
        if excess > 1.0:
            track.along /= excess
            track.across /= excess

    def _push(
        self,
        track: _Track,
        point: Vector,
        share: float,
        grip: float,
        along: float,
        across: float,
        forward: Vector,
        sideways: Vector,
        other: Tuple[int, int],
    ) -> None:
        """Apply the friction force of one contact point, and its reaction."""
        if grip <= 0.0:
            return
        config = self._config
        force_along = -share * (config.stiffness * track.along + config.damping * along)
        force_across = -share * (
            self._lateral_stiffness * track.across + self._lateral_damping * across
        )
        excess = math.hypot(
            force_along / (config.friction * grip),
            force_across / (config.lateral_friction * grip),
        )
        if excess > 1.0:
            force_along /= excess
            force_across /= excess
        force = (
            force_along * forward[0] + force_across * sideways[0],
            force_along * forward[1] + force_across * sideways[1],
            force_along * forward[2] + force_across * sideways[2],
        )
        pybullet.applyExternalForce(
            self._uid,
            track.link,
            force,
            point,
            pybullet.WORLD_FRAME,
            physicsClientId=self._client,
        )
        if self._surface(other)[0]:
            pybullet.applyExternalForce(
                other[0],
                other[1],
                (-force[0], -force[1], -force[2]),
                point,
                pybullet.WORLD_FRAME,
                physicsClientId=self._client,
            )

    def _surface(self, other: Tuple[int, int]) -> Tuple[bool, float]:
        """Whether a touched link can move, and its friction coefficient."""
        known = self._surfaces.get(other)
        if known is None:
            info = pybullet.getDynamicsInfo(*other, physicsClientId=self._client)
            known = self._surfaces[other] = (info[0] > 0.0, info[1])
        return known

    def _velocity_of(self, other: Tuple[int, int], point: Vector) -> Vector:
        """Velocity of a point that moves with a touched link (m/s)."""
        uid, link = other
        if link < 0:
            linear, angular = pybullet.getBaseVelocity(uid, physicsClientId=self._client)
            centre = pybullet.getBasePositionAndOrientation(uid, physicsClientId=self._client)[0]
        else:
            state = pybullet.getLinkState(
                uid, link, computeLinkVelocity=1, physicsClientId=self._client
            )
            centre, linear, angular = state[0], state[6], state[7]
        return _point_velocity(point, centre, linear, angular)


def _belt_directions(
    rotation: Sequence[float], normal: Vector
) -> Optional[Tuple[Vector, Vector, bool]]:
    """Directions along and across the belt at a contact, and whether the belt runs there.

    Parameters
    ----------
    rotation : sequence of 9 floats
        Of the track's link in the world, row by row; its y axis is the axle.
    normal : Vector
        Of the contact, into the track.

    Returns
    -------
    tuple or None
        None where the directions are not defined.
    """
    forward = _cross((rotation[1], rotation[4], rotation[7]), normal)
    length = math.sqrt(_dot(forward, forward))
    runs = length >= _SIDE_CONTACT
    if not runs:
        # The flank: plain friction, in the plane of contact, along the track's x axis.
        axis = (rotation[0], rotation[3], rotation[6])
        away = _dot(axis, normal)
        forward = (
            axis[0] - away * normal[0],
            axis[1] - away * normal[1],
            axis[2] - away * normal[2],
        )
        length = math.sqrt(_dot(forward, forward))
        if length < 1e-6:
            return None
    forward = (forward[0] / length, forward[1] / length, forward[2] / length)
    return forward, _cross(normal, forward), runs


def _point_velocity(point: Vector, centre: Vector, linear: Vector, angular: Vector) -> Vector:
    turned = _cross(angular, (point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]))
    return (linear[0] + turned[0], linear[1] + turned[1], linear[2] + turned[2])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
