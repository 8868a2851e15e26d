"""Pictures of a played bag, unpacked."""

from __future__ import annotations

import numpy as np
import pytest
import simplejpeg
from rospy import Time
from sensor_msgs.msg import CompressedImage

from telex_sim.ros.replay_images_node import unpacked


def test_a_picture_keeps_its_content_size_and_stamp():
    picture = np.zeros((24, 40, 3), np.uint8)
    picture[:, :20] = (250, 20, 10)
    message = CompressedImage(format="jpeg", data=simplejpeg.encode_jpeg(picture, 95))
    message.header.stamp = Time(3, 5)
    message.header.frame_id = "front_camera_optical_frame"
    found = unpacked(message)
    assert (found.width, found.height, found.step, found.encoding) == (40, 24, 120, "rgb8")
    assert found.header == message.header
    pixels = np.frombuffer(found.data, np.uint8).reshape(24, 40, 3)
    assert np.abs(pixels[12, 5].astype(int) - (250, 20, 10)).max() < 12
    assert pixels[12, 35].max() < 12


def test_what_is_no_picture_is_refused():
    with pytest.raises(ValueError):
        unpacked(CompressedImage(format="jpeg", data=b"nothing"))
