"""A ``cameras`` node that draws nothing and tells of each picture (a program, ROS side).

Publishes ``rendered`` (String): the direction in which the camera looks, and the picture's width.
Hears ``render_time`` (Float64): how long each picture takes from now on (s).
"""

from __future__ import annotations

import time

import numpy as np
import rospy
from std_msgs.msg import Float64, String

from telex_control.common.params import read_config
from telex_control.ros.node_start import init_node, until_shutdown
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.ros.cameras_node import CamerasNode


class CountingRenderer:
    """Tells of pictures by the direction in which the camera looks."""

    repeats = on_card = False

    def __init__(self):
        self._seconds = 0.0
        self._rendered = rospy.Publisher("rendered", String, queue_size=1000)
        rospy.Subscriber("render_time", Float64, self._set_time)

    def _set_time(self, message):
        self._seconds = message.data

    def load_scene(self, scene):
        return []

    def set_lamp_levels(self, levels):
        pass

    def place(self, frames_in_world, focus, recast=True):
        pass

    def render(self, camera, optical_in_world, exposure=1.0, coarse=False):
        time.sleep(self._seconds)
        way = "ahead" if optical_in_world[0, 2] > 0.0 else "back"
        self._rendered.publish(String(f"{way} {camera.width}"))
        return np.zeros((camera.height, camera.width, 4), np.uint8)

    def depth(self, camera):
        return np.zeros((camera.height, camera.width), np.float32)

    def release(self):
        pass


def main():
    init_node("cameras")
    config = read_config(CamerasConfig, rospy.get_param("~"), "~")
    with until_shutdown():  # a picture may be under way
        CamerasNode(config, lambda _: CountingRenderer()).run()


if __name__ == "__main__":
    main()
