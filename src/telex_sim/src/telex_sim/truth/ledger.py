"""Contact ledger of a robot: forces and impulses between two samples, for any size of step.

The force of a single step says little: it doubles when the step is halved. A mean over 20 ms and
the impulse of the first 0.2 s do not depend on the step (`../../../../benchmarks/RESULTS.md`,
training).
"""

from __future__ import annotations

from typing import Any, Collection, Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from telex_control.common.stateful import Stateful

WINDOW = 0.02
"""Time over which the force is averaged (s)."""
IMPACT = 0.2
"""Time from the beginning of a contact in which its impulse is summed (s)."""
BASE, TRACKS, ARM, GRIPPER = range(4)
"""Groups of a robot's links."""
FLOOR = -1
ROBOT = -2
"""Numbers of what is no object of the scene: the floor, and another robot."""


class LedgerEntry(NamedTuple):
    """What a group of links and an object did to each other since the last sample.

    Attributes
    ----------
    other : int
        Number of the object, or `FLOOR`, or `ROBOT`.
    peak : float
        Largest mean over `WINDOW` of the sum of the normal forces (N).
    impulse : float
        Of the first `IMPACT` of the contact, as far as it was since the last sample (N s).
    steps : int
        Steps in contact.
    point : tuple of 3 floats
        Mean of the contact points by their forces, in the world (m).
    """

    group: int
    other: int
    peak: float
    impulse: float
    steps: int
    point: Tuple[float, float, float]


class _Pair(Stateful):
    """A group of links and an object in contact: the forces of the last steps, and sums."""

    __slots__ = (
        "age",
        "forces",
        "impulse",
        "peak",
        "place",
        "steps",
        "sum",
        "weight",
        "x",
        "y",
        "z",
    )
    SAVED = __slots__

    def __init__(self, window: int) -> None:
        self.forces = [0.0] * window
        self.place = 0
        self.sum = 0.0
        self.age = 0
        self.clear()

    def clear(self) -> None:
        """Begin the next sample."""
        self.peak = self.impulse = self.weight = self.x = self.y = self.z = 0.0
        self.steps = 0


class ContactLedger(Stateful):
    """Sums a robot's contacts from step to step.

    Parameters
    ----------
    uid : int
        PyBullet's number of the robot's body.
    groups : mapping of int to int
        Group of each of its links, by PyBullet's number.
    step_size : float
        Time of a step (s).

    Attributes
    ----------
    others : mapping of int to int
        Number of the object that a body is of, by PyBullet's number of the body. What is not in it
        is the floor.
    """

    def __init__(self, uid: int, groups: Mapping[int, int], step_size: float) -> None:
        self._uid = uid
        self._groups = groups
        self._step_size = step_size
        self._window = max(1, round(WINDOW / step_size))
        self._impact = max(1, round(IMPACT / step_size))
        self._pairs: Dict[Tuple[int, int], _Pair] = {}
        self.others: Mapping[int, int] = {}

    def note(
        self, own: Iterable[Tuple], held: Iterable[Tuple] = (), holding: Collection[int] = ()
    ) -> None:
        """Take the contacts of a step.

        Parameters
        ----------
        own : iterable of tuple
            PyBullet's, of the robot, which comes first in each.
        held : iterable of tuple
            The same of the bodies that its gripper holds: what they touch, the gripper touches.
        holding : collection of int
            These bodies.
        """
        uid, groups, others = self._uid, self._groups, self.others
        touched: Dict[Tuple[int, int], List[float]] = {}
        for contact in own:
            force, other = contact[9], contact[2]
            if force > 0.0 and other != uid:
                key = (groups[contact[3]], others.get(other, FLOOR))
                _add(touched, key, force, contact[5])
        for contact in held:
            force, other = contact[9], contact[2]
            if force > 0.0 and other != uid and other not in holding:
                _add(touched, (GRIPPER, others.get(other, FLOOR)), force, contact[5])
        self._advance(touched)

    def _advance(self, touched: Dict[Tuple[int, int], List[float]]) -> None:
        pairs, window, step_size = self._pairs, self._window, self._step_size
        for key in touched:
            if key not in pairs:
                pairs[key] = _Pair(window)
        for key, pair in pairs.items():
            found = touched.get(key)
            force = found[0] if found is not None else 0.0
            place = pair.place
            pair.sum += force - pair.forces[place]
            pair.forces[place] = force
            pair.place = place + 1 if place + 1 < window else 0
            if found is None:
                if any(pair.forces):
                    pair.age += 1
                else:
                    pair.age = 0
                    pair.sum = 0.0
                continue
            pair.peak = max(pair.peak, pair.sum)
            if pair.age < self._impact:
                pair.impulse += force * step_size
            pair.age += 1
            pair.steps += 1
            pair.weight += force
            pair.x += found[1]
            pair.y += found[2]
            pair.z += found[3]

    def take(self) -> List[LedgerEntry]:
        """Return what was noted since the last call, in a fixed order."""
        entries = []
        gone = []
        for key in sorted(self._pairs):
            pair = self._pairs[key]
            if pair.steps:
                weight = pair.weight
                point = (pair.x / weight, pair.y / weight, pair.z / weight)
                peak = pair.peak / self._window
                entries.append(LedgerEntry(*key, peak, pair.impulse, pair.steps, point))
                pair.clear()
                # Sums that are added to and taken from for hours would drift.
                pair.sum = sum(pair.forces)
            elif not any(pair.forces):
                gone.append(key)
        for key in gone:
            del self._pairs[key]
        return entries

    def save_state(self) -> Any:
        """Return the present state; see `Stateful.save_state`."""
        return [(key, pair.save_state()) for key, pair in self._pairs.items()]

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        self._pairs.clear()
        for key, state in saved:
            pair = self._pairs[key] = _Pair(self._window)
            pair.restore_state(state, elapsed)

    def forget(self) -> None:
        """Begin anew, as after a reset."""
        self._pairs.clear()


def _add(
    touched: Dict[Tuple[int, int], List[float]],
    key: Tuple[int, int],
    force: float,
    point: Sequence[float],
) -> None:
    x, y, z = point
    sums = touched.get(key)
    if sums is None:
        touched[key] = [force, force * x, force * y, force * z]
        return
    sums[0] += force
    sums[1] += force * x
    sums[2] += force * y
    sums[3] += force * z
