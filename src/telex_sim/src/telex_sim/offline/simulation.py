"""The shipped robot in a simulation without ROS master: for tests, benchmarks and experiments."""

from __future__ import annotations

import subprocess
import threading
from dataclasses import fields
from functools import lru_cache
from typing import Any, Dict, List, Optional, Sequence

from telex_control.common.file_catalog import package_file, package_path, package_yaml
from telex_control.common.params import read_config
from telex_control.manager.controller_joints import controller_joints, without_joints
from telex_control.ros.local_node_handle import LocalNodeHandle

from ..engine.simulation import Simulation
from ..engine.simulator_config import RobotConfig, SimulatorConfig
from ..robot.robot import Robot
from ..scene.addresses import resolve_address


@lru_cache(maxsize=1)
def robot_description() -> str:
    """URDF text of the shipped robot, made once in a process."""
    model = package_file("telex_description", "urdf", "telex.urdf.xacro")
    return subprocess.run(
        ["xacro", str(model)], check=True, stdout=subprocess.PIPE, text=True
    ).stdout


def shipped_config(**changes: Any) -> SimulatorConfig:
    """The shipped configuration of the simulator node.

    Parameters
    ----------
    **changes
        Values to replace, by their path with two underscores for the slash, e.g.
        ``timing__step_size=0.001``.
    """
    params = package_yaml("telex_sim", "config", "simulator.yaml")
    params["start"].update(package_yaml("telex_description", "config", "poses.yaml"))
    params["self_collision"] = package_yaml("telex_description", "config", "self_collision.yaml")
    for path, value in changes.items():
        *parents, key = path.split("__")
        target = params
        for parent in parents:
            target = target[parent]
        target[key] = value
    return read_config(SimulatorConfig, params, "simulator")


def further_config(model: str) -> RobotConfig:
    """The shipped configuration of a further robot, which finds a place in the scene by itself."""
    config = shipped_config(model=model, start__beside=True)
    return RobotConfig(**{each.name: getattr(config, each.name) for each in fields(RobotConfig)})


class OfflineSimulation:
    """The shipped robot, or a variant, with all its controllers, advanced by calls.

    All of them run but those for actions, which are for the same joints as others.

    Parameters
    ----------
    controllers : dict, optional
        In place of the shipped ``telex_controllers.yaml``.
    **changes
        See `shipped_config`.

    Attributes
    ----------
    node : LocalNodeHandle
        For topics and parameters, named as in the graph without the namespace.
    """

    def __init__(
        self, urdf: str, controllers: Optional[Dict[str, Any]] = None, **changes: Any
    ) -> None:
        params = dict(
            controllers or package_yaml("telex_control", "config", "telex_controllers.yaml")
        )
        params["robot_description"] = urdf
        self.node = LocalNodeHandle(params)
        self.simulation = Simulation(
            shipped_config(**changes),
            urdf,
            self.node,
            lambda address: resolve_address(address, package_path),
        )
        self._control(self.simulation.robots[0], params)

    def add_robot(self, name: str, urdf: str) -> LocalNodeHandle:
        """Put a further robot into the scene, where that has a start for it or beside the first.

        Parameters
        ----------
        name : str
            In the scene.

        Returns
        -------
        LocalNodeHandle
            Its own, as `node` is the first one's.

        Raises
        ------
        ConfigError, UrdfError
            There is no room for it, for one.
        """
        params = package_yaml("telex_control", "config", "telex_controllers.yaml")
        params["robot_description"] = urdf
        # A graph of its own, for its topics have the names of the first one's.
        node = LocalNodeHandle({name: params}).child(name)
        robot = self.simulation.plan_robot(further_config(name), urdf, node)
        self.simulation.add_robot(robot)
        self._control(robot, params)
        return node

    def _control(self, robot: Robot, params: Dict[str, Any]) -> None:
        """Load and start the controllers of a robot."""
        names = _fit(robot, params)
        for name in names:
            if not robot.controllers.load_controller(name):
                raise RuntimeError(f"controller '{name}' cannot be loaded; the log says why")
        stopped = params["controller_groups"]["actions"]
        self._switch(robot, [name for name in names if name not in stopped], [])

    def switch(self, start: Sequence[str], stop: Sequence[str]) -> None:
        """Start and stop controllers of the first robot; no sim time passes.

        Raises
        ------
        RuntimeError
            They cannot be switched.
        """
        self._switch(self.simulation.robots[0], start, stop)

    def _switch(self, robot: Robot, start: Sequence[str], stop: Sequence[str]) -> None:
        answer: List[bool] = []
        manager = robot.controllers
        thread = threading.Thread(
            target=lambda: answer.append(manager.switch_controller(start, stop))
        )
        thread.start()
        while thread.is_alive():
            # Not by steps: how many there are would depend on the threads.
            self.simulation.idle()
            thread.join(0.001)
        if answer != [True]:
            raise RuntimeError("the controllers cannot be switched; the log says why")

    def run(self, seconds: float) -> None:
        """Advance by `seconds` of sim time."""
        for _ in range(round(seconds / self.simulation.config.timing.step_size)):
            self.simulation.step()

    def positions(self) -> Dict[str, float]:
        """Measured position of every driven joint (rad, m)."""
        return self.simulation.hw.joint_positions()


def _fit(robot: Robot, params: Dict[str, Any]) -> List[str]:
    """Return the controllers with a joint, or without need of any; those gone are taken out."""
    names = []
    for name in [name for name, value in params.items() if _is_controller(value)]:
        joints = controller_joints(params[name])
        lacking = [joint for joint in joints if not robot.hw.has_joint(joint)]
        if lacking and len(lacking) == len(joints):
            continue
        params[name] = without_joints(params[name], lacking)
        names.append(name)
    return names


def _is_controller(value: Any) -> bool:
    return isinstance(value, dict) and "type" in value
