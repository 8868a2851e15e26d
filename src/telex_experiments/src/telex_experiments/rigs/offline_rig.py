"""The shipped robot in a scene of one's own: no ROS master, and always the same."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Tuple, TypeVar
from xml.etree import ElementTree

import pybullet
import yaml

from telex_control.common.file_catalog import package_yaml
from telex_sim.engine.simulator_config import TUNED_PERIOD
from telex_sim.engine.world import Body
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_training.operators.scripted_operator import DirectOperator
from telex_training.rehearsal.controllers import OfflineControllers

_FORCE = 1.0e5  # N, that fixes a load at most

Own = TypeVar("Own", bound="OfflineRig")


class OfflineRig:
    """A simulation whose every step can be looked at; close it when done.

    Parameters
    ----------
    scene : mapping
        Content of a scene file.
    urdf, controllers
        See `OfflineSimulation`.
    step_size : float
        Of the physics (s).
    **changes
        Of the simulator's configuration, see `telex_sim.offline.simulation.shipped_config`.

    Attributes
    ----------
    operator : DirectOperator
        Of tracks and joints.
    each_step : list of callable
        Called after every step: for measurements.
    """

    def __init__(
        self,
        scene: Mapping[str, Any],
        urdf: str,
        controllers: Dict[str, Any],
        step_size: float,
        **changes: Any,
    ) -> None:
        with tempfile.TemporaryDirectory(prefix="telex-rig-") as folder:
            path = Path(folder) / "scene.yaml"
            path.write_text(yaml.safe_dump(dict(scene)))
            self.offline = OfflineSimulation(
                urdf, controllers, world=str(path), timing__step_size=step_size, **changes
            )
        self.simulation = self.offline.simulation
        self.step_size = step_size
        self.each_step: List[Callable[[], None]] = []
        self.robot = OfflineRobot(self.offline)
        self.operator = DirectOperator(OfflineControllers(self.robot, self.wait))

    def __enter__(self: Own) -> Own:
        return self

    def __exit__(self, *exception: object) -> None:
        """Release PyBullet."""
        self.simulation.close()

    def wait(self, seconds: float) -> None:
        """Let sim time pass (s)."""
        for _ in range(round(seconds / self.step_size)):
            self.simulation.step()
            for measure in self.each_step:
                measure()


def for_period(period: float) -> Tuple[Dict[str, Any], str]:
    """Shipped controllers and robot, so changed that they are stable at a longer control period.

    An explicit damper chatters where its gain is above 2 * inertia / period. The shipped gains and
    the brakes of the soft limits go near that at 2 ms; they shrink as the period (s) grows.
    """
    controllers, urdf = (
        package_yaml("telex_control", "config", "telex_controllers.yaml"),
        robot_description(),
    )
    share = min(1.0, TUNED_PERIOD / period)
    if share == 1.0:
        return controllers, urdf
    root = ElementTree.fromstring(urdf)
    for safety in root.iter("safety_controller"):
        safety.set("k_velocity", repr(share * float(safety.attrib["k_velocity"])))
    return _weakened(controllers, share), ElementTree.tostring(root, encoding="unicode")


def _weakened(params: Any, share: float) -> Any:
    """Return parameters in which all gains are less."""
    if not isinstance(params, dict):
        return params
    if {"p", "d"} <= params.keys():
        return {
            key: share * value if key in ("p", "i", "d") else value for key, value in params.items()
        }
    return {key: _weakened(value, share) for key, value in params.items()}


def fix_payload(body: Body, mass: float, edge: float = 0.1) -> int:
    """Fix a mass (kg) to the tool centre point of a robot, of which no controller knows.

    Its inertia is that of a cube with an edge (m). Returns PyBullet's number of it.
    """
    client = body.client
    link, position, orientation = body.place("tool_link")
    load: int = pybullet.createMultiBody(
        mass, -1, -1, *body.pose("tool_link"), physicsClientId=client
    )
    pybullet.changeDynamics(
        load,
        -1,
        localInertiaDiagonal=[mass * edge**2 / 6.0] * 3,
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
    return load
