"""Pictures from ROS topics."""

from __future__ import annotations

import time
from typing import Callable, Optional

import rospy
from sensor_msgs.msg import CompressedImage, Image

from ..ros_clock import RosClock
from .pictures import CompressedPicture, Picture, RawPicture
from .topics import PictureTopic, Topics, find_topic

OLDEST = 10.0
"""Age (s) above which a stamp counts as one of another clock, or of a latched picture."""

RECEIVE_SIZE = 2**17
"""Bytes that rospy reads at once. It allocates as many every time, which above this size means
fresh pages from the kernel: 30 us more for every picture."""


def captured_at(stamp: float, ros_now: float, wall_now: float) -> float:
    """Return the wall time (s) at which a picture that comes now was taken.

    Stamps are ROS time, which in a simulation is not the wall's. How old a stamp is by ROS time is
    taken for its age by the wall: exact at a real-time factor of 1, but for the period of /clock.

    Parameters
    ----------
    stamp
        Of the picture (s of ROS time).
    ros_now, wall_now
        The time now (s), by both clocks.
    """
    age = ros_now - stamp
    return wall_now - age if 0.0 <= age <= OLDEST else wall_now


class RosPictureSource:
    """Finds and subscribes to image topics; all that asks the ROS master may block."""

    def __init__(self) -> None:
        self._clock = RosClock()

    def sim_time(self) -> float:
        """Return the present ROS time (s) as it goes on between two messages of `/clock`."""
        return self._clock()

    def topics(self) -> Topics:
        """Return the published topics and their types."""
        return dict(rospy.get_published_topics())

    def find(self, topic: str, *, raw: bool = False) -> Optional[PictureTopic]:
        """Return the topic to subscribe to for a name as clients spell it, or None."""
        return find_topic(topic, self.topics(), rospy.get_namespace(), raw=raw)

    def subscribe(
        self, topic: PictureTopic, receive: Callable[[Picture], None]
    ) -> Callable[[], None]:
        """Call `receive` in rospy's thread with every picture; return a function that ends this."""

        def receive_compressed(message: CompressedImage) -> None:
            stamp = message.header.stamp.to_sec()
            captured = captured_at(stamp, rospy.get_time(), time.time())
            receive(CompressedPicture(stamp, message.data, captured))

        def receive_raw(message: Image) -> None:
            stamp = message.header.stamp.to_sec()
            receive(
                RawPicture(
                    stamp,
                    message.width,
                    message.height,
                    message.step,
                    message.encoding,
                    message.data,
                    captured_at(stamp, rospy.get_time(), time.time()),
                    bool(message.is_bigendian),
                )
            )

        # Pictures that wait are read one after the other faster than the hub takes them, which
        # keeps the newest only: the buffer need not hold them all.
        subscriber = rospy.Subscriber(
            topic.name,
            CompressedImage if topic.compressed else Image,
            receive_compressed if topic.compressed else receive_raw,
            queue_size=1,
            buff_size=RECEIVE_SIZE,
            tcp_nodelay=True,
        )
        return subscriber.unregister

    def parameter(self, name: str) -> object:
        """Return a parameter, or None if it is not set."""
        return rospy.get_param(name, None)
