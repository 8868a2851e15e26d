"""Gravity compensation of a joint, for controllers."""

from __future__ import annotations

from ..hardware.hardware_interface import RobotHW
from ..laws.gravity import GravityError, JointGravity, gravity_of
from ..manager.controller import ControllerInitError
from ..ros.node_handle import NodeHandle


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
