"""``velocity_controllers/JointPositionController``: a PID turns a position into a velocity."""

from __future__ import annotations

from ..hardware.hardware_interface import VelocityJointInterface
from ..ros.node_handle import NodeHandle
from .effort_joint_position_controller import EffortJointPositionController


class VelocityJointPositionController(EffortJointPositionController):
    """Holds one joint at the commanded position by velocity.

    Topics and parameters are those of the effort controller, but for gravity: the drive carries it.
    """

    parameters = EffortJointPositionController.parameters - {"gravity_compensation"}
    interface = VelocityJointInterface

    def _compensates_gravity(self, node: NodeHandle) -> bool:
        return False
