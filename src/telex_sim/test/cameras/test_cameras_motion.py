"""The ``cameras`` node shows at once that something begins to move.

One run of this file as a program is the node, whose cameras are slow, beside a fake simulator.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster

# A second between pictures, unless something begins to move.
RATE = 1.0
PARAMS = {
    "cameras": {
        "front": {
            "width": 64,
            "height": 48,
            "horizontal_fov": 1.2,
            "frame": "front",
            "rate": RATE,
        }
    },
    "model": "telex",
}
TRIALS = 3


@pytest.mark.ros
@pytest.mark.real_time
def test_the_first_picture_of_a_motion_does_not_wait_for_its_turn():
    with PrivateMaster() as master:
        run = subprocess.run(
            [sys.executable, __file__],
            env=master.environment(ROS_NAMESPACE="/telex", PYTHONUNBUFFERED="1"),
            capture_output=True,
            text=True,
            timeout=120.0,
            check=False,
        )
    assert run.returncode == 0, run.stderr
    seen = json.loads(run.stdout.splitlines()[-1])
    # Each motion begins 0.2 s after a picture.
    assert statistics.median(seen["delays"]) < 0.4 / RATE
    # What goes on moving is shown at its rate.
    assert statistics.median(seen["gaps"]) > 0.6 / RATE


class StillRenderer:
    """Knows whether a picture shows what the one before it has shown."""

    on_card = False

    def __init__(self):
        self.repeats = False
        self._placed = self._drawn = np.zeros(0)

    def load_scene(self, scene):
        return []

    def set_lamp_levels(self, levels):
        pass

    def place(self, frames_in_world, focus, recast=True):
        self._placed = frames_in_world

    def render(self, camera, optical_in_world, exposure=1.0, coarse=False):
        self.repeats = np.array_equal(self._placed, self._drawn)
        self._drawn = self._placed
        return np.zeros((camera.height, camera.width, 4), np.uint8)

    def release(self):
        pass


def drill():
    """Be the node, and print when motion was seen."""
    import rospy
    from sensor_msgs.msg import CompressedImage
    from telex_msgs.msg import SceneDescription, ScenePoses

    from telex_control.common.params import read_config
    from telex_control.ros.node_start import until_shutdown
    from telex_sim.cameras.cameras_config import CamerasConfig
    from telex_sim.cameras.ros.cameras_node import CamerasNode

    miss_nothing()
    rospy.init_node("cameras")
    renderer = StillRenderer()
    node = CamerasNode(read_config(CamerasConfig, PARAMS, "cameras"), lambda config: renderer)
    scenes = rospy.Publisher("sim/scene", SceneDescription, queue_size=1, latch=True)
    scenes.publish(SceneDescription(revision=1, frames=["world", "telex/front"]))
    publisher = rospy.Publisher("sim/poses", ScenePoses, queue_size=1, tcp_nodelay=True)
    place, speed, tick = 0.0, 0.0, 0

    def simulate():
        nonlocal place, tick
        while not rospy.is_shutdown():
            tick += 1
            place += speed / 60.0
            upright = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            message = ScenePoses(revision=1, poses=[*upright, place, *upright[1:]])
            message.header.stamp = rospy.Time.from_sec(tick / 60.0)
            publisher.publish(message)
            time.sleep(1.0 / 60.0)

    pictures = []
    came = threading.Condition()

    def take(message):
        with came:
            pictures.append(time.monotonic())
            came.notify_all()

    def wait_for(count):
        """Wait for so many more pictures; when the last of them came."""
        with came:
            wanted = len(pictures) + count
            assert came.wait_for(lambda: len(pictures) >= wanted, 30.0)
            return pictures[-1]

    def watch():
        nonlocal speed
        seen = {"delays": [], "gaps": []}
        rospy.Subscriber("cameras/front/image_raw/compressed", CompressedImage, take)
        for _ in range(TRIALS):
            # The first of these may still have shown motion.
            wait_for(3)
            time.sleep(0.2)
            began, speed = time.monotonic(), 0.3
            first = wait_for(1)
            seen["delays"].append(first - began)
            following = wait_for(1)
            seen["gaps"].append(wait_for(1) - following)
            speed = 0.0
        print(json.dumps(seen), flush=True)
        rospy.signal_shutdown("seen")

    for job in (simulate, watch):
        threading.Thread(target=job, daemon=True).start()
    with until_shutdown():
        node.run()


if __name__ == "__main__":
    drill()
