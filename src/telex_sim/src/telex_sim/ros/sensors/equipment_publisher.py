"""A robot's equipment and its readings: two parameters and a topic in its namespace."""

from __future__ import annotations

import contextlib
import socket
from typing import Any, Dict, Optional

import rospy
from sensor_msgs.msg import Range
from std_msgs.msg import Float64

from ...equipment.errors import Errors
from ...equipment.object_width import object_width
from ...equipment.range_finder import RangeFinder
from ...proximity.monitor import Proximity
from ...robot.gripper.contact import GripperContact, PadContact
from ...robot.robot import Robot
from .microphone_publisher import SURFACE

EQUIPMENT, TRAINING_AIDS = "equipment", "training_aids"
"""Parameters: what the variant declares, and what in practice stands in for what it lacks."""


class EquipmentPublisher:
    """Tells what equipment a robot has, and publishes what its range finder reads.

    A robot without one has a training aid in its place, which is exact, on a topic in ``sim``; so
    has each with fingers one that measures how wide it is what they could close on.
    """

    def __init__(self, robot: Robot) -> None:
        self._config = config = robot.config.equipment
        self._robot = robot
        self._namespace = robot.namespace
        self._finder: Optional[RangeFinder] = None
        finder = config.range_finder
        topic = ""
        if "range_finder" in robot.equipment:
            self._finder = RangeFinder(robot, finder)
            topic = f"{robot.namespace}/{finder.topic}"
        elif finder.training_link in robot.links:
            self._finder = RangeFinder.training_aid(robot, finder)
            topic = f"{robot.namespace}/sim/{finder.topic}"
        if self._finder is not None:
            robot.watchers = (*robot.watchers, self._finder)
            self._topic = rospy.Publisher(topic, Range, queue_size=1, tcp_nodelay=True)
            self._message = Range(
                radiation_type=Range.INFRARED,
                field_of_view=finder.field_of_view,
                min_range=finder.min,
                max_range=finder.max,
            )
            self._message.header.frame_id = self._finder.link
        self._width: Optional[rospy.Publisher] = None
        if self._finder is not None and robot.has_pads and finder.training_link in robot.links:
            width = f"{robot.namespace}/sim/object_width"
            self._width = rospy.Publisher(width, Float64, queue_size=1, tcp_nodelay=True)
        self._proximity_errors = Errors(robot, "proximity", config.proximity.seed)
        self._pad_errors = Errors(robot, "pads", config.pads.seed)
        robot.watchers = (*robot.watchers, self._proximity_errors, self._pad_errors)
        described = self._described(robot)
        for parameter, is_equipment in ((EQUIPMENT, True), (TRAINING_AIDS, False)):
            told = {
                name: each
                for name, each in described.items()
                if (name in robot.equipment) == is_equipment
            }
            rospy.set_param(f"{self._namespace}/{parameter}", told)

    def _described(self, robot: Robot) -> Dict[str, Dict[str, Any]]:
        """What is told of each piece that is there, or that has a stand-in."""
        config, present = self._config, robot.equipment
        described: Dict[str, Dict[str, Any]] = {}
        if self._finder is not None:
            finder = config.range_finder
            described["range_finder"] = {
                "topic": self._topic.resolved_name,
                "frame": self._finder.link,
                "min": finder.min,
                "max": finder.max,
                "rate": finder.rate,
            }
        if self._width is not None:
            described["object_width"] = {"topic": self._width.resolved_name}
        if "laser_dots" in present:
            lasers = config.laser_dots
            described["laser_dots"] = {"frames": list(lasers.links), "max": lasers.max}
        proximity = robot.config.proximity
        if proximity.rate and any(robot.hw.has_joint(name) for name in proximity.joints):
            topic = rospy.resolve_name(f"{self._namespace}/sim/proximity")
            described["proximity"] = {"topic": topic, "max": proximity.range}
        if "microphone" in present:
            microphone = config.microphone
            described["microphone"] = {
                "topic": rospy.resolve_name(f"{self._namespace}/{SURFACE}"),
                "frame": microphone.link,
                "noise": microphone.noise,
                "max": microphone.max,
            }
        if robot.has_pads and robot.config.gripper_contact.rate:
            topic = rospy.resolve_name(f"{self._namespace}/sim/gripper_contact")
            described["pads"] = {"topic": topic, "max": config.pads.max}
        return described

    @property
    def rate(self) -> float:
        """How often the range finder is read (Hz of sim time); 0: there is none."""
        return 0.0 if self._finder is None else self._config.range_finder.rate

    def publish_range(self, stamp: rospy.Time) -> None:
        """Read the range finder, and measure what it meets, as far as anybody listens.

        In the simulation's thread.
        """
        if self._finder is None:
            return
        config = self._config.range_finder
        if self._width is not None and self._width.get_num_connections():
            body, link = self._robot.body, self._finder.link
            self._width.publish(object_width(body, link, config.training_link, config.max))
        if not self._topic.get_num_connections():
            return
        message = self._message
        message.header.stamp = stamp
        message.range = self._finder.measure()
        self._topic.publish(message)

    def sensed(self, near: Proximity) -> Proximity:
        """Add the errors of the sensors that feel what is near; a training aid has none."""
        deviation = self._config.proximity.noise
        if "proximity" not in self._robot.equipment or not deviation:
            return near
        draw = self._proximity_errors.draw
        pairs = [
            pair._replace(place=pair.place._replace(distance=pair.place.distance + draw(deviation)))
            for pair in near.pairs
        ]
        return near._replace(pairs=tuple(pairs))

    def felt(self, contact: GripperContact) -> GripperContact:
        """Add the errors and limits of the pads that feel forces; a training aid has none."""
        config = self._config.pads
        if "pads" not in self._robot.equipment:
            return contact

        def told(force: float) -> float:
            # What is touched by nothing is known to be so: such pads are set to zero empty.
            error = self._pad_errors.draw(config.noise) if force > 0.0 else 0.0
            return min(max(force + error, 0.0), config.max)

        def felt(pad: PadContact) -> PadContact:
            across, along = told(pad.normal_force), told(pad.friction_force)
            return pad._replace(normal_force=across, friction_force=along)

        first, second = contact.pads
        return contact._replace(force=told(contact.force), pads=(felt(first), felt(second)))

    def close(self) -> None:
        """Take topic and parameters back."""
        if self._finder is not None:
            self._topic.unregister()
        if self._width is not None:
            self._width.unregister()
        for name in (EQUIPMENT, TRAINING_AIDS):
            # The master may be gone, or somebody has deleted them.
            with contextlib.suppress(KeyError, rospy.ROSException, socket.error):
                rospy.delete_param(f"{self._namespace}/{name}")
