"""The simulation in the script's own process: as fast as it goes, and always the same."""

from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np
import pybullet

from telex_experiments.rigs.offline_rig import OfflineRig, fix_payload, for_period
from telex_sim.engine.simulator_config import TUNED_PERIOD
from telex_training.operators.scripted_operator import TICK

_LOAD_EDGE = 0.2  # m, of a load in the gripper


class OfflineTrial(OfflineRig):
    """A robot on a course, and an operator for it; close it when done.

    Parameters
    ----------
    objects : sequence of dict
        Entries of a scene file.
    start : dict
        Of the scene file.
    friction : float
        Of the floor.
    pose : str
        Named pose that the robot starts in.
    step_size : float
        Of the physics (s); the control period is 2 ms, or this where it is longer. Then the gains
        are less than the shipped ones, which are tuned for 2 ms.
    load : float
        Mass held in the gripper (kg).
    **changes
        See `OfflineRig`.

    Attributes
    ----------
    load : int or None
        PyBullet's number of the load.
    """

    def __init__(
        self,
        objects: Sequence[Dict[str, Any]] = (),
        start: Optional[Dict[str, float]] = None,
        friction: float = 1.0,
        pose: str = "drive",
        step_size: float = 0.002,
        load: float = 0.0,
        **changes: Any,
    ) -> None:
        period = max(TUNED_PERIOD, step_size)
        controllers, self.urdf = for_period(period)
        scene = {
            "floor": {"friction": friction},
            "start": dict(start or {}),
            "objects": list(objects),
        }
        super().__init__(
            scene,
            self.urdf,
            controllers,
            step_size,
            start__pose=pose,
            timing__control_period=period,
            **changes,
        )
        self.load: Optional[int] = None
        if load:
            self.hold(load)
        self.wait(TICK)
        self.operator.look()

    @property
    def node(self) -> Any:
        """Node handle of the robot's namespace."""
        return self.offline.node

    def hold(self, mass: float) -> None:
        """Fix a load between the pads, as a grip does that does not slip."""
        self.load = fix_payload(self.simulation.body, mass, _LOAD_EDGE)

    # --- what no operator can do -------------------------------------------------------------

    def place(self, position: Sequence[float], orientation: Sequence[float]) -> None:
        """Put the robot somewhere, at rest: base_link's position (m) and quaternion (x, y, z, w).

        An instructor can; no command of the operator leads across a slope from the start.
        """
        body = self.simulation.body
        inertial = pybullet.getDynamicsInfo(body.uid, -1, physicsClientId=body.client)[3:5]
        pose = pybullet.multiplyTransforms(position, orientation, *inertial)
        pybullet.resetBasePositionAndOrientation(body.uid, *pose, physicsClientId=body.client)
        pybullet.resetBaseVelocity(body.uid, (0, 0, 0), (0, 0, 0), physicsClientId=body.client)
        if self.load is not None:
            pybullet.resetBasePositionAndOrientation(
                self.load, *body.pose("tool_link"), physicsClientId=body.client
            )
        self.operator.look()

    def center(self) -> np.ndarray:
        """Position of the hull's centre of mass in the world (m)."""
        body = self.simulation.body
        return np.array(
            pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=body.client)[0]
        )

    def velocity(self) -> Tuple[np.ndarray, np.ndarray]:
        """Velocity of the hull's centre of mass and its turning, in the world (m/s, rad/s)."""
        body = self.simulation.body
        linear, angular = pybullet.getBaseVelocity(body.uid, physicsClientId=body.client)
        return np.array(linear), np.array(angular)

    def position(self) -> np.ndarray:
        """Of base_link in the world (m)."""
        return np.array(self.simulation.body.base_pose()[0])

    def penetration(self) -> float:
        """How deep the robot is in anything (m), at its worst place; 0 where it touches nothing."""
        body = self.simulation.body
        contacts = pybullet.getContactPoints(body.uid, physicsClientId=body.client)
        return max((-contact[8] for contact in contacts), default=0.0)
