"""Latches: what is held in its place until it is pulled away, and again when it is put back.

A latch is a fixed constraint between two bodies. PyBullet tells the force that it carries, so it is
let go by a threshold; a limit on the constraint's own force would act on each axis alone, and let
the body creep instead of coming loose.
"""

from __future__ import annotations

import math
from typing import Any, Optional, Sequence, Tuple

import pybullet

from telex_control.common.geometry.quaternions import (
    Pose,
    Quaternion,
    compose,
    conjugate,
    invert,
    rotate,
    twist,
)

from ..model import Joint

_SMOOTHING = 0.02
"""Time over which the force is averaged (s): a knock is no pull."""
_TILT = 0.1
"""Angle (rad) between the axes within which the body is taken again."""
_SLOW = 0.1
"""Speed (m/s) below which it is taken again."""
_RIGID = 100.0
"""What the constraint can carry, over what lets it go; it must not give way before."""
_FEEL_EVERY = 2
"""Steps between two looks at the force."""
_LOOK_EVERY = 5
"""Steps between two looks at whether a body is back in place."""


class Latch:
    """One latch.

    Parameters
    ----------
    client : int
        PyBullet's.
    parent : tuple of int
        Body and link that it is fixed to.
    child : int
        Body that it holds by its base.
    step_size : float
        Time between calls of `apply` (s).
    shares : sequence of int
        Further bodies of the parent, which stands fast.
    """

    def __init__(
        self,
        client: int,
        joint: Joint,
        parent: Tuple[int, int],
        child: int,
        step_size: float,
        shares: Sequence[int] = (),
    ) -> None:
        self._client = client
        self._joint = joint
        self._parent = parent
        self._parents = (parent[0], *shares)
        self._child = child
        self._share = 1.0 - math.exp(-_FEEL_EVERY * step_size / _SMOOTHING)
        self._place: Pose = (joint.position, joint.orientation)
        self._in_parent = compose(invert(_inertial(client, *parent)), self._place)
        self._inertial = invert(_inertial(client, child, -1))
        self._constraint: Optional[int] = None
        # How the body is turned about the axis while it is held: it stays so as it came.
        self._turned: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self._force = 0.0
        # Of a state that was restored: what PyBullet has until the next step is of another.
        self._pull: Optional[float] = None
        self._until_look = 0
        self._left = False
        self._hold((0.0, 0.0, 0.0, 1.0))

    @property
    def holds(self) -> bool:
        """Whether it holds its body."""
        return self._constraint is not None

    def apply(self) -> None:
        """Let go of what is pulled away, and take what is back in place."""
        self._until_look -= 1
        kept, self._pull = self._pull, None
        if self._until_look > 0:
            return
        if self._constraint is not None:
            self._until_look = _FEEL_EVERY
            pull = self._measured_pull(self._constraint) if kept is None else kept
            self._force += self._share * (pull - self._force)
            if self._force > self._joint.hold:
                self.release()
            return
        self._until_look = _LOOK_EVERY
        self._look()

    def _measured_pull(self, constraint: int) -> float:
        """Force that the constraint bore in the last step, as it pulls at the latch (N)."""
        # Along the world's axes, upon the parent.
        force = pybullet.getConstraintState(constraint, physicsClientId=self._client)
        squared = force[0] ** 2 + force[1] ** 2 + force[2] ** 2
        across = self._joint.across
        # Far from what lets go, its direction makes no difference.
        if across == 1.0 or squared < (0.5 * self._joint.hold) ** 2:
            return math.sqrt(squared)
        turned = compose(_frame_pose(self._client, *self._parent), self._place)[1]
        axis = rotate(turned, self._joint.axis)
        out = max(0.0, sum(a * b for a, b in zip(force, axis)))
        return math.sqrt(out**2 + max(0.0, squared - out**2) / across**2)

    def save_state(self) -> Any:
        """Return the present state."""
        pull = None if self._constraint is None else self._measured_pull(self._constraint)
        return pull, self._turned, self._force, self._until_look, self._left

    def restore_state(self, saved: Any) -> None:
        """Take a state up again, after `unfix`; the bodies are where they were."""
        pull, self._turned, self._force, self._until_look, self._left = saved
        self._pull = pull
        if pull is not None:
            self._fix()
        self._let_collide(pull is None)

    def unfix(self) -> None:
        """Take the constraint away; nothing else of the latch changes."""
        if self._constraint is not None:
            pybullet.removeConstraint(self._constraint, physicsClientId=self._client)
            self._constraint = None

    def release(self) -> None:
        """Let go."""
        if self._constraint is not None:
            self.unfix()
            self._left = False
            self._let_collide(True)
            for uid in (self._parent[0], self._child):
                wake(self._client, uid)

    def _look(self) -> None:
        """Take the body when it has been away and is back, at rest."""
        client = self._client
        parent = _frame_pose(client, *self._parent)
        child = compose(
            pybullet.getBasePositionAndOrientation(self._child, physicsClientId=client),
            self._inertial,
        )
        off = compose(invert(compose(parent, self._place)), child)
        distance = math.sqrt(sum(number * number for number in off[0]))
        axis = self._joint.axis
        cosine = sum(a * b for a, b in zip(rotate(off[1], axis), axis))
        if distance > 2.0 * self._joint.capture:
            self._left = True
        if not self._left or distance > self._joint.capture or cosine < math.cos(_TILT):
            return
        velocity = pybullet.getBaseVelocity(self._child, physicsClientId=client)[0]
        if math.sqrt(sum(number * number for number in velocity)) <= _SLOW:
            self._hold(twist(off[1], axis))

    def _hold(self, turned: Quaternion) -> None:
        """Fix the body in place, turned about the latch's axis as it came."""
        self._turned = turned
        self._fix()
        self._force = 0.0
        # Contacts inside a fit would strain the constraint, and so spoil what it can hold.
        self._let_collide(False)

    def _fix(self) -> None:
        x, y, z, w = self._turned
        child = compose(self._inertial, ((0.0, 0.0, 0.0), conjugate((x, y, z, w))))
        self._constraint = pybullet.createConstraint(
            self._parent[0],
            self._parent[1],
            self._child,
            -1,
            pybullet.JOINT_FIXED,
            (0.0, 0.0, 0.0),
            self._in_parent[0],
            child[0],
            self._in_parent[1],
            child[1],
            physicsClientId=self._client,
        )
        pybullet.changeConstraint(
            self._constraint, maxForce=_RIGID * self._joint.hold, physicsClientId=self._client
        )

    def _let_collide(self, collide: bool) -> None:
        client = self._client
        for parent in self._parents:
            for link in range(-1, pybullet.getNumJoints(parent, physicsClientId=client)):
                for other in range(-1, pybullet.getNumJoints(self._child, physicsClientId=client)):
                    pybullet.setCollisionFilterPair(
                        parent, self._child, link, other, int(collide), physicsClientId=client
                    )


def wake(client: int, uid: int) -> None:
    """Wake a sleeping body."""
    pybullet.changeDynamics(
        uid, -1, activationState=pybullet.ACTIVATION_STATE_WAKE_UP, physicsClientId=client
    )


def _inertial(client: int, uid: int, link: int) -> Pose:
    """Centre-of-mass frame of a link in the link's frame."""
    info = pybullet.getDynamicsInfo(uid, link, physicsClientId=client)
    return info[3], info[4]


def _frame_pose(client: int, uid: int, link: int) -> Pose:
    """Pose of a link's frame in the world."""
    if link >= 0:
        state = pybullet.getLinkState(uid, link, computeForwardKinematics=1, physicsClientId=client)
        return state[4], state[5]
    pose = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)
    return compose(pose, invert(_inertial(client, uid, -1)))
