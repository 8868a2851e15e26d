"""The ``state`` topic of controllers of a single joint."""

from __future__ import annotations

from control_msgs.msg import JointControllerState

from ..hardware.hardware_interface import JointHandle
from ..laws.pid import Pid
from ..ros.node_handle import NodeHandle
from ..ros.sim_time import stamp

STATE_DIVIDER = 10
"""The state is published in every tenth cycle, as upstream does."""


class JointControllerStatePublisher:
    """Publishes control_msgs/JointControllerState in every tenth cycle, when anybody listens."""

    def __init__(self, node: NodeHandle, joint: JointHandle, pid: Pid) -> None:
        self._joint = joint
        self._pid = pid
        self._publisher = node.advertise("state", JointControllerState, queue_size=1)
        self._cycle = 0

    def is_due(self) -> bool:
        """Count a cycle; tell whether its state is to be published."""
        self._cycle += 1
        if self._cycle < STATE_DIVIDER:
            return False
        self._cycle = 0
        return self._publisher.has_subscribers()

    def publish(
        self, time: float, period: float, set_point: float, process_value: float, error: float
    ) -> None:
        """Publish the state of the cycle at `time`, `period` after the last (s)."""
        gains = self._pid.gains
        message = JointControllerState()
        message.header.stamp = stamp(time)
        message.set_point = set_point
        message.process_value = process_value
        message.process_value_dot = self._joint.state.velocity
        message.error = error
        message.time_step = period
        message.command = self._joint.command
        message.p, message.i, message.d = gains.p, gains.i, gains.d
        message.i_clamp = gains.i_max
        message.antiwindup = gains.antiwindup
        self._publisher.publish(message)
