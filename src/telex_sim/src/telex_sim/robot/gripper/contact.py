"""Grasp state of a gripper, from the contacts of its pads: load, friction, slip.

It is what tactile pads would tell that err in nothing. Nothing of it changes the simulation.
"""

from __future__ import annotations

import math
from typing import Callable, Dict, List, NamedTuple, Tuple

import pybullet

from telex_control.common.geometry.vectors import dot
from telex_control.common.stateful import Stateful

from ...engine.contacts import contacts, directed_contacts
from ...engine.world import Body, Vector
from .contact_config import GripperContactConfig

_FURTHEST = 1.0
"""Distance (m) up to which the other pad is looked for."""


class PadContact(NamedTuple):
    """What one pad touches.

    Attributes
    ----------
    objects : tuple of str
        Names of what it presses on.
    normal_force, friction_force : float
        Across and along its surface (N); the second is the magnitude of the sum.
    friction_use : float
        Share of what friction can carry under this normal force; from 1 on it slips.
    slip_speed : float
        Of the pad along what it presses on, the mean over its contacts, by their forces (m/s).
    """

    link: str
    objects: Tuple[str, ...]
    normal_force: float
    friction_force: float
    friction_use: float
    slip_speed: float


class GripperContact(NamedTuple):
    """What both pads touch.

    Attributes
    ----------
    opening : float
        Between the pads, where they are nearest (m).
    force : float
        That clamps what is held: the smaller normal force of both pads on it (N); 0: nothing is.
    object : str
        Name of what both pads press on from opposite sides; empty: nothing.
    slip_speed : float
        Of what is held along the pads, on the faster one (m/s).
    """

    opening: float
    force: float
    object: str
    slipping: bool
    slip_speed: float
    pads: Tuple[PadContact, PadContact]


class _Touch:
    """The contacts of a pad with one body."""

    __slots__ = ("bound", "force", "friction", "pressing", "slipped")

    def __init__(self) -> None:
        self.force = 0.0
        self.bound = 0.0
        self.slipped = 0.0
        self.pressing = [0.0, 0.0, 0.0]
        self.friction = [0.0, 0.0, 0.0]

    @property
    def slip_speed(self) -> float:
        """Mean over the contacts, by their forces (m/s)."""
        return self.slipped / self.force


_Motion = Tuple[Vector, Vector, Vector]
"""Centre of mass (m), and the velocities of and about it (m/s, rad/s), in the world."""


