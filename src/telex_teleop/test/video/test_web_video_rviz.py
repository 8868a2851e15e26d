"""rviz shows a camera's pictures, on a display that only exists in memory."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess

import numpy as np
import pytest
from sample_pictures import BLUE, RED, two_halves
from waiting import wait_until
from web_harness import Ros, stop_process

pytestmark = [
    pytest.mark.ros,
    *(
        pytest.mark.skipif(shutil.which(program) is None, reason=f"{program} is not installed")
        for program in ("rviz", "Xvfb")
    ),
]

CAMERA = "/telex/cameras/front/image_raw"
CONFIG = f"""
Visualization Manager:
  Displays:
    - Class: rviz/Image
      Name: Camera
      Enabled: true
      Image Topic: {CAMERA}
      Transport Hint: raw
Window Geometry:
  Camera:
    collapsed: false
  Width: 800
  Height: 600
"""


def pixels(screen):
    """Return the pixels (height, width, 3) of a screen that Xvfb keeps in a file.

    The file is a screen dump of the X window system (XWDFile.h): a head of 32 bit numbers, a table
    of colours of 12 bytes each, then blue, green, red and a byte of padding for each pixel.
    """
    data = screen.read_bytes()
    head = struct.unpack(">25I", data[:100])
    size, width, height, row, colours = head[0], head[4], head[5], head[12], head[19]
    rows = np.frombuffer(data, np.uint8, row * height, size + 12 * colours).reshape(height, row)
    return rows[:, : 4 * width].reshape(height, width, 4)[:, :, 2::-1]


@pytest.fixture
def display(tmp_path):
    """A screen in memory: the environment of its programs, and its file."""
    read, write = os.pipe()
    server = subprocess.Popen(
        [
            *("Xvfb", "-displayfd", str(write), "-fbdir", str(tmp_path), "-nolisten", "tcp"),
            *("-screen", "0", "800x600x24"),
        ],
        pass_fds=(write,),
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    os.close(write)
    with os.fdopen(read) as numbers:
        number = numbers.readline().strip()  # comes when the screen is ready; empty if it ended
    assert number
    yield {"DISPLAY": f":{number}"}, tmp_path / "Xvfb_screen0"
    stop_process(server)


def test_rviz_shows_a_camera(display, tmp_path):
    environment, screen = display
    config = tmp_path / "camera.rviz"
    config.write_text(CONFIG)
    picture = two_halves(640, 480)
    message = {"width": 640, "height": 480, "step": 1920, "encoding": "rgb8"}
    with Ros() as ros:
        ros.environment.update(environment, HOME=str(tmp_path), LIBGL_ALWAYS_SOFTWARE="1")
        ros.probe().publish(
            CAMERA, "sensor_msgs/Image", message, rate=5, hex={"data": picture.tobytes().hex()}
        )
        ros.start(["rviz", "-d", str(config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(lambda: any("rviz" in node for node in ros.subscribers(CAMERA)), timeout=60.0)

        def places(colour):
            """Return the columns of the pixels of a colour."""
            return np.nonzero(abs(pixels(screen).astype(int) - colour).max(axis=2) < 6)[1]

        # As large as a stamp at least, and both halves of it.
        wait_until(lambda: min(map(len, map(places, (RED, BLUE)))) > 2000, timeout=60.0, period=0.2)
        assert places(RED).max() < places(BLUE).min()
