"""``effort_controllers/JointGroupPositionController``: joints held at positions by PIDs."""

from __future__ import annotations

import math
from typing import List, NamedTuple, Optional, Tuple

from std_msgs.msg import Float64MultiArray

from ..common.plausible import position_problem
from ..hardware.hardware_interface import EffortJointInterface, JointHandle, RobotHW
from ..hardware.joint_limits import clamp
from ..laws.gravity import JointGravity
from ..laws.pid import Pid
from ..laws.pid_reconfigure import PidSet
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle
from ..urdf.joints import CONTINUOUS
from .joint_description import joint_description, joint_gravity


class _Joint(NamedTuple):
    handle: JointHandle
    lower: float
    upper: float
    wraps: bool
    pid: Pid
    gravity: Optional[JointGravity]


class EffortJointGroupPositionController(Controller):
    """Holds some joints at the commanded positions by effort.

    Topic: ``command`` (std_msgs/Float64MultiArray; rad or m, in the order of the joints; a
    command of another length is dropped). Parameters: ``joints``, ``<joint>/pid``,
    ``gravity_compensation`` (false). Needs ``robot_description`` for the position limits, to which
    commands are clamped.
    """

    SAVED = ("_set_points",)
    SAVED_PARTS = ("_gravities", "_loops")

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joints and open the topic."""
        self._node = node
        names = node.names_param("joints")
        interface = hw.get(EffortJointInterface)
        compensated = node.param("gravity_compensation", bool, False)
        self._pids = PidSet(node)
        self._joints: List[_Joint] = []
        for name in names:
            handle = interface.get_handle(name)
            limits = joint_description(root, name)
            gravity = joint_gravity(hw, root, name) if compensated else None
            self._joints.append(
                _Joint(
                    handle,
                    limits.lower,
                    limits.upper,
                    limits.kind == CONTINUOUS,
                    self._pids.open(f"{name}/pid"),
                    gravity,
                )
            )
        self._loops = [joint.pid for joint in self._joints]
        self._gravities = [joint.gravity for joint in self._joints if joint.gravity is not None]
        self._set_points: Tuple[float, ...] = (0.0,) * len(names)
        node.subscribe("command", Float64MultiArray, self._on_command)

    def _on_command(self, message: Float64MultiArray) -> None:
        commands = message.data
        topic = self._node.resolve("command")
        if len(commands) != len(self._joints):
            self._node.warn(
                f"{topic}: a command of {len(commands)} numbers is dropped; "
                f"{len(self._joints)} are needed, for "
                + ", ".join(joint.handle.name for joint in self._joints)
            )
            return
        for joint, command in zip(self._joints, commands):
            problem = position_problem(command, joint.lower, joint.upper)
            if problem:
                self._node.warn(
                    f"{topic}: joint '{joint.handle.name}': command {command} {problem} and is "
                    "dropped, with those of the other joints"
                )
                break
        else:
            self._set_points = tuple(
                clamp(command, joint.lower, joint.upper)
                for joint, command in zip(self._joints, commands)
            )

    def starting(self, time: float) -> None:
        """Hold the measured positions."""
        self._set_points = tuple(
            clamp(joint.handle.state.position, joint.lower, joint.upper) for joint in self._joints
        )
        for joint in self._joints:
            joint.pid.reset()

    def update(self, time: float, period: float) -> None:
        """Run the PIDs."""
        for joint, set_point in zip(self._joints, self._set_points):
            error = set_point - joint.handle.state.position
            if joint.wraps:
                error = math.remainder(error, 2.0 * math.pi)
            command = joint.pid.update(error, period)
            if joint.gravity is not None:
                command += joint.gravity.effort(time)
            joint.handle.command = command
        self._pids.publish(time)

    def stopping(self, time: float) -> None:
        """Leave the joints without effort."""
        for joint in self._joints:
            joint.handle.command = 0.0
