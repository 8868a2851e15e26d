"""Distances around a robot's arm, and their rates with respect to the arm's joints.

Contacts say that two bodies touch; for an operator who sees through cameras that is too late. Here
the surfaces are looked at that are about to meet, so that whoever leads the arm can slow it down.
Nothing of it changes the simulation.
"""

from __future__ import annotations

from typing import Callable, Dict, Iterator, NamedTuple, Sequence, Set, Tuple

import pybullet

from ..engine.world import Body
from ..robot.self_collision import SelfCollisionConfig
from .geometry import Box, apart, fastest, sphere
from .grasp import grasped_bodies
from .links import Links
from .own import OwnDistances
from .places import Place, WatchedMoment
from .points import ClosestPoints
from .proximity_config import ProximityConfig


class NearPair(NamedTuple):
    """Two bodies that are near to each other.

    Attributes
    ----------
    link, other : str
        What the arm moves, and what it moves it towards.
    touchable : bool
        Whether they may touch: a finger, or what the gripper holds, and something else.
    closing_speed : float
        By the velocities of the arm's joints; above 0 when they approach (m/s).
    """

    place: Place
    link: str
    other: str
    touchable: bool
    closing_speed: float


class Proximity(NamedTuple):
    """Pairs that are near, the nearest first, and where the arm's joints are (rad, m)."""

    positions: Tuple[float, ...]
    pairs: Tuple[NearPair, ...]


class _Found(NamedTuple):
    """A place, and whose: bodies and links by PyBullet's numbers."""

    place: Place
    uid: int
    link: int
    other_uid: int
    other: int


class ProximityMonitor:
    """Watches the distances of one robot.

    Parameters
    ----------
    self_collision : SelfCollisionConfig
        Links that cannot touch each other are not watched.
    """

    def __init__(
        self, body: Body, config: ProximityConfig, self_collision: SelfCollisionConfig
    ) -> None:
        self._body = body
        self._config = config
        self._links = Links(body, config.joints, config.fingers)
        self._points = ClosestPoints(body.client)
        self._own = OwnDistances(body, self._links, self._points, self_collision)
        self._all_joints = range(len(self.joints))
        self._planes: Dict[int, bool] = {}

    @property
    def joints(self) -> Tuple[str, ...]:
        """The arm's joints, in the order of positions and gradients."""
        return self._links.arm

    def measure(self, name_of: Callable[[int], str]) -> Proximity:
        """Take the distances of all pairs that are near, or could soon be.

        Parameters
        ----------
        name_of : callable
            Name of another body by PyBullet's number.
        """
        if not self.joints:
            return Proximity((), ())
        moment = WatchedMoment(self._body, self._links)
        velocities = moment.velocities
        pairs = [
            NearPair(
                found.place,
                self._name(found.uid, found.link, name_of),
                self._name(found.other_uid, found.other, name_of),
                self._is_touchable(found),
                -sum(part * speed for part, speed in zip(found.place.gradient, velocities)),
            )
            for found in sorted(self._find(moment))[: self._config.most_pairs]
        ]
        return Proximity(tuple(moment.positions[: len(self.joints)]), tuple(pairs))

    def _name(self, uid: int, link: int, name_of: Callable[[int], str]) -> str:
        return self._links.names[link] if uid == self._body.uid else name_of(uid)

    def _is_touchable(self, found: _Found) -> bool:
        own = self._body.uid
        if found.uid != own:
            return True
        return found.other_uid != own and found.link in self._links.finger_links

    def _reach(self, speed: float) -> float:
        """Distance up to which what moves at a speed (m/s) counts (m)."""
        config = self._config
        return min(config.near + config.horizon * speed, config.range)

    # --- PyBullet ----------------------------------------------------------------------------

    def _find(self, moment: WatchedMoment) -> Iterator[_Found]:
        own, links = self._body.uid, self._links
        grasped = grasped_bodies(self._body, links.fingers)
        for link in links.moving:
            box = moment.box(link)
            centre, radius = sphere(box)
            motions = moment.motions(links.arm_carriers[link], centre)
            driven = [*motions.values(), moment.base_motion(centre)]
            reach = self._reach(fastest(driven, radius))
            # Against the own body the base's motion brings nothing nearer, but what the joints do
            # may be more than both together.
            reach = max(reach, self._reach(fastest(motions.values(), radius)))
            for uid, other in self._near(box, reach):
                if uid == own:
                    joints = self._own.joints.get((link, other))
                    if joints:
                        parts = [motions[joint] for joint in joints]
                        closer = self._reach(fastest(parts, radius))
                        if not apart(box, moment.box(other), closer):
                            for place in self._own.places(link, other, closer, moment):
                                yield _Found(place, own, link, own, other)
                elif uid not in grasped or link not in links.hand:
                    for place in self._places(own, link, uid, other, box, reach, moment):
                        yield _Found(place, own, link, uid, other)
        for held in sorted(grasped):
            yield from self._find_held(held, moment)

    def _find_held(self, held: int, moment: WatchedMoment) -> Iterator[_Found]:
        """What an object in the gripper is near to, when the hand carries it."""
        body, client = self._body, self._body.client
        # What stands fast, as a valve on its wall, is not carried.
        if pybullet.getDynamicsInfo(held, -1, physicsClientId=client)[0] <= 0.0:
            return
        for link in range(-1, pybullet.getNumJoints(held, physicsClientId=client)):
            box = self._box(held, link)
            centre, radius = sphere(box)
            motions = moment.motions(self._all_joints, centre)
            driven = [*motions.values(), moment.base_motion(centre)]
            reach = self._reach(fastest(driven, radius))
            for uid, other in self._near(box, reach):
                if uid == held or (uid == body.uid and other in self._links.hand):
                    continue
                for place in self._places(held, link, uid, other, box, reach, moment):
                    yield _Found(place, held, link, uid, other)

    def _box(self, uid: int, link: int) -> Box:
        return pybullet.getAABB(uid, link, physicsClientId=self._body.client)

    def _near(self, box: Box, reach: float) -> Sequence[Tuple[int, int]]:
        """Bodies and links whose boxes are within reach of one."""
        low, high = box
        return (
            pybullet.getOverlappingObjects(
                [value - reach for value in low],
                [value + reach for value in high],
                physicsClientId=self._body.client,
            )
            or ()
        )

    def _places(
        self,
        uid: int,
        link: int,
        other_uid: int,
        other: int,
        box: Box,
        reach: float,
        moment: WatchedMoment,
    ) -> Iterator[Place]:
        """Where a link of the arm, or what it holds, is near to another body.

        A held object moves with all of the arm's joints, and its own hull with none.
        """
        # The box of a plane has no end.
        if box[0][2] > reach and self._is_ground(other_uid):
            return
        links, own = self._links, self._body.uid
        carriers: Set[int] = set(self._all_joints if uid != own else links.arm_carriers[link])
        if other_uid == own:
            carriers -= links.arm_carriers[other]
        boxes = (box, self._box(other_uid, other))
        for point in self._points.find((uid, link), (other_uid, other), reach, boxes):
            yield moment.place(point, carriers)

    def _is_ground(self, uid: int) -> bool:
        """Whether a body is the plane at height 0."""
        if uid not in self._planes:
            shapes = pybullet.getCollisionShapeData(uid, -1, physicsClientId=self._body.client)
            self._planes[uid] = any(shape[2] == pybullet.GEOM_PLANE for shape in shapes)
        return self._planes[uid]
