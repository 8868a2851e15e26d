"""State of all bodies of a PyBullet world, saved and restored.

PyBullet's own ``saveState`` writes out every shape as well, which takes most of its time, and its
``restoreState`` brings back only a part of the contacts, with the forces of the present; it leaves
out motors, constraints and which bodies sleep. Here the positions and velocities are read and set.
What the engine remembers of contacts is not brought back but forgotten: it finds them again in the
next step.
"""

from __future__ import annotations

from typing import Any, List, NamedTuple, Sequence, Tuple

import pybullet

from ..scene.objects.latches import wake

_MOVING = (1, -1)
"""PyBullet's collision group and mask of what can move: it touches everything."""


class _Placed(NamedTuple):
    """A body: its number, whether its base can move, and which of its joints and links can."""

    uid: int
    free: bool
    joints: Tuple[int, ...]
    links: Tuple[int, ...]

    @property
    def moves(self) -> bool:
        """Whether anything of it can move."""
        return self.free or bool(self.joints)


class WorldState:
    """Saves and restores the bodies that are in a world now; for others, another one is needed.

    Parameters
    ----------
    client : int
        PyBullet's.
    bodies : sequence of int
        All bodies, by PyBullet's numbers.
    """

    def __init__(self, client: int, bodies: Sequence[int]) -> None:
        self._client = client
        self._bodies: List[_Placed] = []
        for uid in bodies:
            free = pybullet.getDynamicsInfo(uid, -1, physicsClientId=client)[0] > 0.0
            joints: List[int] = []
            links = [-1] if free else []
            for index in range(pybullet.getNumJoints(uid, physicsClientId=client)):
                info = pybullet.getJointInfo(uid, index, physicsClientId=client)
                if info[2] != pybullet.JOINT_FIXED:
                    joints.append(index)
                if info[2] != pybullet.JOINT_FIXED or info[16] in links:
                    links.append(index)
            self._bodies.append(_Placed(uid, free, tuple(joints), tuple(links)))

    def save_state(self) -> Any:
        """Return poses and velocities of all of them."""
        client = self._client
        return [
            (
                pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=client),
                pybullet.getBaseVelocity(body.uid, physicsClientId=client) if body.free else None,
                [
                    state[:2]
                    for state in pybullet.getJointStatesMultiDof(
                        body.uid, body.joints, physicsClientId=client
                    )
                ]
                if body.joints
                else (),
            )
            for body in self._bodies
        ]

    def restore_state(self, saved: Any) -> None:
        """Put all of them back, awake, to the last bit; nothing depends on what was meanwhile."""
        client = self._client
        for body in self._bodies:
            if body.moves:
                wake(client, body.uid)
        # Of what sleeps no contacts are looked for, and only a step tells the engine who is awake.
        pybullet.stepSimulation(physicsClientId=client)
        for body, (pose, velocity, joints) in zip(self._bodies, saved):
            uid = body.uid
            # One by one: PyBullet's call for several crashes on some lists.
            for index, state in zip(body.joints, joints):
                pybullet.resetJointStateMultiDof(uid, index, *state, physicsClientId=client)
            if body.moves or pose != pybullet.getBasePositionAndOrientation(uid, client):
                # The engine rounds the orientations of what stands fast, too.
                pybullet.resetBasePositionAndOrientation(uid, *pose, physicsClientId=client)
            if velocity is not None:
                pybullet.resetBaseVelocity(uid, *velocity, physicsClientId=client)
            if body.moves:
                wake(client, uid)
        for body in self._bodies:
            for link in body.links:
                # Whatever it is set to, the engine drops all pairs and contacts of the link.
                pybullet.setCollisionFilterGroupMask(
                    body.uid, link, *_MOVING, physicsClientId=client
                )
        pybullet.performCollisionDetection(physicsClientId=client)
