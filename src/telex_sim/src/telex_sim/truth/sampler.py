"""Samples of the truth about one robot and the scene: what is scored, recorded and drawn again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import pybullet

from ..engine.simulation import Simulation
from ..engine.world import Body
from ..robot.robot import Robot
from ..scene.objects.bodies import FreeBody, SceneJoint, SceneLatch
from .groups import NAMES, link_groups
from .ledger import ROBOT, ContactLedger, LedgerEntry

NOTHING = -1
"""Number in place of an object where nothing is held."""
_STILL = 1e-5
"""Change of each number of a pose (m) since it was told last, up to which a body stands
still."""
_WHOLE_EVERY = 1.0
"""Sim time between samples with the poses of all bodies (s)."""


@dataclass(frozen=True)
class Names:
    """What the numbers of a sample are of; see ``TruthNames.msg``."""

    robot: str
    joints: Tuple[str, ...]
    groups: Tuple[str, ...]
    links: Tuple[str, ...]
    group_of: Tuple[int, ...]
    objects: Tuple[str, ...]
    bodies: Tuple[str, ...]
    mechanisms: Tuple[str, ...]
    latches: Tuple[str, ...]


class SampledTruth(NamedTuple):
    """One look at everything after a step; see ``TruthSample.msg``.

    Attributes
    ----------
    base : list of 7 floats
        Pose of the root link in the world (m, quaternion x y z w).
    twist : list of 6 floats
        Of the root link in the world (m/s, rad/s).
    joints, mechanisms : list of float
        Positions (rad, m).
    poses : list of float
        7 numbers for each body of `moved`.
    grip : float
        Clamping force (N).
    """

    base: List[float]
    twist: List[float]
    joints: List[float]
    mechanisms: List[float]
    latched: List[bool]
    whole: bool
    moved: List[int]
    poses: List[float]
    held: int
    grip: float
    contacts: List[LedgerEntry]


class TruthSampler:
    """Looks at one robot and the scene; while it is there, the robot's contacts are summed.

    Only the simulation's thread may use it.

    Parameters
    ----------
    robot : Robot
        One of its robots.
    """

    names: Names

    def __init__(self, simulation: Simulation, robot: Robot) -> None:
        self._simulation = simulation
        self._robot = robot
        self._changes = -1
        self._whole_at = 0.0
        self.refresh()

    def refresh(self) -> bool:
        """Learn what has come and gone; returns whether anything has."""
        simulation = self._simulation
        if self._changes == simulation.changes:
            return False
        self._changes = simulation.changes
        body, objects = self._robot.body, simulation.objects
        self._body = body
        self._joints = [index for index in body.joints.values() if _moves(body, index)]
        self._bodies: List[FreeBody] = objects.free_bodies()
        self._mechanisms: List[SceneJoint] = objects.joints()
        self._latches: List[SceneLatch] = objects.latches()
        names = [item.name for item in objects.objects()]
        groups = link_groups(self._robot)
        numbers = {name: number for number, name in enumerate(names)}
        self._numbers = numbers
        others = {uid: numbers[name] for name in names for uid in objects.bodies_of(name)}
        others.update(
            {each.body.uid: ROBOT for each in simulation.robots if each is not self._robot}
        )
        indices = {body.links[name]: group for name, group in groups.items()}
        self._ledger = ContactLedger(body.uid, indices, simulation.config.timing.step_size)
        self._ledger.others = others
        self._robot.ledger = self._ledger
        moving = {index: name for name, index in body.joints.items()}
        self.names = Names(
            robot=self._robot.model,
            joints=(*(moving[index] for index in self._joints), *body.wheels),
            groups=NAMES,
            links=tuple(groups),
            group_of=tuple(groups.values()),
            objects=tuple(names),
            bodies=tuple(each.name for each in self._bodies),
            mechanisms=tuple(each.name for each in self._mechanisms),
            latches=tuple(each.name for each in self._latches),
        )
        self._told: Optional[np.ndarray] = None
        return True

    def sample(self) -> SampledTruth:
        """Look at all of it, as it is now."""
        simulation, robot, body = self._simulation, self._robot, self._body
        client = simulation.world.client
        position, orientation = body.base_pose()
        linear, angular = _twist(body, position)
        states = (
            pybullet.getJointStates(body.uid, self._joints, physicsClientId=client)
            if self._joints
            else ()
        )
        moved, whole, poses = self._poses(client)
        held, grip = NOTHING, 0.0
        contact = simulation.gripper_contact(robot)
        if contact is not None and contact.object:
            # A floor or another robot can be pinched, too; it is no object that is carried.
            held = self._numbers.get(contact.object, NOTHING)
            grip = contact.force
        robot.held = simulation.objects.bodies_of(contact.object) if contact and held >= 0 else ()
        return SampledTruth(
            base=[*position, *orientation],
            twist=[*linear, *angular],
            joints=[*(state[0] for state in states), *body.wheels.values()],
            mechanisms=[
                pybullet.getJointState(each.uid, each.joint, physicsClientId=client)[0]
                for each in self._mechanisms
            ],
            latched=[each.latch.holds for each in self._latches],
            whole=whole,
            moved=moved,
            poses=poses,
            held=held,
            grip=grip,
            contacts=self._ledger.take(),
        )

    def _poses(self, client: int) -> Tuple[List[int], bool, List[float]]:
        """Which bodies have moved since the last sample, whether these are all, and their poses."""
        get = pybullet.getBasePositionAndOrientation
        found = [
            (*position, *orientation)
            for position, orientation in (get(each.uid, client) for each in self._bodies)
        ]
        now = np.array(found).reshape(-1, 7)
        time = self._simulation.time
        told = self._told
        whole = told is None or time >= self._whole_at
        if whole:
            self._whole_at = time + _WHOLE_EVERY - 1e-9
            moved = list(range(len(found)))
            self._told = now
        else:
            assert told is not None
            moved = np.nonzero((np.abs(now - told) > _STILL).any(axis=1))[0].tolist()
            told[moved] = now[moved]
        poses: List[float] = []
        for index in moved:
            each = self._bodies[index]
            place = pybullet.multiplyTransforms(
                found[index][:3], found[index][3:], *each.from_inertial
            )
            poses.extend(place[0])
            poses.extend(place[1])
        return moved, whole, poses

    def close(self) -> None:
        """Stop summing the robot's contacts."""
        self._robot.ledger = None
        self._robot.held = ()


def _moves(body: Body, index: int) -> bool:
    kind = pybullet.getJointInfo(body.uid, index, physicsClientId=body.client)[2]
    return bool(kind != pybullet.JOINT_FIXED)


def _twist(body: Body, position: Sequence[float]) -> Tuple[Sequence[float], Sequence[float]]:
    """Velocities of the root link's frame at `position` and about it; PyBullet has its centre's."""
    client = body.client
    linear, angular = pybullet.getBaseVelocity(body.uid, physicsClientId=client)
    center, _ = pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client)
    x, y, z = (a - b for a, b in zip(position, center))
    wx, wy, wz = angular
    shift = (wy * z - wz * y, wz * x - wx * z, wx * y - wy * x)
    return [v + s for v, s in zip(linear, shift)], angular
