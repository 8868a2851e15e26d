"""Lookup of joints, and of what holds them, in the robot description; for controllers."""

from __future__ import annotations

import functools
from typing import Dict

from ..hardware.hardware_interface import RobotHW
from ..laws.gravity import GravityError, JointGravity, gravity_of
from ..manager.controller import ControllerInitError
from ..ros.node_handle import NodeHandle
from ..urdf.joints import UrdfError, UrdfJoint, joints, parse_urdf


def joint_description(root: NodeHandle, name: str) -> UrdfJoint:
    """Return what ``robot_description`` in the robot's namespace `root` says of the joint `name`.

    Raises
    ------
    ControllerInitError
        There is no description, it cannot be read, or it lacks the joint.
    """
    try:
        described = _joints(root.param("robot_description", str))
    except UrdfError as error:
        raise ControllerInitError(str(error)) from error
    if name not in described:
        raise ControllerInitError(
            f"{root.resolve('robot_description')} has no movable joint '{name}'; "
            f"it has: {', '.join(described) or 'none'}"
        )
    return described[name]


def joint_gravity(hw: RobotHW, root: NodeHandle, name: str) -> JointGravity:
    """Return what holds the joint `name` of a robot against gravity; see `gravity_of`.

    Raises
    ------
    ControllerInitError, ConfigError
    """
    try:
        return gravity_of(hw, root).joint(name)
    except GravityError as error:
        raise ControllerInitError(str(error)) from error


@functools.lru_cache(maxsize=4)
def _joints(urdf: str) -> Dict[str, UrdfJoint]:
    # Each of a robot's controllers asks, and reading takes some ms.
    return joints(parse_urdf(urdf))
