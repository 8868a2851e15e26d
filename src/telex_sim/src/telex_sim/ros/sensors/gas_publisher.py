"""The topic ``gas`` of one robot."""

from __future__ import annotations

import rospy
from telex_msgs.msg import Gas

from ...engine.gas_sensor import GasSensor
from ...engine.simulation import Simulation
from ...robot.robot import Robot

_PER_MILLION = 1.0e6


class GasPublisher:
    """Publishes what a robot's gas sensor reads, in scenes with leaks."""

    def __init__(self, robot: Robot) -> None:
        self._sensor = GasSensor(robot)
        robot.watchers = (*robot.watchers, self._sensor)
        self._link = robot.config.gas.link
        self._topic = rospy.Publisher(f"{robot.namespace}/gas", Gas, queue_size=1)

    def publish(self, simulation: Simulation, stamp: rospy.Time) -> None:
        """Read the sensor and publish it; in the simulation's thread."""
        share = self._sensor.observe(simulation)
        if share is None:
            return
        # To a whole part per million, as such sensors tell.
        message = Gas(concentration=float(round(_PER_MILLION * share)))
        message.header.stamp = stamp
        message.header.frame_id = self._link
        self._topic.publish(message)

    def close(self) -> None:
        """Take the topic back."""
        self._topic.unregister()
