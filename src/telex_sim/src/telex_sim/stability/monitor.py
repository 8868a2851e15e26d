"""Watches one tracked robot: its attitude, how far it is from tipping over, whether it is stuck."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import pybullet

from telex_control.common.geometry.quaternions import rpy_from_rows
from telex_control.common.stateful import Stateful
from telex_control.hardware.hardware_interface import VelocityJointInterface

from ..engine.contacts import Contact, contacts, directed_contacts
from ..engine.world import GRAVITY, Body
from ..robot.robot import Robot
from .footholds import FootholdFinder
from .force_angle import ForceAngle, Vector, force_angle, force_angles, support_polygon
from .mobility_watch import StuckDetector, TipOverDetector, TipOverWarning
from .supports import NO_PLACES, Supports
from .tipping import NO_FOOTHOLDS, TippingAngle, tipping_angle

_RESTS = 0.002
"""Distance (m) from the plane of contact up to which a corner of a belt can lie on the ground."""
_OUTSIDE = 0.002
"""How far beside a belt (m) is looked for what its corners lie on."""
_CARRIES = 0.2
"""Least upward part of a contact's normal that holds the robot up, and downward part of one that
holds it down.
"""
_ENOUGH = math.radians(35.0)
"""Tipping angle (rad) over an edge from which it is all the same what else would hold the robot."""
_RECENT = 2.5
"""Age, in periods of `StabilityMonitor.observe`, up to which the last momentum counts: two periods,
and not a matter of rounding.
"""


@dataclass(frozen=True)
class Attitude:
    """How a robot stands (rad): REP 103, roll about x, pitch about y, and its whole tilt."""

    roll: float
    pitch: float
    tilt: float


@dataclass(frozen=True)
class Margin:
    """How far a robot is from tipping over.

    Attributes
    ----------
    margin : float
        Force-angle measure; 1 as the robot stands level in its start pose, 0 where it tips.
    angle : float
        By how much the net force may turn before the robot tips (rad).
    direction : float
        Where it would tip, in its x-y plane (rad).
    support : list of Vector
        Corners of the support polygon in the robot's frame (m).
    center_of_mass : Vector
        Of the robot, in its frame (m).
    tipping : TippingAngle, optional
        With what would catch it, as far as less than 35 degrees are left; None where less than two
        points carry it.
    """

    margin: float
    angle: float
    direction: float
    support: List[Vector]
    center_of_mass: Vector
    tipping: Optional[TippingAngle]


class StabilityMonitor(Stateful):
    """Looks at a robot with belts now and then, in the simulation's thread.

    Inertial forces are the mean since the last margin, unless that is long ago.

    Parameters
    ----------
    robot : Robot
        Placed in a world, level in its start pose: the margin of this is 1.

    Attributes
    ----------
    warning : TipOverWarning
        Of the margins that were asked for.
    """

    SAVED = ("_inertial", "_momentum", "_period", "attitude")
    SAVED_TIMES = ("_observed",)
    SAVED_PARTS = ("_stuck", "_tip_over", "warning")

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._belts = list(robot.config.tracks.belts.items())
        self._begin(robot.body)

    def _begin(self, body: Body) -> None:
        """Watch `body`, which stands where the robot begins."""
        self._starts = self._robot.starts
        self._attach(body)
        config = self._robot.config.stability
        self._tip_over = TipOverDetector(config)
        self.warning = TipOverWarning(config)
        self._stuck = StuckDetector(config, 0.5 * float(np.ptp(self._footprint_in_base()[:, 1])))
        self.attitude = _attitude(_rotation(body.base_pose()[1]))
        # Another scene may have the robot start in another pose.
        self._reference = self._reference_measure()

    @property
    def tipped(self) -> bool:
        """Whether the robot lies on its side or back."""
        return self._tip_over.tipped

    @property
    def stuck(self) -> bool:
        """Whether its belts are told to run and do not get it away."""
        return self._stuck.stuck

    def _attach(self, body: Body) -> None:
        """Learn what does not change of a body: its masses, and the corners of its tracks."""
        client = body.client
        self._body = body
        self._links = [index for index in body.links.values() if index >= 0]
        info = [
            pybullet.getDynamicsInfo(body.uid, index, physicsClientId=client)
            for index in (-1, *self._links)
        ]
        self._masses = np.array([each[0] for each in info])
        self._moments = np.array([each[2] for each in info])
        tracks = {body.links[body.parents[joint]] for joint, _ in self._belts}
        self._rows = {index: row for row, index in enumerate((-1, *self._links))}
        # None of a shape that PyBullet has no mesh of, such as a box or a sphere.
        self._corners: Dict[int, np.ndarray] = {
            link: np.reshape(
                pybullet.getMeshData(body.uid, link, physicsClientId=client)[1], (-1, 3)
            )
            for link in tracks
        }
        # The same as one array, for all at once.
        self._slots = {link: slot for slot, link in enumerate(self._corners)}
        most = max(map(len, self._corners.values()))
        self._outlines = np.full((len(self._corners), most, 3), math.nan)
        # A bit outside of the belt, across it: a ray that begins in the robot would end there.
        self._outwards = np.zeros_like(self._outlines)
        for slot, corners in enumerate(self._corners.values()):
            if len(corners):
                aside = np.sign(corners - corners.mean(axis=0)) * (0.0, _OUTSIDE, 0.0)
                self._outlines[slot, : len(corners)] = corners
                self._outwards[slot, : len(corners)] = aside
        self._footholds = FootholdFinder(
            body,
            {
                link: (float(corners[:, 1].min()), float(corners[:, 1].max()))
                for link, corners in self._corners.items()
                if len(corners)
            },
        )
        self._momentum: Optional[Tuple[float, np.ndarray, np.ndarray]] = None
        self._inertial = (np.zeros(3), np.zeros(3))
        self._observed: Optional[float] = None
        self._period = math.inf

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        if self._robot.body is not self._body:
            self._begin(self._robot.body)
        self._starts = self._robot.starts
        super().restore_state(saved, elapsed)
        if self._momentum is not None:
            time, momentum, turning = self._momentum
            self._momentum = (time + elapsed, momentum, turning)

    def observe(self, time: float) -> None:
        """Look at attitude and progress at `time` (s); to be called at a steady rate."""
        robot = self._robot
        if robot.starts != self._starts:
            self._begin(robot.body)
        position, orientation = robot.body.base_pose()
        rotation = _rotation(orientation)
        self.attitude = _attitude(rotation)
        self._tip_over.update(time, self.attitude.tilt)
        heading = math.atan2(rotation[1, 0], rotation[0, 0])
        self._stuck.update(time, position, heading, self._commanded_speeds())
        if self._observed is not None:
            self._period = time - self._observed
        self._observed = time

    def _commanded_speeds(self) -> List[float]:
        """Speed (m/s) that each belt is told to run at; 0 while its brake holds it.

        A belt that is commanded by effort is told no speed.
        """
        speeds = []
        for joint, radius in self._belts:
            drive = self._robot.hw.drive(joint)
            told = not drive.braked and drive.interface is VelocityJointInterface
            speeds.append(drive.handle.command * radius if told else 0.0)
        return speeds

    def margin(self, time: float) -> Margin:
        """How far the robot is from tipping over at `time` (s)."""
        if self._robot.starts != self._starts:
            self._begin(self._robot.body)
        position, orientation = self._body.base_pose()
        base = _rotation(orientation)
        centers, rotations, linear, angular = self._motion()
        mass = float(self._masses.sum())
        center = self._masses @ centers / mass
        # Momentum, and its moment about the centre of mass.
        momenta = self._masses[:, None] * linear
        momentum = momenta.sum(axis=0)
        turning = _moment(centers - center, momenta)
        spin = np.einsum("nij,ni->nj", rotations, angular) * self._moments
        turning += np.einsum("nij,nj->i", rotations, spin)
        force, moment = np.array((0.0, 0.0, -mass * GRAVITY)), np.zeros(3)
        supports, pushes = self._contacts(centers, rotations)
        for point, push in pushes:
            force += push
            moment += np.cross(point - center, push)
        rows = {link: self._rows[link] for link in self._corners}
        *near, gaps = self._footholds.touching(
            {link: centers[row] for link, row in rows.items()},
            {link: rotations[row][:, 1] for link, row in rows.items()},
        )
        touching = gaps < _RESTS
        supports.add_likely(*(each[touching] for each in near))
        polygon = supports.polygon()
        own, loads = _vector(center), (_vector(force), _vector(moment))
        about_x, about_y, _ = _vector(base.T @ angular[0])
        enough = self._enough(math.hypot(about_x, about_y))
        # What else nearly bears it, or would catch it, takes long to find, and only ever adds to
        # the rotations.
        edges, footholds = force_angles(polygon, own, *loads), NO_FOOTHOLDS
        if not edges or _weak(edges, enough):
            supports.add_likely(*(each[~touching] for each in near))
            edges = force_angles(supports.polygon(), own, *loads)
            footholds = self._footholds.beyond(_weak(edges, enough))
        tipping = tipping_angle(edges, own, footholds, base.T.tolist())
        inertial_force, inertial_moment = self._inertia(time, momentum, turning)
        force, moment = force + inertial_force, moment + inertial_moment
        weakest = force_angle(polygon, own, _vector(force), _vector(moment))
        corners = (np.reshape(polygon, (-1, 3)) - position) @ base
        support = [(x, y, z) for x, y, z in corners.tolist()]
        own_center = _vector(base.T @ (center - position))
        if weakest is None:
            self.warning.update(time, None, 0.0)
            return Margin(0.0, 0.0, 0.0, support, own_center, None)
        self.warning.update(time, tipping, weakest.measure / self._reference, (about_x, about_y))
        return Margin(
            margin=weakest.measure / self._reference,
            angle=weakest.angle,
            direction=_direction(base, weakest),
            support=support,
            center_of_mass=own_center,
            tipping=tipping,
        )

    def _enough(self, rate: float) -> float:
        """Rotation (rad) that warns of nothing in a robot that turns at `rate` (rad/s)."""
        config = self._robot.config.stability
        foreseen = config.warning_sideways + config.warning_sideways_foresight * rate
        return max(_ENOUGH, config.warning_ahead, foreseen)

    def _inertia(
        self, time: float, momentum: np.ndarray, turning: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray]:
        """Force and moment of inertia (N, N m): their mean since the last call.

        It is none if nobody has asked for long: such a mean tells nothing of now. While time
        stands still, as in a pause, it stays what it was.
        """
        last = self._momentum
        if last is None or time != last[0]:
            self._momentum = (time, momentum, turning)
            self._inertial = (np.zeros(3), np.zeros(3))
            if last is not None and 0.0 < time - last[0] <= _RECENT * self._period:
                lasted = time - last[0]
                self._inertial = ((last[1] - momentum) / lasted, (last[2] - turning) / lasted)
        force, moment = self._inertial
        return force.copy(), moment.copy()

    def _motion(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Centre of mass, principal axes, linear and angular velocity of all links.

        Returns
        -------
        tuple of arrays
            (n, 3), (n, 3, 3), (n, 3), (n, 3), in the world; the root link comes first.
        """
        uid, client = self._body.uid, self._body.client
        center, orientation = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)
        velocity, turning = pybullet.getBaseVelocity(uid, physicsClientId=client)
        states = pybullet.getLinkStates(
            uid,
            self._links,
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=client,
        )
        matrix = pybullet.getMatrixFromQuaternion
        rows = [(center, matrix(orientation), velocity, turning)]
        rows += [(state[0], matrix(state[1]), state[6], state[7]) for state in states]
        centers, rotations, linear, angular = (np.array(column) for column in zip(*rows))
        return centers, rotations.reshape(-1, 3, 3), linear, angular

    def _contacts(
        self, centers: np.ndarray, rotations: np.ndarray
    ) -> Tuple[Supports, List[Tuple[np.ndarray, np.ndarray]]]:
        """What holds the robot up, and what else pushes it.

        Returns
        -------
        supports : Supports
            Contact points under the tracks and the hull; where tracks lean against what stands
            fast, such as a step that they are about to climb, and which the robot cannot tip
            through; and corners of belts that lie on something: PyBullet gives no more than a few
            points of a face.
        pushes : list of (point, force)
            On the arm, which may hold a load, from the side by what can move, and from above
            (m, N).
        """
        supports: List[Vector] = []
        planes: Dict[int, List[Tuple[Vector, Vector]]] = {}
        pushed = False
        for contact in contacts(self._body):
            if not self._supports(contact):
                pushed = True
                continue
            supports.append(contact.point)
            if contact.link in self._corners and contact.normal[2] >= _CARRIES:
                _add_plane(planes.setdefault(contact.link, []), contact.point, contact.normal)
        pushes = [
            (np.array(contact.point), _force(contact))
            for contact in (directed_contacts(self._body) if pushed else ())
            if not self._supports(contact)
        ]
        found = Supports(self._body)
        found.add_likely(*self._resting_corners(planes, centers, rotations))
        found.add(supports)
        return found, pushes

    def _supports(self, contact: Contact) -> bool:
        """Whether a contact holds the robot up or stops its fall, and does not push it about."""
        upward = contact.normal[2]
        if contact.link in self._corners:
            return upward >= _CARRIES or (upward > -_CARRIES and self._stands_fast(*contact.other))
        return upward >= _CARRIES and contact.link == -1

    def _stands_fast(self, body: int, link: int) -> bool:
        """Whether a link (PyBullet's numbers) is part of the surroundings that nothing moves."""
        mass: float = pybullet.getDynamicsInfo(body, link, physicsClientId=self._body.client)[0]
        return mass == 0.0

    def _resting_corners(
        self,
        planes: Dict[int, List[Tuple[Vector, Vector]]],
        centers: np.ndarray,
        rotations: np.ndarray,
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Foremost and last corners of touching tracks in a plane, and rays to what is below.

        Returns
        -------
        corners, begins, ends : ndarray, shape (n, 3)
            As `Supports.add_likely` takes them.
        """
        faces = [
            (link, *face)
            for link, found in planes.items()
            if len(self._corners[link])
            for face in found
        ]
        if not faces:
            return NO_PLACES, NO_PLACES, NO_PLACES
        links, points, normals = ([*column] for column in zip(*faces))
        rows, slots = [self._rows[link] for link in links], [self._slots[link] for link in links]
        turns, places, normal = rotations[rows], centers[rows], np.array(normals)
        chosen = _ends(
            self._outlines[slots],
            np.einsum("kij,ki->kj", turns, normal),
            ((points - places) * normal).sum(axis=1),
        )
        # Of several planes through one corner the first.
        ends: Dict[Tuple[int, int], int] = {}
        for face, corners in enumerate(chosen):
            for corner in corners:
                ends.setdefault((slots[face], corner), face)
        if not ends:
            return NO_PLACES, NO_PLACES, NO_PLACES
        which, of_face = tuple(zip(*ends)), list(ends.values())
        turn = turns[of_face]
        found: np.ndarray = np.einsum("kij,kj->ki", turn, self._outlines[which]) + places[of_face]
        outside = np.einsum("kij,kj->ki", turn, self._outwards[which])
        reach = 2.0 * _RESTS * normal[of_face]
        return found, found + outside + reach, found + outside - reach

    def _footprint_in_base(self) -> np.ndarray:
        """Corners of all tracks in the robot's frame (m), shape (n, 3)."""
        centers, rotations, _, _ = self._motion()
        position, orientation = self._body.base_pose()
        found = []
        for link, corners in self._corners.items():
            row = self._rows[link]
            if len(corners):
                found.append(corners @ rotations[row].T + centers[row])
            else:
                box = pybullet.getAABB(self._body.uid, link, physicsClientId=self._body.client)
                found.append(np.array(list(product(*zip(*box)))))
        return (np.concatenate(found) - position) @ _rotation(orientation)

    def _reference_measure(self) -> float:
        """Force-angle measure of the robot, level and at rest, on the rectangle of its tracks."""
        low, high = (extreme(self._footprint_in_base(), axis=0) for extreme in (np.min, np.max))
        position, orientation = self._body.base_pose()
        mass = float(self._masses.sum())
        center = self._masses @ self._motion()[0] / mass
        polygon = support_polygon(
            [(x, y, low[2]) for x in (low[0], high[0]) for y in (low[1], high[1])]
        )
        level = _vector((center - position) @ _rotation(orientation))
        weight = (0.0, 0.0, -mass * GRAVITY)
        weakest = force_angle(polygon, level, weight, (0.0, 0.0, 0.0))
        assert weakest is not None
        return weakest.measure


def _ends(corners: np.ndarray, normals: np.ndarray, depths: np.ndarray) -> List[List[int]]:
    """Foremost and last corner on either side of belts, of those that lie in a plane.

    Parameters
    ----------
    corners : ndarray, shape (n, m, 3)
        Of a belt for each plane, its axle along y (m).
    normals : ndarray, shape (n, 3)
        Of the planes.
    depths : ndarray, shape (n,)
        Of the planes along their normals (m).

    Returns
    -------
    list of list of int
        For each plane up to four numbers of corners; none if it has no corner.
    """
    heights = (corners @ normals[:, :, None])[:, :, 0] - depths[:, None]
    inside = np.abs(heights) < _RESTS
    # Along the belt: at right angles to the axle and to the normal.
    along = corners[:, :, 0] * normals[:, 2:] - corners[:, :, 2] * normals[:, :1]
    columns = []
    for side in (1.0, -1.0):
        aside = np.where(inside, side * corners[:, :, 1], -math.inf)
        edge = aside > aside.max(axis=1, keepdims=True) - _RESTS
        columns += [
            np.where(edge, along, math.inf).argmin(axis=1),
            np.where(edge, along, -math.inf).argmax(axis=1),
        ]
    filled = inside.any(axis=1).tolist()
    return [ends if some else [] for ends, some in zip(np.array(columns).T.tolist(), filled)]


def _add_plane(planes: List[Tuple[Vector, Vector]], point: Vector, normal: Vector) -> None:
    """Add a plane of contact, unless it is one that is there."""
    for origin, other in planes:
        same = sum(a * b for a, b in zip(normal, other)) > 0.999
        if same and abs(sum((a - b) * c for a, b, c in zip(point, origin, other))) < 0.001:
            return
    planes.append((point, normal))


def _weak(edges: Sequence[ForceAngle], enough: float) -> List[ForceAngle]:
    return [edge for edge in edges if edge.angle < enough]


def _moment(places: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Sum of the moments of forces (or momenta) that act at places, both of shape (n, 3)."""
    products = places.T @ forces
    return np.array(
        (
            products[1, 2] - products[2, 1],
            products[2, 0] - products[0, 2],
            products[0, 1] - products[1, 0],
        )
    )


def _force(contact: Contact) -> np.ndarray:
    """What acts on the robot in a contact (N)."""
    return contact.force * np.array(contact.normal) + contact.friction


def _attitude(rotation: np.ndarray) -> Attitude:
    roll, pitch, _ = rpy_from_rows(rotation.tolist())
    return Attitude(
        roll=roll,
        pitch=pitch,
        tilt=math.acos(max(-1.0, min(1.0, rotation[2, 2]))),
    )


def _direction(base: np.ndarray, weakest: ForceAngle) -> float:
    outward = base.T @ np.array([*weakest.outward, 0.0])
    return math.atan2(outward[1], outward[0])


def _rotation(orientation: Sequence[float]) -> np.ndarray:
    return np.array(pybullet.getMatrixFromQuaternion(orientation)).reshape(3, 3)


def _vector(values: np.ndarray) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])
