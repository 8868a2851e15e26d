"""The robot at its start in a scene, without ROS: what ``scene check`` and ``scene preview`` need.

It has no controllers: the brakes hold its joints, whatever the variant has of them.
"""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Sequence

from telex_control.common.file_catalog import package_file, package_path
from telex_control.common.params import ConfigError
from telex_control.ros.local_node_handle import LocalNodeHandle

from ..engine.simulation import Simulation
from ..offline.simulation import further_config, shipped_config
from .addresses import resolve_address


def robot_description(variant: str, options: Sequence[str] = ()) -> str:
    """Make the URDF text of a variant of the robot; of one in a file each time anew.

    Parameters
    ----------
    variant : str
        Its name, or the path of its file.
    options : sequence of str
        Keys that override it, as ``tool:=probe``.

    Raises
    ------
    ConfigError
        In the words of ``rosrun telex_description robot_description``.
    """
    if "/" in variant or variant.endswith(".yaml"):
        return _described(variant, *options)
    return _known(variant, *options)


def _described(variant: str, *options: str) -> str:
    script = package_file("telex_description", "scripts", "robot_description")
    done = subprocess.run(
        [str(script), variant, *options], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise ConfigError(done.stderr.strip() or f"{script} ended with {done.returncode}")
    return done.stdout


_known = lru_cache(maxsize=16)(_described)


def place_robot(path: Path, urdf: str, pose: str = "") -> Simulation:
    """Load a scene, and put a robot at its start; others like it where it has further starts.

    Parameters
    ----------
    path : Path
        Of the scene's file.
    pose : str
        Named pose of the robot; empty for the scene's.

    Returns
    -------
    Simulation
        To be closed by the caller.

    Raises
    ------
    SceneError, ConfigError, UrdfError, WorldError
        The scene is wrong, has no such pose, gives an object the robot's name, or leaves no room
        for the robot.
    """
    changes = {"world": str(path)}
    if pose:
        changes["start__pose"] = pose
    config = shipped_config(**changes)
    simulation = Simulation(
        config,
        urdf,
        LocalNodeHandle({"robot_description": urdf}),
        lambda address: resolve_address(address, package_path),
    )
    try:
        for number in range(2, 2 + len(simulation.scene.robots)):
            name = f"{config.model}_{number}"
            node = LocalNodeHandle({name: {"robot_description": urdf}}).child(name)
            robot = simulation.plan_robot(further_config(name), urdf, node)
            simulation.add_robot(robot)
    except Exception:
        simulation.close()
        raise
    return simulation
