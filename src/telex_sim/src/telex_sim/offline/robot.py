"""The robot of a simulation without ROS master, commanded and seen in plain values."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.ros.node_handle import Publisher

from ..proximity.monitor import Proximity
from ..robot.gripper.contact import GripperContact
from .simulation import OfflineSimulation

Pose = Tuple[Tuple[float, ...], Tuple[float, ...]]
"""Position (m) and quaternion (x, y, z, w) in the world."""


class OfflineRobot:
    """A robot of an `OfflineSimulation`.

    Commands go to the topics of its controllers, and what its joints do comes from
    ``joint_states``: as often, and as late, as on a live robot.

    Parameters
    ----------
    node : LocalNodeHandle, optional
        Of a further robot; by default it is the first.

    Attributes
    ----------
    robot : Robot
        What it is in the simulation.
    positions, velocities : dict of str to float
        Of the joints, as they were published last (rad, m; rad/s, m/s).
    run : callable
        Advances by seconds of sim time.
    each_joint_state : list of callable
        Called with the sim time (s) of each joint state, as it is published.
    """

    def __init__(self, offline: OfflineSimulation, node: Optional[LocalNodeHandle] = None) -> None:
        self.simulation = offline.simulation
        self._node = node or offline.node
        robots = self.simulation.robots
        self.robot = next(each for each in robots if each.namespace == self._node.namespace)
        self.urdf: str = self._node.param("robot_description", str)
        self.positions: Dict[str, float] = {}
        self.velocities: Dict[str, float] = {}
        self.each_joint_state: List[Callable[[float], None]] = []
        self.run: Callable[[float], None] = offline.run
        self._tracks = self._node.advertise("track_controller/cmd_vel", Twist)
        self._targets: Dict[str, Publisher] = {}
        self._node.subscribe("joint_states", JointState, self._on_joint_states)

    def _on_joint_states(self, message: Any) -> None:
        self.positions = dict(zip(message.name, message.position))
        self.velocities = dict(zip(message.name, message.velocity))
        stamp = message.header.stamp.to_sec()
        for call in self.each_joint_state:
            call(stamp)

    def drive(self, linear: float, angular: float) -> None:
        """Send the tracks a velocity (m/s, rad/s)."""
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self._tracks.publish(message)

    def move(self, targets: Mapping[str, float]) -> None:
        """Send references (rad, m) to the position controllers of joints, by their full names."""
        for joint, target in targets.items():
            if joint not in self._targets:
                topic = f"{joint[: -len('_joint')]}_position_controller/command"
                self._targets[joint] = self._node.advertise(topic, Float64)
            self._targets[joint].publish(Float64(target))

    def base_pose(self) -> Pose:
        """Pose of base_link."""
        return self.robot.body.base_pose()

    def contact(self) -> Optional[GripperContact]:
        """What the gripper holds; None for a robot without one."""
        return self.simulation.gripper_contact(self.robot)

    def near(self) -> Proximity:
        """What the arm is near to; its numbers are in the order of `arm_joints`."""
        return self.simulation.proximity(self.robot)

    def arm_joints(self) -> Tuple[str, ...]:
        """The arm's joints."""
        return self.robot.proximity.joints

    def object_pose(self, name: str) -> Optional[Pose]:
        """Pose of an object's first link that can move, or of a link by its name ("object/link").

        None where there is no such link.
        """
        objects = self.simulation.objects
        for index, frame in enumerate(objects.frames()):
            if name in (frame, frame.split("/")[0]):
                numbers = objects.poses()[7 * index : 7 * index + 7]
                return tuple(numbers[:3]), tuple(numbers[3:])
        return None
