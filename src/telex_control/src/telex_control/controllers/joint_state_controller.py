"""``joint_state_controller/JointStateController``: publishes all joint states."""

from __future__ import annotations

from typing import List, Optional

from sensor_msgs.msg import JointState

from ..controller import Controller, ControllerInitError
from ..hardware_interface import JointStateHandle, JointStateInterface, RobotHW
from ..node_handle import NodeHandle
from ..ros_time import stamp


class JointStateController(Controller):
    """Publishes ``joint_states`` in the robot's namespace.

    Parameters: ``publish_rate`` (Hz, required), ``joints`` (names, in the order wanted; all by
    default, in alphabetical order).
    """

    parameters = frozenset(("joints", "publish_rate"))

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Take the state handles; state handles claim nothing."""
        rate = node.param("publish_rate", float)
        if rate <= 0.0:
            raise ControllerInitError(
                f"parameter {node.resolve('publish_rate')} is {rate}; it must be above 0 Hz"
            )
        self._publish_period = 1.0 / rate
        states = hw.get(JointStateInterface)
        names = node.param("joints", list, states.names())
        self._handles: List[JointStateHandle] = [states.get_handle(name) for name in names]
        self._names = [handle.name for handle in self._handles]
        # The topic belongs to the robot, its life to the controller's own handle.
        self._publisher = node.advertise(root.resolve("joint_states"), JointState)
        self._next: Optional[float] = None

    def starting(self, time: float) -> None:
        """Publish in the first cycle."""
        self._next = None

    def update(self, time: float, period: float) -> None:
        """Publish when it is due; the mean rate is kept whatever the control period."""
        due = time if self._next is None else self._next
        # Half a microsecond of slack: sums of the period must not miss their cycle by rounding.
        if time < due - 5e-7:
            return
        due += self._publish_period
        self._next = due if due > time else time + self._publish_period
        message = JointState()
        message.header.stamp = stamp(time)
        message.name = self._names
        message.position = [handle.position for handle in self._handles]
        message.velocity = [handle.velocity for handle in self._handles]
        message.effort = [handle.effort for handle in self._handles]
        self._publisher.publish(message)
