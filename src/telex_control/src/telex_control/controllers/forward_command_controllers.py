"""Controllers that hand their commands straight to the hardware."""

from __future__ import annotations

from typing import Callable, Dict, List, Sequence, Tuple, Type

from std_msgs.msg import Float64, Float64MultiArray

from ..common.plausible import effort_problem, position_problem, speed_problem
from ..hardware.hardware_interface import (
    EffortJointInterface,
    JointCommandInterface,
    JointHandle,
    PositionJointInterface,
    RobotHW,
    VelocityJointInterface,
)
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle

_PROBLEMS: Dict[Type[JointCommandInterface], Callable[[float], str]] = {
    EffortJointInterface: effort_problem,
    PositionJointInterface: position_problem,
    VelocityJointInterface: speed_problem,
}


class ForwardCommandController(Controller):
    """Forwards commands to joints, from the cycle after their arrival on.

    A started controller commands what keeps the joints where they are: positions as measured, no
    velocity, no effort. Until it is started, commands are dropped.

    Attributes
    ----------
    interface : class
        Through which the joints are commanded.
    """

    SAVED = ("_commands",)
    interface: Type[JointCommandInterface]

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the joints and open the topic."""
        self._node = node
        interface = hw.get(self.interface)
        self._joints: List[JointHandle] = [
            interface.get_handle(name) for name in self._joint_names(node)
        ]
        # Replaced as a whole by the subscriber's thread.
        self._commands: Tuple[float, ...] = self._rest()
        self._subscribe(node)

    def _joint_names(self, node: NodeHandle) -> Sequence[str]:
        raise NotImplementedError

    def _subscribe(self, node: NodeHandle) -> None:
        raise NotImplementedError

    def _rest(self) -> Tuple[float, ...]:
        if self.interface is PositionJointInterface:
            return tuple(joint.state.position for joint in self._joints)
        return (0.0,) * len(self._joints)

    def _store(self, commands: Sequence[float]) -> None:
        if len(commands) != len(self._joints):
            self._node.warn(
                f"{self._node.resolve('command')}: a command of {len(commands)} numbers is "
                f"dropped; {len(self._joints)} are needed, for "
                + ", ".join(joint.name for joint in self._joints)
            )
            return
        for joint, command in zip(self._joints, commands):
            problem = _PROBLEMS[self.interface](command)
            if problem:
                self._node.warn(
                    f"{self._node.resolve('command')}: joint '{joint.name}': command {command} "
                    f"{problem} and is dropped"
                )
                break
        else:
            self._commands = tuple(commands)

    def starting(self, time: float) -> None:
        """Keep the joints where they are; commands from before are forgotten."""
        self._commands = self._rest()
        self.update(time, 0.0)

    def update(self, time: float, period: float) -> None:
        """Forward the commands."""
        for joint, command in zip(self._joints, self._commands):
            joint.command = command

    def stopping(self, time: float) -> None:
        """Leave the joints at rest."""
        for joint, command in zip(self._joints, self._rest()):
            joint.command = command


class _JointController(ForwardCommandController):
    """One joint: parameter ``joint``, topic ``command`` (std_msgs/Float64)."""

    parameters = frozenset(("joint",))

    def _joint_names(self, node: NodeHandle) -> Sequence[str]:
        return [node.param("joint", str)]

    def _subscribe(self, node: NodeHandle) -> None:
        node.subscribe("command", Float64, lambda message: self._store((message.data,)))


class _JointGroupController(ForwardCommandController):
    """Some joints: parameter ``joints``, topic ``command`` (std_msgs/Float64MultiArray)."""

    parameters = frozenset(("joints",))

    def _joint_names(self, node: NodeHandle) -> Sequence[str]:
        return node.names_param("joints")

    def _subscribe(self, node: NodeHandle) -> None:
        node.subscribe("command", Float64MultiArray, lambda message: self._store(message.data))


class JointEffortController(_JointController):
    """``effort_controllers/JointEffortController``: Nm or N."""

    interface = EffortJointInterface


class JointGroupEffortController(_JointGroupController):
    """``effort_controllers/JointGroupEffortController``: Nm or N."""

    interface = EffortJointInterface


class JointPositionController(_JointController):
    """``position_controllers/JointPositionController``: rad or m."""

    interface = PositionJointInterface


class JointGroupPositionController(_JointGroupController):
    """``position_controllers/JointGroupPositionController``: rad or m."""

    interface = PositionJointInterface


class JointVelocityController(_JointController):
    """``velocity_controllers/JointVelocityController``: rad/s or m/s."""

    interface = VelocityJointInterface


class JointGroupVelocityController(_JointGroupController):
    """``velocity_controllers/JointGroupVelocityController``: rad/s or m/s."""

    interface = VelocityJointInterface
