"""Links of a robot's body, and the joints that carry them."""

from __future__ import annotations

import math
from typing import Any, Collection, Dict, FrozenSet, Iterator, List, Sequence, Set, Tuple

import pybullet

from telex_control.common.params import ConfigError

from ..engine.world import Body
from ..robot.self_collision import SelfCollisionConfig
from .geometry import Axis, Box, turned

_FIXED = pybullet.JOINT_FIXED


class Links:
    """The solid links of a robot, and the joints that carry them.

    Joints are known by their place in `joints`.

    Parameters
    ----------
    arm : sequence of str
        Names of the joints that count; they come first.
    fingers : sequence of sequence of str
        Names of the joints of each finger.

    Attributes
    ----------
    joints : list of int
        PyBullet's indices of all joints that move solid links.
    arm : tuple of str
        Those of `arm` that the robot has: the first of `joints`.
    names : dict of int to str
        Of all links.
    carriers : dict of int to frozenset of int
        The joints that carry a link.
    arm_carriers : dict of int to frozenset of int
        Those of them that are of the arm: of an inner link, the first of an outer one's.
    fingers : list of list of int
        The links of each finger.
    hand : frozenset of int
        The fingers, and what they sit on.
    moving : list of int
        The solid links that the arm carries.

    Raises
    ------
    ConfigError
        The joints of `arm` do not carry one another.
    """

    def __init__(self, body: Body, arm: Sequence[str], fingers: Sequence[Sequence[str]]) -> None:
        self._body = body
        self.names = {index: name for name, index in body.links.items()}
        self.arm = tuple(name for name in arm if name in body.joints)
        infos = {
            index: pybullet.getJointInfo(body.uid, index, physicsClientId=body.client)
            for index in body.joints.values()
        }
        above = {index: body.links[body.parents[joint]] for joint, index in body.joints.items()}
        solid = [index for index in self.names if self._is_solid(index)]
        carrying = {
            joint for link in solid for joint in _way(link, above) if infos[joint][2] != _FIXED
        }
        first = [body.joints[name] for name in self.arm]
        self.joints = first + sorted(carrying - set(first))
        self._infos = [infos[index] for index in self.joints]
        places = {index: place for place, index in enumerate(self.joints)}
        ways = {
            link: [places[joint] for joint in _way(link, above) if joint in places]
            for link in self.names
        }
        self.carriers: Dict[int, FrozenSet[int]] = {
            link: frozenset(way) for link, way in ways.items()
        }
        count = len(self.arm)
        self.arm_carriers = {
            link: frozenset(joint for joint in way if joint < count) for link, way in ways.items()
        }
        self.fingers = [
            [body.joints[name] for name in finger if name in body.joints] for finger in fingers
        ]
        self.finger_links = frozenset(link for finger in self.fingers for link in finger)
        bases = {self.arm_carriers[link] for link in self.finger_links}
        self.hand = frozenset(link for link in solid if self.arm_carriers[link] in bases)
        self.moving = [link for link in solid if self.arm_carriers[link]]
        for inner, outer in zip(first, first[1:]):
            if inner not in _way(outer, above):
                raise ConfigError(
                    f"proximity/joints: '{self.names[inner]}' does not carry "
                    f"'{self.names[outer]}'; the joints of one arm, from its base outwards, are "
                    "needed"
                )
        self._solid = solid
        self._parents = above
        self._levers = {link: self._longest_levers(link, ways[link]) for link in solid}

    def _is_solid(self, link: int) -> bool:
        body = self._body
        return bool(pybullet.getCollisionShapeData(body.uid, link, physicsClientId=body.client))

    def box(self, link: int) -> Box:
        """Box around a link, along the world's axes."""
        return pybullet.getAABB(self._body.uid, link, physicsClientId=self._body.client)

    def is_prismatic(self, joint: int) -> bool:
        """Whether a joint moves along its axis."""
        return bool(self._infos[joint][2] == pybullet.JOINT_PRISMATIC)

    def arm_axes(self) -> List[Axis]:
        """Axes of the arm's joints as they are now."""
        states = self._states(self.joints[: len(self.arm)])
        # PyBullet tells an axis in the frame of the link's inertia, whose rotation is the second
        # value; the link's own frame, which stands on the axis, is the fifth and sixth.
        return [
            Axis(
                state[4],
                turned(pybullet.getMatrixFromQuaternion(state[1]), self._infos[joint][13]),
                self.is_prismatic(joint),
            )
            for joint, state in enumerate(states)
        ]

    def _states(self, links: Sequence[int]) -> Sequence[Any]:
        body = self._body
        return pybullet.getLinkStates(
            body.uid, links, computeForwardKinematics=1, physicsClientId=body.client
        )

    def _longest_levers(self, link: int, way: Sequence[int]) -> Dict[int, float]:
        """What no point of a link exceeds in speed by a unit velocity of each carrier.

        The length of the way from the joint to the link's furthest point, which bends and turns of
        the joints between do not change; joints that slide may lengthen it by their stroke.
        """
        levers: Dict[int, float] = {}
        if link < 0:
            return levers
        place = self._states([link])[0][4]
        low, high = self.box(link)
        length = math.dist((0.0,) * 3, [max(b - p, p - a) for a, b, p in zip(low, high, place)])
        for joint in way:
            origin = self._states([self.joints[joint]])[0][4]
            length += math.dist(origin, place)
            levers[joint] = length
            place = origin
            if self.is_prismatic(joint):
                levers[joint] = 1.0
                length += abs(self._infos[joint][9] - self._infos[joint][8])
        return levers

    def longest_lever(self, link: int, joint: int) -> float:
        """Speed that no point of a link exceeds by a unit velocity of a joint, in any posture."""
        return self._levers[link].get(joint, 0.0)

    def watched_pairs(self, self_collision: SelfCollisionConfig) -> Iterator[Tuple[int, int]]:
        """Pairs of links whose distance the arm's joints change, the outer one first.

        Parents are left out, as PyBullet leaves out their contacts.
        """
        if not self_collision.enabled:
            return
        apart: Set[FrozenSet[str]] = {
            frozenset(pair.links) for pair in self_collision.disabled_pairs
        }
        for first in self._solid:
            for second in self._solid:
                ours, theirs = self.arm_carriers[first], self.arm_carriers[second]
                outer = (len(ours), first) > (len(theirs), second)
                if not outer or ours == theirs or second == self._parents.get(first):
                    continue
                if frozenset((self.names[first], self.names[second])) not in apart:
                    yield first, second


def _way(link: int, above: Dict[int, int]) -> Collection[int]:
    """Joints from a link down to the root; each has the index of the link that it carries."""
    way = []
    while link >= 0:
        way.append(link)
        link = above[link]
    return way
