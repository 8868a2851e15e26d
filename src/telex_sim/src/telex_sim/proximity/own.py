"""Distances between links of the same robot, looked at again only when they may have changed."""

from __future__ import annotations

from typing import Dict, FrozenSet, Iterator, List, NamedTuple, Sequence, Tuple

from ..engine.world import Body
from ..robot.self_collision import SelfCollisionConfig
from .links import Links
from .places import Place, WatchedMoment
from .points import ClosestPoints

_STALE = 0.1
"""Share of its distance that a pair may move before the distance is taken anew; until then it
follows its gradient."""
_AHEAD = 0.05
"""How much further than asked for a pair is searched (m), so that it can be left alone after."""


class _Record(NamedTuple):
    """What was found of a pair, and where the robot's joints were then."""

    places: Tuple[Place, ...]
    searched: float  # m; what is not among the places is further away
    positions: Sequence[float]


class OwnDistances:
    """The pairs of a robot's links that the arm moves against each other.

    Attributes
    ----------
    joints : dict of pair of int to frozenset of int
        By pair of links, the outer one first: the arm's joints that move one against the other.
    """

    def __init__(
        self,
        body: Body,
        links: Links,
        points: ClosestPoints,
        self_collision: SelfCollisionConfig,
    ) -> None:
        self._body = body
        self._points = points
        self._records: Dict[Tuple[int, int], _Record] = {}
        self.joints: Dict[Tuple[int, int], FrozenSet[int]] = {}
        self._levers: Dict[Tuple[int, int], List[Tuple[int, float]]] = {}
        for outer, inner in links.watched_pairs(self_collision):
            self.joints[outer, inner] = links.arm_carriers[outer] - links.arm_carriers[inner]
            self._levers[outer, inner] = [
                (joint, links.longest_lever(outer, joint) + links.longest_lever(inner, joint))
                for joint in links.carriers[outer] ^ links.carriers[inner]
            ]

    def places(
        self, outer: int, inner: int, reach: float, moment: WatchedMoment
    ) -> Iterator[Place]:
        """Where two links are within `reach` (m) of each other."""
        pair = (outer, inner)
        record = self._records.get(pair)
        if record is None or not self._holds(pair, record, reach, moment.positions):
            record = self._search(outer, inner, reach + _AHEAD, moment)
            self._records[pair] = record
        for place in record.places:
            distance = place.distance + sum(
                part * (now - then)
                for part, now, then in zip(place.gradient, moment.positions, record.positions)
            )
            if distance <= reach:
                yield place._replace(distance=distance)

    def _holds(
        self, pair: Tuple[int, int], record: _Record, reach: float, positions: Sequence[float]
    ) -> bool:
        moved = sum(
            lever * abs(positions[joint] - record.positions[joint])
            for joint, lever in self._levers[pair]
        )
        nearest = min((place.distance for place in record.places), default=record.searched)
        return moved <= _STALE * nearest and record.searched - moved >= reach

    def _search(self, outer: int, inner: int, reach: float, moment: WatchedMoment) -> _Record:
        uid, boxes = self._body.uid, (moment.box(outer), moment.box(inner))
        places = [
            moment.place(point, self.joints[outer, inner])
            for point in self._points.find((uid, outer), (uid, inner), reach, boxes)
        ]
        return _Record(tuple(places), reach, moment.positions)
