"""``effort_controllers/JointPositionController``: a joint held at a position by a PID."""

from __future__ import annotations

import math

from control_msgs.msg import JointControllerState
from std_msgs.msg import Float64

from ..controller import Controller, ControllerInitError
from ..hardware_interface import EffortJointInterface, RobotHW
from ..joint_limits import clamp
from ..node_handle import NodeHandle, ParameterError
from ..pid import Pid, PidGains
from ..reference_filter import ReferenceFilter
from ..ros_time import stamp
from ..urdf_joints import CONTINUOUS, UrdfError, joints, parse_urdf

STATE_DIVIDER = 10
"""The state is published in every tenth cycle, as upstream does."""


class JointPositionController(Controller):
    """Holds one joint at the commanded position by effort.

    Topics: ``command`` (std_msgs/Float64; rad or m), ``state`` (control_msgs/JointControllerState).
    Parameters: ``joint``, ``pid`` {p, i, d, i_clamp, antiwindup}, ``command_filter_frequency``
    (rad/s; 0, the default, follows commands as they come). Needs ``robot_description`` in the
    robot's namespace for the position limits, to which commands are clamped.

    Commands come slower than the control cycle. Without the filter each one is a step, on which
    the derivative term kicks: a joint that is led at constant speed shakes at the rate of the
    commands (at 100 Hz, the turret's effort runs from limit to limit).
    """

    parameters = frozenset(("command_filter_frequency", "joint", "pid"))

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joint and open the topics."""
        name = node.param("joint", str)
        try:
            description = joints(parse_urdf(root.param("robot_description", str)))
            gains = PidGains.from_params(node.param("pid", dict), node.resolve("pid"))
        except (UrdfError, ValueError) as error:
            raise ControllerInitError(str(error)) from error
        self._joint = hw.get(EffortJointInterface).get_handle(name)
        if name not in description:
            raise ParameterError(
                f"parameter {node.resolve('joint')} is '{name}', which robot_description lacks"
            )
        limits = description[name]
        self._lower, self._upper = limits.lower, limits.upper
        self._wraps = limits.kind == CONTINUOUS
        self._node = node
        self._pid = Pid(gains)
        frequency = node.param("command_filter_frequency", float, 0.0)
        if frequency < 0.0:
            raise ParameterError(
                f"parameter {node.resolve('command_filter_frequency')} is {frequency} rad/s; "
                "0 (no filter) or more is needed"
            )
        self._filter = ReferenceFilter(frequency) if frequency else None
        # Replaced by assignment in the subscriber's thread, read in the loop.
        self._set_point = 0.0
        self._cycle = 0
        self._state = node.advertise("state", JointControllerState, queue_size=1)
        node.subscribe("command", Float64, self._on_command)

    @property
    def set_point(self) -> float:
        """The position that the controller holds (rad, m)."""
        return self._set_point

    def _on_command(self, message: Float64) -> None:
        if not math.isfinite(message.data):
            self._node.warn(
                f"joint '{self._joint.name}': command {message.data} is not finite and is dropped"
            )
            return
        self._set_point = clamp(message.data, self._lower, self._upper)

    def starting(self, time: float) -> None:
        """Hold the measured position; whatever was commanded before is forgotten."""
        self._set_point = clamp(self._joint.state.position, self._lower, self._upper)
        if self._filter is not None:
            self._filter.reset(self._set_point)
        self._pid.reset()

    def update(self, time: float, period: float) -> None:
        """Run the PID."""
        joint = self._joint
        set_point = self._set_point
        if self._filter is None:
            error = self._difference(set_point)
            joint.command = self._pid.update(error, period)
        else:
            if self._wraps:
                start = self._filter.position
                set_point = start + math.remainder(set_point - start, 2.0 * math.pi)
            reference, velocity = self._filter.update(set_point, period)
            joint.command = self._pid.update(
                self._difference(reference), period, velocity - joint.state.velocity
            )
        self._cycle += 1
        if self._cycle >= STATE_DIVIDER:
            self._cycle = 0
            if self._state.has_subscribers():
                self._publish_state(time, period, self._set_point)

    def stopping(self, time: float) -> None:
        """Leave the joint without effort."""
        self._joint.command = 0.0

    def _difference(self, target: float) -> float:
        """Distance from the measured position to `target`, the short way round."""
        difference = target - self._joint.state.position
        return math.remainder(difference, 2.0 * math.pi) if self._wraps else difference

    def _publish_state(self, time: float, period: float, set_point: float) -> None:
        gains = self._pid.gains
        message = JointControllerState()
        message.header.stamp = stamp(time)
        message.set_point = set_point
        message.process_value = self._joint.state.position
        message.process_value_dot = self._joint.state.velocity
        message.error = self._difference(set_point)
        message.time_step = period
        message.command = self._joint.command
        message.p, message.i, message.d = gains.p, gains.i, gains.d
        message.i_clamp = gains.i_max
        message.antiwindup = gains.antiwindup
        self._state.publish(message)
