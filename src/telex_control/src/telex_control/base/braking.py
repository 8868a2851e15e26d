"""Deceleration limit of a robot that may not tip over, from its attitude, joints and load.

The force on the centre of mass, of gravity and of braking, must keep an angle from the edge that
the robot would tip over; and from those at its sides, over which braking makes it rock. Where its
masses are is known from the URDF and the measured joints; what the gripper holds shows in the arm's
efforts, beyond those of gravity on the arm itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

import PyKDL

from ..common.params import Declared, number, parameter, required
from ..common.stateful import Stateful
from ..hardware.hardware_interface import JointStateHandle
from ..hardware.joint_limits import clamp
from ..kinematics import KinematicsError, UrdfTree, kdl_tree
from ..laws.gravity import GRAVITY
from ..urdf.joints import MOVABLE, joints
from ..urdf.model import Robot

Vector = Tuple[float, float, float]

_LEVEL: Vector = (0.0, 0.0, 1.0)
_HOLD = 0.04
"""Time (s) for which a limit is kept: the masses move little meanwhile."""
_STEADY = 0.5
"""Acceleration (m/s2) beyond which the arm's efforts tell more of it than of a load."""
_LOAD_TIME = 0.3
"""Time constant (s) of the load: driving shakes the arm."""
_LEAST_LEVER = 0.15
"""Distance (m) of a load from the arm's axes below which its weight cannot be told."""
_LARGEST_LOAD = 20.0
"""Largest load (kg) that is estimated: an arm that presses on something seems to carry one."""
_ASIDE = 0.2
"""Share of a deceleration with which the robot rocks over its sides; 0.05 to 0.15 were seen."""
_LEAST_HEIGHT = 0.01
"""Of a centre of mass over the ground (m)."""


@dataclass(frozen=True)
class BrakingConfig(Declared):
    """Limits within which a braking robot does not tip over."""

    support: float = number(
        required,
        "Where the belts leave level ground, before and behind the base's origin (m).",
        above=0.0,
    )
    reserve: float = number(
        0.26, "Angle by which the force on the robot may still turn before it tips (rad).", 0.0, 1.0
    )
    half_width: Optional[float] = number(
        None,
        "Where the belts end, to either side of the base's origin (m); None: tipping "
        "over the sides is not reckoned with.",
        above=0.0,
    )
    least_deceleration: float = number(
        1.25,
        "With which it brakes in any case (m/s2), also where that takes from the reserve.",
        above=0.0,
    )
    load_link: str = parameter("", "Where the arm holds a load; empty: none is reckoned with.")


class _Carried(NamedTuple):
    """A link, and the joint that carries it."""

    parent: int  # in the order of the links, 0 for the root
    segment: PyKDL.Segment
    state: Optional[JointStateHandle]
    mass: float
    center: PyKDL.Vector


class _ArmJoint(NamedTuple):
    """A joint that bears a part of the load."""

    carried: int
    state: JointStateHandle
    friction: float
    effort: Callable[[float], float]


