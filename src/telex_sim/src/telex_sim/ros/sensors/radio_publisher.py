"""The topic ``sim/radio`` of one robot."""

from __future__ import annotations

import rospy
from telex_msgs.msg import Radio

from ...engine.radio import signal_at
from ...engine.simulation import Simulation
from ...robot.robot import Robot


class RadioPublisher:
    """Publishes the signal between a robot and its operator's antenna, while somebody listens."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._topic = rospy.Publisher(f"{robot.namespace}/sim/radio", Radio, queue_size=1)

    def publish(self, simulation: Simulation, stamp: rospy.Time) -> None:
        """Compute and publish the signal; in the simulation's thread."""
        if not self._topic.get_num_connections():
            return
        signal = signal_at(simulation, self._robot)
        message = Radio(
            distance=signal.distance,
            walls=signal.walls,
            power=signal.power,
            quality=signal.quality,
        )
        message.header.stamp = stamp
        message.header.frame_id = "world"
        self._topic.publish(message)

    def close(self) -> None:
        """Take the topic back."""
        self._topic.unregister()
