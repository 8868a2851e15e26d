"""The paper's way to drive a tracked base: force and torque on the hull, tracks that slip.

Proportional control of the hull's velocity, as Team Hector's plugin does it in the paper
(section 4.3). It stands in for the tracks of a trial, for comparisons only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet
from geometry_msgs.msg import Twist

from telex_experiments.mobility.offline import OfflineTrial

FORWARD_GAIN, MOST_FORCE = 2000.0, 800.0
"""Of the speed (N s/m), and the force at most (N): as much as the tracks grip on the level."""
SIDEWAYS_GAIN = 1000.0
"""Against sliding aside (N s/m)."""
TURNING_GAIN = 300.0
"""Of the turning (N m s/rad)."""
TRACK_FRICTION = 0.1
"""The hull could not be pushed over tracks that grip."""
TIMEOUT = 0.3
"""After which a command is forgotten (s), as the track controller does."""


class ChassisForce:
    """Drives the robot of a trial by forces on its hull, from its ``cmd_vel``.

    Parameters
    ----------
    trial : OfflineTrial
        Its tracks have no traction from now on.
    """

    def __init__(self, trial: OfflineTrial) -> None:
        self._simulation = trial.simulation
        self._body = trial.simulation.body
        self._wanted = (0.0, 0.0)
        self._until = 0.0
        trial.node.subscribe("track_controller/cmd_vel", Twist, self._on_command)
        robot = trial.simulation.robots[0]
        for belt in robot.config.tracks.belts:
            link = self._body.links[self._body.parents[belt]]
            pybullet.changeDynamics(
                self._body.uid,
                link,
                lateralFriction=TRACK_FRICTION,
                physicsClientId=self._body.client,
            )
        setattr(robot, "apply_traction", self._push)  # noqa: B010

    def _on_command(self, message: Any) -> None:
        self._wanted = (message.linear.x, message.angular.z)
        self._until = self._simulation.time + TIMEOUT

    def _push(self) -> None:
        body = self._body
        speed, turning = self._wanted if self._simulation.time < self._until else (0.0, 0.0)
        position, orientation = pybullet.getBasePositionAndOrientation(
            body.uid, physicsClientId=body.client
        )
        velocity, rates = (
            np.array(vector)
            for vector in pybullet.getBaseVelocity(body.uid, physicsClientId=body.client)
        )
        forward, left, up = np.reshape(pybullet.getMatrixFromQuaternion(orientation), (3, 3)).T
        push = np.clip(FORWARD_GAIN * (speed - velocity @ forward), -MOST_FORCE, MOST_FORCE)
        force = push * forward - SIDEWAYS_GAIN * (velocity @ left) * left
        torque = TURNING_GAIN * (turning - rates @ up) * up
        world = pybullet.WORLD_FRAME
        pybullet.applyExternalForce(
            body.uid, -1, list(force), position, world, physicsClientId=body.client
        )
        pybullet.applyExternalTorque(body.uid, -1, list(torque), world, physicsClientId=body.client)
