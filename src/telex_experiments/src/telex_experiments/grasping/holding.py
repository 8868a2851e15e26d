"""Holding what the hand was given: still, shaken, driven, and at the limit of friction."""

from __future__ import annotations

import contextlib
import math
from typing import Any, Callable, Iterator, List, NamedTuple

from .rig import FRONT, GraspRig, GripChange, Pose
from .things import GRAVITY, PAD_FRICTION, Thing

LET_GO = 0.5
"""From the moment at which the hand has an object to itself until its slip counts (s)."""
CALM = 1.5
"""After that, until its speed counts as jitter (s): the arm settles under the new load."""
LOST = 0.03
"""An object that has moved further in the hand (m) is no longer held."""


class Hold(NamedTuple):
    """How something was held.

    Attributes
    ----------
    slip : GripChange
        From begin to end.
    jitter : float
        Rms speed of the object's centre of mass (m/s).
    lost : bool
        Whether it left the hand.
    """

    slip: GripChange
    jitter: float
    lost: bool


class Sway(NamedTuple):
    """How something moved in the hand while the hand moved: at most, and for good."""

    most: float
    left: float


def rig_for(thing: Thing, pitch: float = FRONT, **options: Any) -> GraspRig:
    """A robot with its hand open for a thing."""
    return GraspRig(pitch=pitch, opening=thing.opening, **options)


def force_error(rig: GraspRig, force: float) -> float:
    """Grip what is held with another force (N); returns by how much that of a pad is off (N)."""
    rig.grip(force)
    rig.wait(0.5)
    return max(abs(pad.normal_force - force) for pad in rig.contact().pads)


def hold(rig: GraspRig, name: str, seconds: float) -> Hold:
    """Hold an object still."""
    rig.wait(LET_GO)
    before = rig.held_at(name)
    squares: List[float] = []
    rig.wait(CALM)
    with _measuring(rig, lambda: squares.append(rig.speed(name) ** 2)):
        rig.wait(seconds - CALM)
    slip = rig.slip(name, before)
    jitter = math.sqrt(sum(squares) / len(squares))
    return Hold(slip, jitter, slip.distance > LOST or not rig.contact().object)


def sway(rig: GraspRig, name: str, act: Callable[[], None], rest: float = 0.5) -> Sway:
    """See how far an object moves in the hand while something happens, and once it is over."""
    before: Pose = rig.held_at(name)
    most = [0.0]

    def look() -> None:
        most[0] = max(most[0], rig.slip(name, before).distance)

    with _measuring(rig, look):
        act()
        rig.wait(rest)
    return Sway(most[0], rig.slip(name, before).distance)


def block(mass: float, edge: float = 0.06) -> Thing:
    """A cube of any mass (kg)."""
    return Thing("cube", mass, edge, 0.5 * edge, parameters={"edge": edge})


def at_limit(force: float, share: float, seconds: float) -> Hold:
    """Give the hand what weighs a share of Coulomb's limit, 2 mu N / g."""
    thing = block(share * 2.0 * PAD_FRICTION * force / GRAVITY)
    with rig_for(thing) as rig:
        name = rig.present(thing.entry(), force)
        return hold(rig, name, seconds)


@contextlib.contextmanager
def _measuring(rig: GraspRig, look: Callable[[], None]) -> Iterator[None]:
    """Call something after every step."""
    rig.each_step.append(look)
    try:
        yield
    finally:
        rig.each_step.remove(look)
