"""``velocity_controllers/JointPositionController``: a PID turns a position into a velocity."""

from __future__ import annotations

from ..hardware.hardware_interface import VelocityJointInterface
from ..ros.node_handle import NodeHandle
from . import effort_joint_position_controller


class JointPositionController(effort_joint_position_controller.JointPositionController):
    """Holds one joint at the commanded position by velocity.

    Topics and parameters are those of the effort controller, but for gravity: the drive carries it.
    """

    parameters = effort_joint_position_controller.JointPositionController.parameters - {
        "gravity_compensation"
    }
    interface = VelocityJointInterface

    def _compensates_gravity(self, node: NodeHandle) -> bool:
        return False
