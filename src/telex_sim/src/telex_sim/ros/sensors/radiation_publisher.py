"""The topics ``dosimeter``, ``cameras/radiation`` and ``sim/doses`` of one robot."""

from __future__ import annotations

from typing import Any

import rospy
from std_msgs.msg import Header
from telex_msgs.msg import CameraRadiation, ComponentDoses, Dosimeter

from telex_control.ros.start_order import NO_ANSWER

from ...engine.exposure import Exposure
from ...engine.simulation import Simulation
from ...radiation.messages import doses_message
from ...robot.robot import Robot


class RadiationPublisher:
    """Publishes what a robot is exposed to; in the simulation's thread.

    The cameras are those of the robot's node ``cameras``, by its parameters, from the first start
    on after they were read.
    """

    def __init__(self, robot: Robot) -> None:
        namespace = robot.namespace
        self._robot = robot
        # Replaced as a whole, never changed: the loop reads it without a lock.
        self._described: Any = {}
        self.find_cameras()
        self._exposure = Exposure(robot, lambda: self._described)
        robot.watchers = (*robot.watchers, self._exposure)
        self._starts = -1
        self._tells = False
        self._dosimeter = rospy.Publisher(f"{namespace}/dosimeter", Dosimeter, queue_size=1)
        # Latched: a node of cameras that begins anew while the simulation is paused must know.
        self._cameras = rospy.Publisher(
            f"{namespace}/cameras/radiation", CameraRadiation, queue_size=1, latch=True
        )
        self._doses = rospy.Publisher(f"{namespace}/sim/doses", ComponentDoses, queue_size=1)

    def find_cameras(self) -> None:
        """Read the parameters of the robot's cameras; where that fails, those known last count.

        In a thread of ROS: the loop cannot wait for a master.
        """
        name = f"{self._robot.namespace}/cameras/cameras"
        try:
            self._described = rospy.get_param(name, {})
        except NO_ANSWER as error:
            rospy.logwarn("%s cannot be read: %s; the cameras known last count", name, error)

    def publish(self, simulation: Simulation, stamp: rospy.Time) -> None:
        """Expose the robot to the field until now; every second time, and at a start, tell it."""
        readings = self._exposure.observe(simulation)
        if readings is None:
            if self._starts < 0:
                # A simulator that has crashed may have told the cameras of doses.
                self._starts = self._robot.starts
                self._cameras.publish(CameraRadiation(header=Header(stamp=stamp)))
            return
        self._tells = not self._tells or self._robot.starts != self._starts
        self._starts = self._robot.starts
        if not self._tells:
            return
        cameras = CameraRadiation(
            names=[camera.name for camera in readings.cameras],
            dose_rate=[camera.dose_rate for camera in readings.cameras],
            dose=[camera.dose for camera in readings.cameras],
            failed=[camera.failed for camera in readings.cameras],
        )
        dosimeter = Dosimeter(
            hull_rate=readings.hull_rate,
            tool_rate=readings.tool_rate,
            detector=readings.detector,
            total=readings.total,
            alarm=readings.alarm,
        )
        doses = doses_message(readings.components)
        cameras.header.stamp = dosimeter.header.stamp = doses.header.stamp = stamp
        self._cameras.publish(cameras)
        self._dosimeter.publish(dosimeter)
        self._doses.publish(doses)

    def close(self) -> None:
        """Take the topics back."""
        self._dosimeter.unregister()
        self._cameras.unregister()
        self._doses.unregister()
