"""Evaluation of conditions over the truth stream."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from telex_control.common.geometry.quaternions import Vector3, invert, rotate

from ..exercises import conditions as data
from ..exercises.conditions import ROBOT, TOOL, Condition
from ..exercises.model import Zone
from .truth import Contact, World

SLACK = 1e-6
"""Rounding of sim time (s)."""
_SETTLING = 0.1
"""How far a robot and its tool may move by themselves once they have been put back (m)."""


@dataclass
class Context:
    """What conditions look at beside the world.

    Attributes
    ----------
    time : float
        Sim time of the sample (s).
    began : float, optional
        When the repetition began (s); None: it has not.
    places : dict of str to tuple of 3 floats
        Where things were when the repetition was made ready (m); of a further robot "NAME robot"
        and "NAME tool".
    answers : dict of str to bool or None
        Answered questions, and whether rightly; None: nobody knows.
    counts : dict of str to int
        Events of this repetition, whichever robot they are of.
    others : mapping of str to World
        The same world as further robots' truth tells it.
    """

    world: World
    zones: Mapping[str, Zone]
    time: float = 0.0
    began: Optional[float] = None
    places: Dict[str, Vector3] = field(default_factory=dict)
    answers: Dict[str, Optional[bool]] = field(default_factory=dict)
    counts: Dict[str, int] = field(default_factory=dict)
    others: Mapping[str, World] = field(default_factory=dict)

    def of(self, robot: str) -> Context:
        """Return what conditions of a further robot look at; empty: those of the first."""
        if not robot:
            return self
        own = {what: self.places.get(f"{robot} {what}") for what in (ROBOT, TOOL)}
        known = {what: place for what, place in self.places.items() if what not in own}
        known.update((what, place) for what, place in own.items() if place is not None)
        return replace(self, world=self.others[robot], places=known)

    def note_places(self) -> None:
        """Note where everything is now."""
        self.places = self.world.places()
        for name, world in self.others.items():
            for what in (ROBOT, TOOL):
                place = world.position(what)
                if place is not None:
                    self.places[f"{name} {what}"] = place

    def driven(self) -> bool:
        """Whether a robot or its tool has gone from where it was, further than it settles."""
        for robot in ("", *self.others):
            context = self.of(robot)
            for what in (ROBOT, TOOL):
                now, then = context.world.position(what), context.places.get(what)
                if now is not None and then is not None and math.dist(now, then) > _SETTLING:
                    return True
        return False

    def within(self, what: str, zone: str) -> bool:
        """Whether something is in a zone; not, where either is not known."""
        point = self.world.position(what)
        return point is not None and self.contains(zone, point)

    def contains(self, zone: str, point: Vector3) -> bool:
        """Whether a point of the world (m) is in a zone."""
        area = self.zones[zone]
        if area.of:
            frame = self.world.pose(area.of)
            if frame is None:
                return False
            turned = invert(frame)
            x, y, z = rotate(turned[1], point)
            point = (x + turned[0][0], y + turned[0][1], z + turned[0][2])
        return area.contains(point)


class Evaluator:
    """A condition with what it has to remember; ask it at every sample."""

    def __init__(self, condition: Condition) -> None:
        self._seconds = condition.seconds
        self._robot = condition.robot
        self._since: Optional[float] = None
        self._parts = [Evaluator(part) for part in condition.parts]
        self._joined = _JOINED.get(condition.kind)
        self._test: Optional[Test] = None
        if self._joined is None:
            self._test = _TESTS[condition.kind](condition.of)

    def holds(self, context: Context) -> bool:
        """Whether it holds now, and has for as long as is asked.

        All parts are asked, for each has its own time to keep.
        """
        if self._joined is not None:
            now = self._joined([part.holds(context) for part in self._parts])
        else:
            assert self._test is not None
            now = self._test(context.of(self._robot))
        if self._seconds == 0.0:
            return now
        if not now:
            self._since = None
            return False
        if self._since is None:
            self._since = context.time
        return context.time - self._since >= self._seconds - SLACK


Test = Callable[[Context], bool]

_JOINED: Dict[str, Callable[[List[bool]], bool]] = {
    "all": all,
    "any": any,
    "not": lambda parts: not parts[0],
}


def _inside(given: data.Inside) -> Test:
    return lambda context: context.within(given.what, given.zone)


def _joint(given: data.JointWithin) -> Test:
    key = f"{given.object}/{given.joint}"
    low = -math.inf if given.above is None else given.above
    high = math.inf if given.below is None else given.below

    def test(context: Context) -> bool:
        names, sample = context.world.names, context.world.sample
        if names is None or sample is None:
            return False
        if given.object == ROBOT:
            index, values = names.joints.get(given.joint), sample.joints
        else:
            index, values = names.mechanisms.get(key), sample.mechanisms
        return index is not None and low < values[index] < high

    return test


def _latch(given: data.Latch) -> Test:
    key = f"{given.object}/{given.joint}"

    def test(context: Context) -> bool:
        names, sample = context.world.names, context.world.sample
        index = None if names is None else names.latches.get(key)
        return index is not None and sample is not None and sample.latched[index] == given.held

    return test


def _held(given: data.Held) -> Test:
    def test(context: Context) -> bool:
        held, sample = context.world.held, context.world.sample
        fits = bool(held) and given.object in ("", held)
        return fits and sample is not None and (given.above is None or sample.grip > given.above)

    return test


class _Dropped:
    """From a fall until the object is held again."""

    def __init__(self, given: data.Dropped) -> None:
        self._given = given
        self._released: Optional[float] = None
        self._held = False
        self._what = given.object
        self._fell = False

    def __call__(self, context: Context) -> bool:
        world = context.world
        if world.held == self._given.object:
            self._what = world.carried
            self._held, self._fell, self._released = True, False, None
            return False
        place = world.position(self._what)
        if place is None:
            return False
        if self._held:
            self._held, self._released = False, place[2]
        if self._released is not None and self._released - place[2] > self._given.height:
            self._released = None
            self._fell = not any(context.contains(zone, place) for zone in self._given.outside)
        return self._fell


def touched(context: Context, thing: str, group: str) -> List[Contact]:
    """Contacts of a group of links (empty: any) with a thing."""
    names, sample = context.world.names, context.world.sample
    if names is None or sample is None:
        return []
    return [
        contact
        for contact in sample.contacts
        if contact.steps > 0
        and names.thing(contact.object) == thing
        and group in ("", names.groups[contact.group])
    ]


def _touches(given: data.Touches) -> Test:
    return lambda context: any(
        not given.zone or context.contains(given.zone, contact.point)
        for contact in touched(context, given.object, given.group)
    )


def _force(given: data.Force) -> Test:
    return lambda context: any(
        contact.peak > given.above for contact in touched(context, given.object, given.group)
    )


def lean(quaternion: Tuple[float, float, float, float]) -> float:
    """Angle between the z axis of a frame and the vertical (rad)."""
    x, y = quaternion[:2]
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))


def _tilted(given: data.Tilted) -> Test:
    def test(context: Context) -> bool:
        pose = context.world.pose(given.what)
        return pose is not None and lean(pose[1]) > given.angle

    return test


def _moved(given: data.Moved) -> Test:
    def test(context: Context) -> bool:
        now, then = context.world.position(given.what), context.places.get(given.what)
        return now is not None and then is not None and math.dist(now, then) > given.distance

    return test


def _answered(given: data.Answered) -> Test:
    def test(context: Context) -> bool:
        if given.question not in context.answers:
            return False
        return given.right is None or context.answers[given.question] is given.right

    return test


def _elapsed(given: data.Elapsed) -> Test:
    return (
        lambda context: context.began is not None
        and context.time - context.began >= given.seconds - SLACK
    )


def _event(given: data.Event) -> Test:
    return lambda context: context.counts.get(given.name, 0) >= given.count


def _dose(given: data.Dose) -> Test:
    def test(context: Context) -> bool:
        received = context.world.doses.received(given.what)
        return received is not None and received > given.above

    return test


_TESTS: Dict[str, Callable[[Any], Test]] = {
    "inside": _inside,
    "joint": _joint,
    "latch": _latch,
    "held": _held,
    "dropped": _Dropped,
    "touches": _touches,
    "force": _force,
    "tilted": _tilted,
    "moved": _moved,
    "answered": _answered,
    "dose": _dose,
    "elapsed": _elapsed,
    "event": _event,
}
