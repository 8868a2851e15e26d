"""``effort_controllers/JointVelocityController``: a joint moved at a velocity by a PID."""

from __future__ import annotations

from std_msgs.msg import Float64

from ..common.plausible import speed_problem
from ..hardware.hardware_interface import EffortJointInterface, RobotHW
from ..laws.pid_reconfigure import PidSet
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle
from .joint_controller_state import JointControllerStatePublisher


class EffortJointVelocityController(Controller):
    """Moves one joint at the commanded velocity by effort.

    Topics: ``command`` (std_msgs/Float64; rad/s or m/s), ``state``
    (control_msgs/JointControllerState; set point and process value are velocities). Parameters:
    ``joint``, ``pid``. A started controller commands no velocity.
    """

    parameters = frozenset(("joint", "pid"))
    SAVED = ("_set_point",)
    SAVED_PARTS = ("_pid",)

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joint and open the topics."""
        self._node = node
        self._joint = hw.get(EffortJointInterface).get_handle(node.param("joint", str))
        self._pids = PidSet(node)
        self._pid = self._pids.open("pid")
        self._set_point = 0.0
        self._state = JointControllerStatePublisher(node, self._joint, self._pid)
        node.subscribe("command", Float64, self._on_command)

    def _on_command(self, message: Float64) -> None:
        problem = speed_problem(message.data)
        if problem:
            self._node.warn(
                f"{self._node.resolve('command')}: joint '{self._joint.name}': command "
                f"{message.data} {problem} and is dropped"
            )
            return
        self._set_point = message.data

    def starting(self, time: float) -> None:
        """Come to rest; commands from before are forgotten."""
        self._set_point = 0.0
        self._pid.reset()

    def update(self, time: float, period: float) -> None:
        """Run the PID."""
        joint, set_point = self._joint, self._set_point
        velocity = joint.state.velocity
        error = set_point - velocity
        joint.command = self._pid.update(error, period)
        self._pids.publish(time)
        if self._state.is_due():
            self._state.publish(time, period, set_point, velocity, error)

    def stopping(self, time: float) -> None:
        """Leave the joint without effort."""
        self._joint.command = 0.0