class BrakingLimit(Stateful):
    """Largest deceleration of a robot that drives.

    Parameters
    ----------
    robot : Robot
        See `telex_control.urdf.joints.parse_urdf`.
    base : str
        Link with x ahead, z up; if there is none of this name, the root link counts.
    ground : float
        How far the ground is below the base's origin (m).
    states : dict of str to JointStateHandle
        Measured joints; others are taken to be at 0.
    gravity : callable
        Gives, for the name of a joint, the function from time (s) to the effort that holds what
        the URDF knows of (Nm, N).

    Attributes
    ----------
    load : float
        What the arm seems to hold (kg).

    Raises
    ------
    KinematicsError
        The robot has no such links.
    """

    SAVED = ("_limit", "_weighed", "load")
    SAVED_TIMES = ("_until",)

    def __init__(
        self,
        config: BrakingConfig,
        robot: Robot,
        base: str,
        ground: float,
        states: Dict[str, JointStateHandle],
        gravity: Callable[[str], Callable[[float], float]],
    ) -> None:
        self._config = config
        self._ground = ground
        tree = UrdfTree(robot)
        kdl = kdl_tree(tree)
        numbers = {tree.root: 0}
        self._links: List[_Carried] = []
        for joint in tree.joints():
            numbers[joint.child] = len(numbers)
            segment = kdl.getChain(joint.parent, joint.child).getSegment(0)
            inertia = segment.getInertia()
            self._links.append(
                _Carried(
                    numbers[joint.parent],
                    segment,
                    states.get(joint.name),
                    inertia.getMass(),
                    inertia.getCOG(),
                )
            )
        root = tree.inertials[tree.root]
        self._root_mass = root.mass if root is not None else 0.0
        self._root_center = PyKDL.Vector(*(root.origin.xyz if root is not None else (0, 0, 0)))
        self._base = numbers.get(base, 0)
        if not self._root_mass + sum(each.mass for each in self._links) > 0.0:
            raise KinematicsError("robot_description: no link has a mass")
        self._load_link: Optional[int] = None
        self._arm: List[_ArmJoint] = []
        if config.load_link:
            path = tree.path(tree.root, config.load_link)
            self._load_link = numbers[config.load_link]
            frictions = {name: each.friction for name, each in joints(robot).items()}
            self._arm = [
                _ArmJoint(
                    numbers[each.child],
                    states[each.name],
                    frictions.get(each.name, 0.0),
                    gravity(each.name),
                )
                for each in path
                if each.kind in MOVABLE and each.name in states
            ]
        self.restart()

    def restart(self) -> None:
        """Forget the load: something else happened meanwhile."""
        self.load = 0.0
        self._rest()

    def _rest(self) -> None:
        self._until = -math.inf
        self._weighed = False
        self._limit = math.inf

    def limit(self, time: float, speed: float, acceleration: float, up: Optional[Vector]) -> float:
        """Return the largest deceleration (m/s2).

        Parameters
        ----------
        time : float
            s.
        speed : float
            With which the robot drives (m/s).
        acceleration : float
            With which it changes (m/s2).
        up : Vector or None
            Direction away from gravity in the base's axes; None counts as level.
        """
        if speed == 0.0:
            self._rest()
            return math.inf
        if time >= self._until:
            # Half a microsecond less: sums of periods are not exact.
            self._until = time + _HOLD - 5e-7
            self._limit = self._compute(time, speed > 0.0, acceleration, up or _LEVEL)
        return self._limit

    def _compute(self, time: float, forward: bool, acceleration: float, up: Vector) -> float:
        frames = self._frames()
        base = frames[self._base]
        mass = self._root_mass
        moment = mass * self._root_center
        for frame, link in zip(frames[1:], self._links):
            if link.mass > 0.0:
                mass += link.mass
                moment += link.mass * (frame * link.center)
        if self._load_link is not None:
            place = frames[self._load_link].p
            if not self._weighed or abs(acceleration) <= _STEADY:
                weight = base.M * PyKDL.Vector(*up) * GRAVITY
                self._weigh(self._seen_load(time, frames, place, weight))
            mass += self.load
            moment += self.load * place
        center = base.Inverse() * (moment / mass)
        config, height = self._config, max(_LEAST_HEIGHT, center.z() + self._ground)

        def room(reach: float, ahead: float, uphill: float) -> float:
            """Horizontal force that it can bear over an edge, by its weight."""
            edge = math.atan2(reach - ahead, height)
            # Gravity pulls it along by -g uphill, and presses it down by g up.z.
            return math.tan(edge - config.reserve) * up[2] + uphill

        way = 1.0 if forward else -1.0
        along = room(config.support, way * center.x(), way * up[0])
        if config.half_width is None:
            return max(config.least_deceleration, GRAVITY * along)
        left = room(config.half_width, center.y(), up[1])
        right = room(config.half_width, -center.y(), -up[1])
        allowed = min(along, left / _ASIDE, right / _ASIDE)
        return max(config.least_deceleration, GRAVITY * allowed)

    def _frames(self) -> List[PyKDL.Frame]:
        """Where all links are, in the root's frame."""
        frames = [PyKDL.Frame()]
        for link in self._links:
            position = 0.0 if link.state is None else link.state.position
            frames.append(frames[link.parent] * link.segment.pose(position))
        return frames

    def _seen_load(
        self,
        time: float,
        frames: List[PyKDL.Frame],
        place: PyKDL.Vector,
        weight: PyKDL.Vector,
    ) -> float:
        """Mass (kg) that explains the arm's efforts best, by least squares.

        `weight` is the force that holds 1 kg (N).
        """
        along = 0.0
        square = (GRAVITY * _LEAST_LEVER) ** 2
        for joint in self._arm:
            link = self._links[joint.carried - 1]
            parent, kdl = frames[link.parent], link.segment.getJoint()
            axis = parent.M * kdl.JointAxis()
            if kdl.getType() == PyKDL.Joint.TransAxis:
                effort = PyKDL.dot(axis, weight)
            else:
                effort = PyKDL.dot(axis, (place - parent * kdl.JointOrigin()) * weight)
            rest = joint.state.effort - joint.effort(time)
            # What dry friction can explain is no load; it may also hide some of one.
            if abs(rest) > joint.friction:
                along += effort * rest
            square += effort * effort
        return clamp(along / square, 0.0, _LARGEST_LOAD)

    def _weigh(self, seen: float) -> None:
        """Take a load that was seen; the first one as it is, the robot still being at rest."""
        self.load += (seen - self.load) * (_HOLD / _LOAD_TIME if self._weighed else 1.0)
        self._weighed = True
