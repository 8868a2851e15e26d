"""The ground that one robot's microphone hears."""

from __future__ import annotations

from typing import Optional

import rospy
from std_msgs.msg import String

from ...robot.robot import Robot

SURFACE = "microphone/surface"
"""Topic, in the robot's namespace."""


class MicrophonePublisher:
    """Publishes, where a robot has a microphone, what it hears its belts or wheels run on.

    The sounds themselves are made where they are played.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._told: Optional[str] = None
        self._topic: Optional[rospy.Publisher] = None
        if "microphone" in robot.equipment:
            name = f"{robot.namespace}/{SURFACE}"
            self._topic = rospy.Publisher(name, String, queue_size=1, latch=True)

    def publish(self) -> None:
        """Publish it where it has changed; in the simulation's thread."""
        if self._topic is None:
            return
        surface = self._robot.surface()
        if surface != self._told:
            self._told = surface
            self._topic.publish(surface)

    def close(self) -> None:
        """Take the topic back."""
        if self._topic is not None:
            self._topic.unregister()
