"""``effort_controllers/JointPositionController``: a joint held at a position by a PID."""

from __future__ import annotations

import math
from typing import Optional, Type

from std_msgs.msg import Float64

from ..common.params import read_config
from ..common.plausible import position_problem
from ..hardware.hardware_interface import EffortJointInterface, JointCommandInterface, RobotHW
from ..hardware.joint_limits import clamp
from ..laws.gravity import JointGravity
from ..laws.pid_reconfigure import PidSet
from ..laws.reference_filter import ReferenceFilter, ReferenceLimiter, ReferenceLimits
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle
from ..urdf.joints import CONTINUOUS
from .joint_controller_state import JointControllerStatePublisher
from .joint_description import joint_description, joint_gravity


class EffortJointPositionController(Controller):
    """Holds one joint at the commanded position by effort.

    Topics: ``command`` (std_msgs/Float64; rad or m), ``state`` (control_msgs/JointControllerState).
    Parameters: ``joint``, ``pid`` {p, i, d, i_clamp, antiwindup, publish_state},
    ``command_filter_frequency`` (rad/s; 0, the default, follows commands as they come),
    ``command_limits`` {velocity, acceleration} (by default none), ``gravity_compensation`` (false).
    Needs ``robot_description`` in the robot's namespace for the position limits, to which commands
    are clamped; one that cannot be meant is dropped (`position_problem`).

    Commands come slower than the control cycle. Without the filter each one is a step, on which
    the derivative term kicks: a joint that is led at constant speed shakes at the rate of the
    commands (at 100 Hz, the turret's effort runs from limit to limit). A single command far away
    is a step too; with limits, the joint is led there at no more than this velocity and
    acceleration, and does not overshoot.

    The integral holds while the limits of the joint take away what it asks for more of: otherwise
    it would wind up at a stop or under a load that is too heavy, and the joint would stay there
    until it had unwound.
    """

    parameters = frozenset(
        (
            "command_filter_frequency",
            "command_limits",
            "gravity_compensation",
            "joint",
            "pid",
        )
    )
    SAVED = ("_asked", "_set_point")
    SAVED_PARTS = ("_filter", "_gravity", "_limiter", "_pid")
    interface: Type[JointCommandInterface] = EffortJointInterface

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joint and open the topics."""
        name = node.param("joint", str)
        self._joint = hw.get(self.interface).get_handle(name)
        limits = joint_description(root, name)
        self._lower, self._upper = limits.lower, limits.upper
        self._wraps = limits.kind == CONTINUOUS
        self._node = node
        frequency = node.positive_param("command_filter_frequency", 0.0, zero=True)
        self._filter = ReferenceFilter(frequency) if frequency else None
        self._limiter: Optional[ReferenceLimiter] = None
        command_limits = node.param("command_limits", dict, {})
        self._gravity: Optional[JointGravity] = None
        if command_limits:
            self._limiter = ReferenceLimiter(
                read_config(ReferenceLimits, command_limits, node.resolve("command_limits"))
            )
        if self._compensates_gravity(node):
            self._gravity = joint_gravity(hw, root, name)
        self._pids = PidSet(node)
        self._pid = self._pids.open("pid")
        # Replaced by assignment in the subscriber's thread, read in the loop.
        self._set_point = 0.0
        self._asked = 0.0
        self._state = JointControllerStatePublisher(node, self._joint, self._pid)
        node.subscribe("command", Float64, self._on_command)

    def _compensates_gravity(self, node: NodeHandle) -> bool:
        return node.param("gravity_compensation", bool, False)

    @property
    def set_point(self) -> float:
        """The position that the controller holds (rad, m)."""
        return self._set_point

    def _on_command(self, message: Float64) -> None:
        problem = position_problem(message.data, self._lower, self._upper)
        if problem:
            self._node.warn(
                f"{self._node.resolve('command')}: joint '{self._joint.name}': command "
                f"{message.data} {problem} and is dropped"
            )
            return
        self._set_point = clamp(message.data, self._lower, self._upper)

    def starting(self, time: float) -> None:
        """Hold the measured position; whatever was commanded before is forgotten."""
        self._set_point = clamp(self._joint.state.position, self._lower, self._upper)
        if self._limiter is not None:
            self._limiter.reset(self._set_point)
        if self._filter is not None:
            self._filter.reset(self._set_point)
        self._pid.reset()
        self._asked = self._joint.command

    def update(self, time: float, period: float) -> None:
        """Run the PID."""
        joint, pid, limiter, filtered = self._joint, self._pid, self._limiter, self._filter
        state, wraps = joint.state, self._wraps
        # Limits are enforced in place: here stands what they left of the last command.
        cut, integral = self._asked - joint.command, pid.integral
        reference = self._set_point
        # A reference that rests, as most do, is left as it is: calls are what this loop costs.
        if limiter is not None:
            if wraps:
                reference = _near(reference, limiter.position)
            if reference != limiter.position or limiter.velocity != 0.0:
                reference = limiter.update(reference, period)
        error_dot = None
        if filtered is not None:
            if wraps:
                reference = _near(reference, filtered.position)
            error_dot = -state.velocity
            if reference != filtered.position or filtered.velocity != 0.0:
                reference, velocity = filtered.update(reference, period)
                error_dot += velocity
        error = reference - state.position
        if wraps:
            error = math.remainder(error, 2.0 * math.pi)
        command = pid.update(error, period, error_dot)
        if cut and cut * pid.gains.i * pid.error > 0.0:
            pid.integral = integral
        if self._gravity is not None:
            command += self._gravity.effort(time)
        self._asked = joint.command = command
        self._pids.publish(time)
        if self._state.is_due():
            set_point = self._set_point
            self._state.publish(
                time, period, set_point, joint.state.position, self._difference(set_point)
            )

    def stopping(self, time: float) -> None:
        """Leave the joint without effort."""
        self._joint.command = 0.0

    def _difference(self, target: float) -> float:
        """Distance from the measured position to `target`, the short way round."""
        difference = target - self._joint.state.position
        return math.remainder(difference, 2.0 * math.pi) if self._wraps else difference


def _near(target: float, position: float) -> float:
    """Return `target` (rad), on the turn that is nearest to `position`."""
    return position + math.remainder(target - position, 2.0 * math.pi)
