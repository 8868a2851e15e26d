"""Hands of a script: the topics that an operator's console publishes on, held for a while."""

from __future__ import annotations

from typing import Mapping

import rospy
from control_msgs.msg import JointJog
from geometry_msgs.msg import Twist

PERIOD = 0.02
"""Sim time from one message to the next (s), as of a held key."""


class Jogger:
    """Moves the arm's joints through ``arm_teleop``, and the base through ``track_teleop``.

    Parameters
    ----------
    namespace : str
        Of the robot.
    """

    def __init__(self, namespace: str) -> None:
        self._arm = rospy.Publisher(
            f"{namespace}/arm_teleop/delta_joint_cmds", JointJog, queue_size=1
        )
        self._tracks = rospy.Publisher(f"{namespace}/track_teleop/cmd_vel", Twist, queue_size=1)
        self._await(self._arm)
        self._await(self._tracks)

    @staticmethod
    def _await(publisher: rospy.Publisher) -> None:
        end = rospy.get_time() + 10.0
        while not publisher.get_num_connections() and rospy.get_time() < end:
            rospy.sleep(PERIOD)

    def move(self, speeds: Mapping[str, float], seconds: float) -> None:
        """Hold velocities of joints (rad/s, m/s) for so much sim time (s), and let go."""
        message = JointJog(joint_names=list(speeds), velocities=list(speeds.values()))
        self._hold(self._arm, message, seconds)
        self._arm.publish(JointJog(joint_names=list(speeds), velocities=[0.0 for _ in speeds]))

    def drive(self, linear: float, angular: float, seconds: float) -> None:
        """Hold a velocity of the base (m/s, rad/s) for so much sim time (s), and stop."""
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self._hold(self._tracks, message, seconds)
        self._tracks.publish(Twist())

    @staticmethod
    def _hold(publisher: rospy.Publisher, message: object, seconds: float) -> None:
        end = rospy.get_time() + seconds
        while rospy.get_time() < end:
            publisher.publish(message)
            rospy.sleep(PERIOD)
