"""A load in the gripper that no controller knows of."""

from __future__ import annotations

import pybullet

from telex_sim.engine.world import Body

_EDGE = 0.1  # m, of the cube that its inertia is that of
_FORCE = 1.0e5  # N, that fixes it at most


def fix_payload(body: Body, mass: float) -> None:
    """Fix a mass (kg) to the tool centre point of a robot in PyBullet."""
    client = body.client
    link, position, orientation = body.place("tool_link")
    load = pybullet.createMultiBody(mass, -1, -1, *body.pose("tool_link"), physicsClientId=client)
    pybullet.changeDynamics(
        load,
        -1,
        localInertiaDiagonal=[mass * _EDGE**2 / 6.0] * 3,
        linearDamping=0.0,
        angularDamping=0.0,
        physicsClientId=client,
    )
    fixed = pybullet.createConstraint(
        *(body.uid, link, load, -1, pybullet.JOINT_FIXED),
        *((0, 0, 0), position, (0, 0, 0), orientation),
        physicsClientId=client,
    )
    pybullet.changeConstraint(fixed, maxForce=_FORCE, physicsClientId=client)
