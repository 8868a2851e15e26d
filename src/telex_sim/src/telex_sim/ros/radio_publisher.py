"""The topic ``sim/radio`` of one robot."""

from __future__ import annotations

import rospy
from telex_msgs.msg import Radio

from ..engine.simulation import Simulation
from ..radio.reception import signal_of, thicknesses_between
from ..robot.robot import Robot


class RadioPublisher:
    """Publishes the signal between a robot and its operator's antenna, while somebody listens.

    Parameters
    ----------
    robot : Robot
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._topic = rospy.Publisher(f"{robot.namespace}/sim/radio", Radio, queue_size=1)

    def publish(self, simulation: Simulation, stamp: rospy.Time) -> None:
        """Compute and publish the signal; in the simulation's thread."""
        if not self._topic.get_num_connections():
            return
        config = self._robot.config.radio
        antenna = config.antenna
        if not antenna:
            start = simulation.scene.start
            antenna = (start.x, start.y, start.ground + config.antenna_height)
        x, y, z = self._robot.body.base_pose()[0]
        place = (x, y, z + config.robot_height)
        robots = {robot.body.uid for robot in simulation.robots}
        walls = thicknesses_between(simulation.world.client, antenna, place, robots)
        distance = sum((one - other) ** 2 for one, other in zip(antenna, place)) ** 0.5
        signal = signal_of(config, distance, walls)
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
