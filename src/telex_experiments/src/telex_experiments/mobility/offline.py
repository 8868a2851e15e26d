"""The simulation in the script's own process: as fast as it goes, and always the same."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple
from xml.etree import ElementTree

import numpy as np
import pybullet
import yaml

from telex_sim.engine.simulator_config import TUNED_PERIOD
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, package_yaml, robot_description
from telex_training.operators.scripted_operator import TICK, DirectOperator
from telex_training.rehearsal.controllers import OfflineControllers

LOAD_EDGE = 0.2
"""Edge of a load in the gripper (m), for its inertia."""
LOAD_FORCE = 1.0e5
"""With which it is held (N)."""


def _for_period(period: float, urdf: str) -> Tuple[Dict[str, Any], str]:
    """Shipped controllers and robot, so changed that they are stable at a longer control period.

    An explicit damper chatters where its gain is above 2 * inertia / period. The shipped gains and
    the brakes of the soft limits go near that at 2 ms; they shrink as the period grows.
    """
    share = min(1.0, TUNED_PERIOD / period)
    controllers = package_yaml("telex_control", "config", "telex_controllers.yaml")
    for value in controllers.values():
        pid = value.get("pid", {}) if isinstance(value, dict) else {}
        smaller = {gain: share * pid[gain] for gain in ("p", "i", "d") if gain in pid}
        if smaller:
            # Controllers of one kind share these in the file.
            value["pid"] = {**pid, **smaller}
    root = ElementTree.fromstring(urdf)
    for safety in root.iter("safety_controller"):
        safety.set("k_velocity", repr(share * float(safety.attrib["k_velocity"])))
    return controllers, ElementTree.tostring(root, encoding="unicode")


class Trial:
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
        Of the simulator's configuration, see `telex_sim.offline.simulation.shipped_config`.

    Attributes
    ----------
    simulation : Simulation
    urdf : str
    operator : DirectOperator
    each_step : list of callable
        Called after every step: for measurements.
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
        controllers, self.urdf = _for_period(period, robot_description())
        scene = {
            "floor": {"friction": friction},
            "start": dict(start or {}),
            "objects": list(objects),
        }
        with tempfile.TemporaryDirectory(prefix="telex-mobility-") as folder:
            path = Path(folder) / "course.yaml"
            path.write_text(yaml.safe_dump(scene))
            self._offline = OfflineSimulation(
                self.urdf,
                controllers,
                world=str(path),
                start__pose=pose,
                timing__step_size=step_size,
                timing__control_period=period,
                **changes,
            )
        self.simulation = self._offline.simulation
        self.step_size = step_size
        self.each_step: List[Callable[[], None]] = []
        self.load: Optional[int] = None
        if load:
            self.hold(load)
        port = OfflineControllers(OfflineRobot(self._offline), self._advance)
        self.operator = DirectOperator(port)
        self._advance(TICK)
        self.operator.look()

    def __enter__(self) -> Trial:
        return self

    def __exit__(self, *exception: object) -> None:
        """Release PyBullet."""
        self.simulation.close()

    @property
    def node(self) -> Any:
        """Node handle of the robot's namespace."""
        return self._offline.node

    def _advance(self, seconds: float) -> None:
        for _ in range(round(seconds / self.step_size)):
            self.simulation.step()
            for measure in self.each_step:
                measure()

    def hold(self, mass: float) -> None:
        """Fix a load between the pads, as a grip does that does not slip."""
        body = self.simulation.body
        client = body.client
        link, position, orientation = body.place("tool_link")
        pose = body.pose("tool_link")
        self.load = load = pybullet.createMultiBody(mass, -1, -1, *pose, physicsClientId=client)
        inertia = mass * LOAD_EDGE**2 / 6.0
        pybullet.changeDynamics(
            load,
            -1,
            localInertiaDiagonal=[inertia] * 3,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=client,
        )
        origin = (0.0, 0.0, 0.0)
        joint = pybullet.createConstraint(
            *(body.uid, link, load, -1, pybullet.JOINT_FIXED),
            *(origin, position, origin, orientation),
            physicsClientId=client,
        )
        pybullet.changeConstraint(joint, maxForce=LOAD_FORCE, physicsClientId=client)

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
