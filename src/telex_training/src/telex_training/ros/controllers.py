"""A port to a robot's controllers, past its teleoperation nodes."""

from __future__ import annotations

from typing import Callable

from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

from telex_control.ros.node_handle import NodeHandle

from ..operators.port import Command, Drive, JointTargets, Observation, Port
from .commands import TopicPublishers
from .observer import Observer

_TRACKS = "track_controller/cmd_vel"


class ControllerTopics(Port):
    """Takes `Drive` and `JointTargets`.

    Parameters
    ----------
    advance : callable
        Lets so much sim time (s) pass, and returns once its messages are there.

    Attributes
    ----------
    observer : Observer
    """

    def __init__(self, node: NodeHandle, advance: Callable[[float], None]) -> None:
        self.observer = Observer(node, teleop=False)
        self._publishers = TopicPublishers(node)
        # Made now, so that it is connected by the first command.
        self._publishers.publisher(_TRACKS, Twist)
        self._advance = advance

    def observe(self) -> Observation:
        """See `Port.observe`."""
        return self.observer.observation()

    def advance(self, seconds: float) -> None:
        """See `Port.advance`."""
        self._advance(seconds)

    def send(self, command: Command) -> None:
        """See `Port.send`."""
        if isinstance(command, Drive):
            message = Twist()
            message.linear.x, message.angular.z = command.linear, command.angular
            self._publishers.publish(_TRACKS, message)
        elif isinstance(command, JointTargets):
            for joint, position in command.positions.items():
                stem = joint[: -len("_joint")]
                self._publishers.publish(f"{stem}_position_controller/command", Float64(position))
        else:
            raise TypeError(f"the controllers take Drive and JointTargets, not {command!r}")
