"""Operators' commands as messages."""

from __future__ import annotations

from typing import Any, Dict, Tuple

from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from std_msgs.msg import String
from telex_msgs.msg import FlipperPresetHold

from telex_control.kinematics import quaternion_of
from telex_control.ros.node_handle import NodeHandle, Publisher

from ..operators.port import Command, Drive, FlipperPreset, Jog, NamedPose, ToolPose, ToolTwist


class TopicPublishers:
    """Publishers of a robot's topics, made when they are first needed."""

    def __init__(self, node: NodeHandle) -> None:
        self._node = node
        self._publishers: Dict[str, Publisher] = {}

    def publish(self, topic: str, message: Any) -> None:
        """Publish a message on a topic of the robot."""
        self.publisher(topic, type(message)).publish(message)

    def publisher(self, topic: str, kind: Any) -> Publisher:
        """Return the publisher of a topic, whose messages are of class `kind`."""
        if topic not in self._publishers:
            self._publishers[topic] = self._node.advertise(topic, kind)
        return self._publishers[topic]


def message_of(command: Command) -> Tuple[str, Any]:
    """Return the topic of a teleoperation node, and the message, for a command.

    Raises
    ------
    TypeError
        None of them takes it.
    """
    if isinstance(command, Drive):
        return "track_teleop/cmd_vel", _twist(
            (command.linear, 0.0, 0.0), (0.0, 0.0, command.angular)
        )
    if isinstance(command, Jog):
        names, rates = list(command.rates), list(command.rates.values())
        jog = JointJog(joint_names=names, velocities=rates)
        return f"{command.node}/delta_joint_cmds", jog
    if isinstance(command, FlipperPreset):
        return "flipper_teleop/preset_cmds", FlipperPresetHold(preset=command.name)
    if isinstance(command, NamedPose):
        return "arm_teleop/named_pose_cmds", String(command.name)
    if isinstance(command, ToolPose):
        return "arm_teleop/pose_cmds", _pose(command)
    if isinstance(command, ToolTwist):
        stamped = TwistStamped(twist=_twist(command.linear, command.angular))
        stamped.header.frame_id = command.frame
        return "arm_teleop/delta_twist_cmds", stamped
    raise TypeError(f"the teleoperation nodes do not take {command!r}")


def _twist(linear: Tuple[float, float, float], angular: Tuple[float, float, float]) -> Twist:
    message = Twist()
    message.linear.x, message.linear.y, message.linear.z = linear
    message.angular.x, message.angular.y, message.angular.z = angular
    return message


def _pose(command: ToolPose) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = command.frame
    at, turned = message.pose.position, message.pose.orientation
    at.x, at.y, at.z = command.target[:3, 3].tolist()
    turned.x, turned.y, turned.z, turned.w = quaternion_of(command.target).tolist()
    return message
