"""Unpacks the pictures of a bag that is played: Debian's rviz shows none that are compressed.

Bags hold ``cameras/<name>/image_raw/compressed``; ``cameras/<name>/image_raw`` is published from it
while somebody looks.
"""

from __future__ import annotations

from typing import Sequence

import rospy
import simplejpeg
from sensor_msgs.msg import CompressedImage, Image

from telex_control.ros.node_start import init_node

CAMERAS = ("front", "rear", "arm", "gripper", "turret", "mast", "overview")


def unpacked(message: CompressedImage) -> Image:
    """Return a JPEG as raw picture, with the same stamp and frame.

    Raises
    ------
    ValueError
        It is no JPEG.
    """
    picture = simplejpeg.decode_jpeg(message.data, colorspace="RGB")
    height, width, channels = picture.shape
    return Image(
        header=message.header,
        height=height,
        width=width,
        encoding="rgb8",
        step=width * channels,
        data=picture.tobytes(),
    )


def _on_picture(message: CompressedImage, publisher: rospy.Publisher) -> None:
    if not publisher.get_num_connections():
        return
    try:
        publisher.publish(unpacked(message))
    except ValueError as error:
        rospy.logwarn_throttle(5.0, f"{publisher.name}/compressed: {error}")


def main() -> None:
    """Run the node."""
    init_node("replay_images")
    names: Sequence[str] = rospy.get_param("~cameras", list(CAMERAS))
    for name in names:
        topic = f"cameras/{name}/image_raw"
        publisher = rospy.Publisher(topic, Image, queue_size=1)
        rospy.Subscriber(f"{topic}/compressed", CompressedImage, _on_picture, publisher, 1, 1 << 22)
    rospy.spin()
