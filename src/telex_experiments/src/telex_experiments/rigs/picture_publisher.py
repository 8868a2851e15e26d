"""A camera that costs nothing: publishes one picture again and again, stamped with the wall time.

    picture_publisher.py NAME:WIDTHxHEIGHT@RATE ...

publishes on /telex/cameras/NAME/image_raw/compressed until it is ended; a NAME with a slash is
that of another stream of a camera: front/preview is /telex/cameras/front/preview/compressed.
"""

from __future__ import annotations

import heapq
import sys
import time
from typing import List, Tuple

import cv2
import numpy as np
import rospy
import simplejpeg
from sensor_msgs.msg import CompressedImage

BYTES_PER_PIXEL = 0.165
"""Of a camera's JPEG, as measured on the simulator's pictures at the default quality."""


def picture(width: int, height: int) -> bytes:
    """Make a JPEG of a camera's usual number of bytes."""
    rng = np.random.default_rng(1)
    noise = rng.integers(0, 255, (height, width, 3), np.uint8)
    pixels = cv2.GaussianBlur(noise, (0, 0), 1.5)
    best = b""
    for quality in range(20, 100, 2):
        best = simplejpeg.encode_jpeg(pixels, quality=quality, colorsubsampling="420")
        if len(best) >= BYTES_PER_PIXEL * width * height:
            break
    return best


def main() -> None:
    """Publish until the node is shut down."""
    rospy.init_node("picture_publisher")
    due: List[Tuple[float, int]] = []
    cameras = []
    now = time.monotonic()
    for number, spec in enumerate(sys.argv[1:]):
        name, _, rest = spec.partition(":")
        size, _, rate = rest.partition("@")
        width, height = (int(each) for each in size.split("x"))
        stream = name if "/" in name else f"{name}/image_raw"
        topic = f"/telex/cameras/{stream}/compressed"
        publisher = rospy.Publisher(topic, CompressedImage, queue_size=1, tcp_nodelay=True)
        message = CompressedImage(format="jpeg", data=picture(width, height))
        cameras.append((publisher, message, 1.0 / float(rate)))
        # Cameras of a robot do not fire at once either.
        heapq.heappush(due, (now + 1.0 + 0.007 * number, number))
    while not rospy.is_shutdown():
        when, number = heapq.heappop(due)
        time.sleep(max(0.0, when - time.monotonic()))
        publisher, message, period = cameras[number]
        if publisher.get_num_connections():
            message.header.stamp = rospy.Time.from_sec(time.time())
            publisher.publish(message)
        heapq.heappush(due, (when + period, number))


if __name__ == "__main__":
    main()
