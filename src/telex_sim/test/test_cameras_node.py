"""The ``cameras`` node on a ROS master of its own, with a fake simulator.

One run of this file as a program plays the simulator and the viewer, and prints what it saw as
JSON; the tests judge that. It is a process of its own because rospy can be initialised only once
per process.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from telex_control.private_master import PrivateMaster, end_tree

NODE = Path(__file__).parents[1] / "nodes" / "cameras"
SIZE = (160, 120)
POSES_RATE = 60.0  # 1/s
POSES_PERIOD = 16_666_667  # sim time between poses (ns)
RED, GREEN, BLUE = (0.9, 0.05, 0.05), (0.05, 0.8, 0.05), (0.05, 0.1, 0.9)
CAMERA = {"width": SIZE[0], "height": SIZE[1], "horizontal_fov": 1.2}
PARAMS = {
    "cameras": {
        "front": {
            **CAMERA,
            "frame": "front_camera_optical_frame",
            "rate": 20.0,
            "zoom_max": 4.0,
        },
        "rear": {**CAMERA, "frame": "rear_camera_optical_frame", "rate": 20.0},
        "ghost": {**CAMERA, "frame": "no_such_link"},
    },
    "lamps": {
        "head": {"frame": "lamp_link", "intensity": 2.0, "level": 0.5},
        "lost": {"frame": "no_lamp_link"},
    },
    "model": "telex",
}


# ---------------------------------------------------------------- the tests


@pytest.fixture(scope="module")
def master():
    """Environment of a roscore on a free port."""
    with PrivateMaster() as master:
        yield master.environment(ROS_NAMESPACE="/telex", PYTHONUNBUFFERED="1")


def set_params(environment, params):
    import rosgraph

    master = rosgraph.Master("/test", master_uri=environment["ROS_MASTER_URI"])
    master.setParam("/use_sim_time", True)
    master.setParam("/telex/cameras", params)


@pytest.fixture(scope="module")
def seen(master, tmp_path_factory):
    """What the drill saw of a node, and how the node ended."""
    set_params(master, PARAMS)
    log = tmp_path_factory.mktemp("cameras") / "log"
    with log.open("w") as output:
        node = subprocess.Popen(
            [sys.executable, str(NODE), "__name:=cameras"],
            env=master,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            drill = subprocess.run(
                [sys.executable, __file__],
                env=master,
                capture_output=True,
                text=True,
                timeout=120.0,
                check=False,
            )
            alive = node.poll() is None
        finally:
            end_tree(node)
    assert drill.returncode == 0, drill.stdout[-4000:] + drill.stderr[-4000:] + log.read_text()
    result = json.loads(drill.stdout.splitlines()[-1])
    return {**result, "alive": alive, "exit": node.returncode, "log": log.read_text()}


pytestmark = pytest.mark.ros


def looks(picture, color):
    """Whether the middle of a picture has the hue of a colour."""
    middle = np.array(picture["middle"], dtype=float)
    return middle.argmax() == np.argmax(color) and middle.max() > 1.5 * np.sort(middle)[1]


def stamps(pictures):
    return [picture["stamp"] for picture in pictures]


def test_poses_are_not_followed_before_somebody_looks(seen):
    assert not seen["followed_before"]
    assert seen["followed_while_looking"]


def test_pictures_at_the_rate_of_the_camera(seen):
    pictures = seen["running"]["pictures"]
    assert 16 <= len(pictures) <= 42
    assert all(looks(picture, RED) for picture in pictures)


def test_stamps_are_those_of_the_poses_and_none_comes_twice(seen):
    found = stamps(seen["running"]["pictures"])
    assert found == sorted(set(found))
    assert all(stamp % POSES_PERIOD == 0 for stamp in found)


def test_every_picture_has_its_camera_info(seen):
    infos = {info["stamp"]: info for info in seen["running"]["infos"]}
    found = stamps(seen["running"]["pictures"])
    # The ends of the two recordings may differ.
    assert len(set(found) & set(infos)) >= len(found) - 2
    info = next(iter(infos.values()))
    assert info["frame"] == "front_camera_optical_frame"
    assert info["size"] == list(SIZE)
    assert info["k"][2] == pytest.approx((SIZE[0] - 1) / 2)
    assert info["k"][0] == pytest.approx(SIZE[0] / 2 / np.tan(0.6))


def test_the_other_camera_looks_the_other_way(seen):
    assert seen["rear"]
    assert all(looks(picture, GREEN) for picture in seen["rear"])
    assert all(picture["frame"] == "rear_camera_optical_frame" for picture in seen["rear"])


def test_raw_pictures_while_somebody_listens(seen):
    assert seen["raw"]
    assert all(looks(picture, RED) for picture in seen["raw"])


def test_what_this_robot_lacks_is_named_once_and_keeps_still(seen):
    assert seen["ghost"] == []
    assert seen["log"].count("this robot has no telex/no_lamp_link, telex/no_such_link") == 1


def test_zoom_is_taken_within_its_range_and_told_by_camera_info(seen):
    focal = SIZE[0] / 2 / np.tan(0.6)
    assert seen["zoom"] == pytest.approx([focal, 2.5 * focal, 2.5 * focal, 4.0 * focal, focal])
    assert "camera front: zoom is nan; 1 to 4 is possible" in seen["log"]
    assert "camera front: zoom is 99; 1 to 4 is possible, 4 is taken" in seen["log"]
    assert "camera front: zoom is -1; 1 to 4 is possible, 1 is taken" in seen["log"]


def test_lamps_are_switched(seen):
    starting, off, still_off, full = seen["lamp"]
    assert off == still_off == 0.0
    assert 10.0 < starting < full
    assert "lamp head: level is nan; 0 to 1 is possible, it stays at 0" in seen["log"]


def test_while_paused_a_picture_now_and_then(seen):
    pictures = seen["paused"]
    assert len(set(stamps(pictures))) == 1
    assert 2 <= len(pictures) <= 12


def test_poses_with_nan_move_nothing(seen):
    assert seen["nan"] == []
    assert "poses are left out" in seen["log"]
    assert seen["after_nan"]


def test_poses_wait_for_their_scene(seen):
    assert seen["scene_missing"] == []
    assert seen["scene_come"]
    assert all(looks(picture, BLUE) for picture in seen["scene_come"])


def test_a_simulator_that_starts_again_is_followed(seen):
    assert seen["restarted"]
    assert all(looks(picture, GREEN) for picture in seen["restarted"])
    assert max(stamps(seen["restarted"])) < min(stamps(seen["scene_come"]))


def test_the_node_survives_all_that_and_ends_in_order(seen):
    assert seen["alive"]
    assert seen["exit"] == 0
    assert "Traceback" not in seen["log"]


@pytest.mark.parametrize(
    ("params", "environment", "complaint"),
    [
        ({**PARAMS, "cameras": {}}, {}, "cameras is empty"),
        ({**PARAMS, "colour": "red"}, {}, "colour is unknown"),
        (
            PARAMS,
            {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent"},
            "apt-get install libegl1 libgl1 libgl1-mesa-dri",
        ),
    ],
)
def test_what_cannot_work_ends_with_one_line(master, params, environment, complaint):
    set_params(master, params)
    node = subprocess.run(
        [sys.executable, str(NODE), "__name:=cameras"],
        env={**master, **environment},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert node.returncode == 1
    assert complaint in node.stderr
    assert "[FATAL]" in node.stderr
    assert "Traceback" not in node.stderr


# ---------------------------------------------------------------- the drill


class Simulator:
    """A box before and one behind the robot; poses come from a thread, as told."""

    def __init__(self):
        import rospy
        from telex_msgs.msg import SceneDescription, ScenePoses

        self._rospy = rospy
        self._scenes = rospy.Publisher("sim/scene", SceneDescription, queue_size=1, latch=True)
        self._poses = rospy.Publisher("sim/poses", ScenePoses, queue_size=1, tcp_nodelay=True)
        self.revision = 1
        self.ticks = 0
        self.paused = False
        self.broken = False
        threading.Thread(target=self._run, daemon=True).start()

    @property
    def followed(self):
        return self._poses.get_num_connections() > 0

    def describe(self, color, ambient=1.0):
        from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
        from std_msgs.msg import ColorRGBA
        from telex_msgs.msg import SceneDescription, SceneVisual

        def box(x, color):
            return SceneVisual(
                frame=0,
                shape=SceneVisual.BOX,
                size=Vector3(0.5, 2.0, 2.0),
                pose=Pose(Point(x, 0.0, 0.0), Quaternion(w=1.0)),
                color=ColorRGBA(*color, 1.0),
            )

        frames = ["world", "telex/front_camera_optical_frame", "telex/rear_camera_optical_frame"]
        self._scenes.publish(
            SceneDescription(
                revision=self.revision,
                frames=[*frames, "telex/lamp_link"],
                visuals=[box(3.0, color), box(-3.0, GREEN)],
                ambient=ambient,
            )
        )

    def _run(self):
        from telex_msgs.msg import ScenePoses

        while not self._rospy.is_shutdown():
            if not self.paused:
                self.ticks += 1
            poses = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            # Optical frames that look along x, and against it.
            poses += [0.0, 0.0, 0.0, -0.5, 0.5, -0.5, 0.5]
            poses += [0.0, 0.0, 0.0, 0.5, 0.5, -0.5, -0.5]
            poses += [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            if self.broken:
                poses[7] = float("nan")
            message = ScenePoses(revision=self.revision, poses=poses)
            nanoseconds = self.ticks * POSES_PERIOD
            message.header.stamp = self._rospy.Time(nanoseconds // 10**9, nanoseconds % 10**9)
            self._poses.publish(message)
            time.sleep(1.0 / POSES_RATE)


class Viewer:
    """Notes what comes on a topic."""

    def __init__(self, topic, kind):
        import rospy

        self._noted = []
        self._subscriber = rospy.Subscriber(topic, kind, self._note, queue_size=10)

    def note_for(self, seconds):
        self._noted = []
        time.sleep(seconds)
        return list(self._noted)

    def wait(self):
        """Wait for the first message."""
        deadline = time.monotonic() + 20.0
        while not self._noted and time.monotonic() < deadline:
            time.sleep(0.01)

    def leave(self):
        self._subscriber.unregister()

    def _note(self, message):
        header = message.header
        note = {"stamp": header.stamp.to_nsec(), "frame": header.frame_id}
        if hasattr(message, "K"):
            note.update(size=[message.width, message.height], k=list(message.K))
        else:
            pixels = self._pixels(message)
            middle = pixels[
                SIZE[1] // 2 - 2 : SIZE[1] // 2 + 3, SIZE[0] // 2 - 2 : SIZE[0] // 2 + 3
            ]
            note["middle"] = middle.reshape(-1, 3).mean(axis=0).tolist()
        self._noted.append(note)

    @staticmethod
    def _pixels(message):
        import cv2

        if hasattr(message, "encoding"):
            assert message.encoding == "rgb8"
            return np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, 3)
        bgr = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        return bgr[..., ::-1]


def drill():
    """Play the simulator and the viewer, and print what was seen."""
    import rospy
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image
    from std_msgs.msg import Float64

    rospy.init_node("drill")
    simulator = Simulator()
    simulator.describe(RED)
    seen = {}
    time.sleep(1.0)
    seen["followed_before"] = simulator.followed

    front = Viewer("cameras/front/image_raw/compressed", CompressedImage)
    infos = Viewer("cameras/front/camera_info", CameraInfo)
    front.wait()
    infos.wait()
    seen["followed_while_looking"] = simulator.followed
    with_infos = []
    reader = threading.Thread(target=lambda: with_infos.extend(infos.note_for(2.0)))
    reader.start()
    pictures = front.note_for(2.0)
    reader.join()
    seen["running"] = {"pictures": pictures, "infos": with_infos}

    for name, topic, kind in (
        ("rear", "cameras/rear/image_raw/compressed", CompressedImage),
        ("raw", "cameras/front/image_raw", Image),
        ("ghost", "cameras/ghost/image_raw/compressed", CompressedImage),
    ):
        viewer = Viewer(topic, kind)
        seen[name] = viewer.note_for(0.7)
        viewer.leave()

    simulator.paused = True
    front.note_for(0.3)
    seen["paused"] = front.note_for(1.5)
    simulator.paused = False

    simulator.broken = True
    front.note_for(0.3)
    seen["nan"] = front.note_for(0.5)
    simulator.broken = False
    seen["after_nan"] = front.note_for(0.5)

    simulator.revision = 2
    front.note_for(0.3)
    seen["scene_missing"] = front.note_for(0.5)
    simulator.describe(BLUE)
    front.note_for(0.3)
    seen["scene_come"] = front.note_for(0.5)

    simulator.revision, simulator.ticks = 1, 0
    simulator.describe(GREEN)
    front.note_for(0.3)
    seen["restarted"] = front.note_for(0.5)

    def command(topic, values, look):
        """Look once before and once after each of the values."""
        publisher = rospy.Publisher(topic, Float64, queue_size=1)
        seen_values = [look()]
        while not publisher.get_num_connections():
            time.sleep(0.01)
        for value in values:
            publisher.publish(value)
            time.sleep(0.3)
            seen_values.append(look())
        return seen_values

    seen["zoom"] = command(
        "cameras/front/zoom",
        (2.5, float("nan"), 99.0, -1.0),
        lambda: infos.note_for(0.3)[-1]["k"][0],
    )
    simulator.revision = 2
    simulator.describe(RED, ambient=0.0)
    front.note_for(0.3)
    seen["lamp"] = command(
        "lamps/head/command",
        (0.0, float("nan"), 1.0),
        lambda: max(front.note_for(0.3)[-1]["middle"]),
    )
    print(json.dumps(seen))


if __name__ == "__main__":
    drill()