class GripperContacts(Stateful):
    """Watches the pads of one robot.

    Parameters
    ----------
    config : GripperContactConfig
        Its pads are links of `body`.
    """

    SAVED = ("_slipping",)

    def __init__(self, body: Body, config: GripperContactConfig) -> None:
        self._body = body
        self._config = config
        self._links = tuple(body.links[name] for name in config.pads)
        self._slipping = False

    def measure(self, name_of: Callable[[int], str]) -> GripperContact:
        """Look at the contacts of the last step.

        Parameters
        ----------
        name_of : callable
            Name of another body by PyBullet's number.
        """
        motions: Dict[Tuple[int, int], _Motion] = {}
        left, right = (self._touches(link, motions) for link in self._links)
        force, held, slip_speed = 0.0, -1, 0.0
        for uid in left.keys() & right.keys():
            if dot(left[uid].pressing, right[uid].pressing) >= 0.0:
                continue
            clamping = min(left[uid].force, right[uid].force)
            if (clamping, -uid) > (force, -held):
                force, held = clamping, uid
                slip_speed = max(left[uid].slip_speed, right[uid].slip_speed)
        limit = self._config.stick_speed if self._slipping else self._config.slip_speed
        self._slipping = held >= 0 and slip_speed > limit
        first, second = (
            self._pad(name, touches, name_of)
            for name, touches in zip(self._config.pads, (left, right))
        )
        return GripperContact(
            self._opening(),
            force,
            name_of(held) if held >= 0 else "",
            self._slipping,
            slip_speed,
            (first, second),
        )

    def _pad(
        self, name: str, touches: Dict[int, _Touch], name_of: Callable[[int], str]
    ) -> PadContact:
        force = sum(touch.force for touch in touches.values())
        bound = sum(touch.bound for touch in touches.values())
        friction = self._friction_on(self._body.links[name], touches)
        return PadContact(
            name,
            tuple(sorted({name_of(uid) for uid in touches})),
            force,
            friction,
            friction / bound if bound else 0.0,
            sum(touch.slipped for touch in touches.values()) / force if force else 0.0,
        )

    # --- PyBullet ----------------------------------------------------------------------------

    def _opening(self) -> float:
        own, (left, right) = self._body.uid, self._links
        points = pybullet.getClosestPoints(
            own, own, _FURTHEST, left, right, physicsClientId=self._body.client
        )
        return max(0.0, min((point[8] for point in points), default=_FURTHEST))

    def _friction_on(self, link: int, touches: Dict[int, _Touch]) -> float:
        """Friction on a pad, the magnitude of its sum (N)."""
        if len(touches) <= 1:
            return sum(math.hypot(*touch.friction) for touch in touches.values())
        friction = [0.0, 0.0, 0.0]
        for contact in directed_contacts(self._body, link):
            friction = [a + b for a, b in zip(friction, contact.friction)]
        return math.hypot(*friction)

    def _touches(self, link: int, motions: Dict[Tuple[int, int], _Motion]) -> Dict[int, _Touch]:
        """The contacts under load of a pad, by the other body; not those with the robot itself."""
        found: Dict[int, _Touch] = {}
        for contact in contacts(self._body, link):
            touch = found.setdefault(contact.other[0], _Touch())
            force, normal = contact.force, contact.normal
            touch.force += force
            touch.bound += force * self._friction(link, contact.other)
            touch.pressing = [a + force * b for a, b in zip(touch.pressing, normal)]
            touch.friction = [a + b for a, b in zip(touch.friction, contact.friction)]
            touch.slipped += force * _slip(
                self._motion((self._body.uid, link), motions),
                self._motion(contact.other, motions),
                contact.point,
                normal,
            )
        return found

    def _friction(self, link: int, other: Tuple[int, int]) -> float:
        """Friction coefficient between a pad and another link."""
        client = self._body.client
        own = pybullet.getDynamicsInfo(self._body.uid, link, physicsClientId=client)[1]
        return own * pybullet.getDynamicsInfo(*other, physicsClientId=client)[1]

    def _motion(self, place: Tuple[int, int], motions: Dict[Tuple[int, int], _Motion]) -> _Motion:
        if place not in motions:
            motions[place] = _motion_of(*place, self._body.client)
        return motions[place]


def _motion_of(uid: int, link: int, client: int) -> _Motion:
    if link < 0:
        position, _ = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)
        return (position, *pybullet.getBaseVelocity(uid, physicsClientId=client))
    state = pybullet.getLinkState(uid, link, computeLinkVelocity=1, physicsClientId=client)
    return state[0], state[6], state[7]


def _slip(first: _Motion, second: _Motion, point: Vector, normal: Vector) -> float:
    """Speed of two bodies against each other at a point, along their surfaces (m/s)."""
    one, other = _velocity(first, point), _velocity(second, point)
    relative = [a - b for a, b in zip(one, other)]
    along = dot(relative, normal)
    return math.sqrt(sum((a - along * b) ** 2 for a, b in zip(relative, normal)))


def _velocity(motion: _Motion, point: Vector) -> List[float]:
    (x, y, z), linear, (wx, wy, wz) = motion
    x, y, z = point[0] - x, point[1] - y, point[2] - z
    turning = (wy * z - wz * y, wz * x - wx * z, wx * y - wy * x)
    return [a + b for a, b in zip(linear, turning)]
