"""Contacts of a repetition, by pair of link group and thing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Optional, Tuple

from ...exercises.model import Contacts as Allowed
from ..truth import World

APART = 0.5
"""A contact is a new one once the two were apart for so long (s)."""
FIRST = 0.2
"""Of a contact, whose impulse counts (J200); contact beyond it is pushing (s)."""


@dataclass
class _Pair:
    allowed: bool
    seen: float
    count: int = 0
    peak: float = 0.0
    impulse: float = 0.0
    largest_impulse: float = 0.0
    duration: float = 0.0
    pushing: float = 0.0
    touching: bool = False


class ContactRecord:
    """What the robot touched since the repetition began.

    Contacts that there were already when it began are no new ones.
    """

    def __init__(self, allowed: Allowed) -> None:
        self._allowed = allowed
        self._pairs: Dict[Tuple[str, str], _Pair] = {}
        self._began = False

    def sample(self, world: World, time: float, span: float, steps: int) -> List[Dict[str, Any]]:
        """Take a sample.

        Parameters
        ----------
        time : float
            s.
        span : float
            Time since the sample before (s).
        steps : int
            Physics steps since then.

        Returns
        -------
        list of dict
            New contacts that are not allowed: group, object, force (N), point (m).
        """
        sample, names = world.sample, world.names
        assert sample is not None
        assert names is not None
        new = []
        present = set()
        for contact in sample.contacts:
            if contact.steps == 0:
                continue
            key = (names.groups[contact.group], names.thing(contact.object))
            present.add(key)
            pair = self._pairs.get(key)
            if pair is None:
                pair = self._pairs[key] = _Pair(
                    self._allowed.allows(*key), time if not self._began else -APART
                )
            if not pair.touching:
                pair.impulse = pair.duration = 0.0
                if time - pair.seen >= APART:
                    pair.count += 1
                    if not pair.allowed:
                        new.append(
                            {
                                "group": key[0],
                                "object": key[1],
                                "force": contact.peak,
                                "point": list(contact.point),
                            }
                        )
            pair.touching, pair.seen = True, time
            pair.peak = max(pair.peak, contact.peak)
            pair.impulse += contact.impulse
            pair.largest_impulse = max(pair.largest_impulse, pair.impulse)
            share = min(1.0, contact.steps / steps) if steps > 0 else 0.0
            before, pair.duration = pair.duration, pair.duration + share * span
            pair.pushing += max(0.0, pair.duration - FIRST) - max(0.0, before - FIRST)
        for key, pair in self._pairs.items():
            if key not in present:
                pair.touching = False
        self._began = True
        return new

    def figure(self, kind: str, thing: str = "") -> Optional[float]:
        """Return one of the figures contacts, peak_force, impulse and pushing.

        Parameters
        ----------
        thing : str
            Contacts with this one alone, allowed or not; empty: all that are not allowed.
        """
        pairs = list(self._of(thing))
        if kind == "contacts":
            return float(sum(pair.count for pair in pairs))
        if kind == "peak_force":
            return max((pair.peak for pair in pairs), default=0.0)
        if kind == "impulse":
            return max((pair.largest_impulse for pair in pairs), default=0.0)
        return math.fsum(pair.pushing for pair in pairs)

    def _of(self, thing: str) -> Iterator[_Pair]:
        for (_, touched), pair in self._pairs.items():
            if touched == thing if thing else not pair.allowed:
                yield pair
