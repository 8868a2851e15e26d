"""Pictures from ROS topics."""

from __future__ import annotations

from typing import Callable, Optional

import rospy
from sensor_msgs.msg import CompressedImage, Image

from .hub import Picture
from .pictures import CompressedPicture, RawPicture
from .topics import PictureTopic, Topics, find_topic


class RosPictureSource:
    """Finds and subscribes to image topics; every method asks the ROS master and may block."""

    def topics(self) -> Topics:
        """Return the published topics and their types."""
        return dict(rospy.get_published_topics())

    def find(self, topic: str) -> Optional[PictureTopic]:
        """Return the topic to subscribe to for a name as clients spell it, or None."""
        return find_topic(topic, self.topics(), rospy.get_namespace())

    def subscribe(
        self, topic: PictureTopic, receive: Callable[[Picture], None]
    ) -> Callable[[], None]:
        """Call `receive` in rospy's thread with every picture; return a function that ends this."""

        def receive_compressed(message: CompressedImage) -> None:
            receive(CompressedPicture(message.header.stamp.to_sec(), message.data))

        def receive_raw(message: Image) -> None:
            receive(
                RawPicture(
                    message.header.stamp.to_sec(),
                    message.width,
                    message.height,
                    message.step,
                    message.encoding,
                    message.data,
                )
            )

        # With a queue of one and a buffer that takes all that waits in the socket, only the
        # newest picture survives.
        subscriber = rospy.Subscriber(
            topic.name,
            CompressedImage if topic.compressed else Image,
            receive_compressed if topic.compressed else receive_raw,
            queue_size=1,
            buff_size=2**24,
            tcp_nodelay=True,
        )
        return subscriber.unregister

    def parameter(self, name: str) -> object:
        """Return a parameter, or None if it is not set."""
        return rospy.get_param(name, None)
