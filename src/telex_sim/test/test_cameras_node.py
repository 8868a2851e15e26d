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

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster, end_tree

NODE = Path(__file__).parents[1] / "nodes" / "cameras"
SIZE = (160, 120)
NO_EGL = {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent"}
POSES_RATE = 60.0  # 1/s
POSES_PERIOD = 16_666_667  # sim time between poses (ns)
RED, GREEN, BLUE = (0.9, 0.05, 0.05), (0.05, 0.8, 0.05), (0.05, 0.1, 0.9)
SMALL = (80, 60)
CAMERA = {
    "width": SIZE[0],
    "height": SIZE[1],
    "horizontal_fov": 1.2,
    "preview": {"width": SMALL[0], "rate": 20.0},
}
PARAMS = {
    "cameras": {
        "front": {
            **CAMERA,
            "frame": "front_camera_optical_frame",
            "rate": 20.0,
            "zoom_max": 4.0,
            "distortion": [-0.1, 0.02, 0.0, 0.0, 0.0],
            "depth": True,
        },
        "rear": {**CAMERA, "frame": "rear_camera_optical_frame", "rate": 20.0},
        "ghost": {**CAMERA, "frame": "no_such_link"},
    },
    "lamps": {
        "head": {"frame": "lamp_link", "intensity": 2.0, "level": 0.5},
        "lost": {"frame": "no_lamp_link"},
    },
    "overview": {
        "width": 64,
        "height": 48,
        "horizontal_fov": 1.0,
        "rate": 20.0,
        "smoothing": 0.0,
        "start": {
            "mode": "fixed",
            "azimuth": 0,
            "elevation": 0,
            "distance": 6,
            "center": [0, 0, 0],
        },
    },
    "model": "telex",
}
# Half the width of what the cameras see in the plane z = 1, and the front camera's focal length.
EDGE = np.tan(0.6)
FOCAL = SIZE[0] / 2 / (EDGE * (1.0 - 0.1 * EDGE**2 + 0.02 * EDGE**4))


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
    return run(master, tmp_path_factory.mktemp("cameras") / "log", PARAMS, "drill")


def run(master, log, params, drill):
    set_params(master, params)
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
                [sys.executable, __file__, drill],
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
    assert 10 <= len(pictures) <= 26
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
    assert info["k"][0] == pytest.approx(FOCAL)
    assert info["d"] == [-0.1, 0.02, 0.0, 0.0, 0.0]


def test_the_other_camera_looks_the_other_way(seen):
    assert seen["rear"]
    assert all(looks(picture, GREEN) for picture in seen["rear"])
    assert all(picture["frame"] == "rear_camera_optical_frame" for picture in seen["rear"])


def test_raw_pictures_while_somebody_listens(seen):
    assert seen["raw"]
    assert all(looks(picture, RED) for picture in seen["raw"])


def test_previews_show_the_same_in_fewer_pixels(seen):
    for name, color in (("preview", GREEN), ("reduced", RED)):
        assert seen[name]
        assert all(looks(picture, color) for picture in seen[name])
        assert all(picture["size"] == list(SMALL) for picture in seen[name])
    assert {picture["frame"] for picture in seen["preview"]} == {"rear_camera_optical_frame"}
    assert all(stamp % POSES_PERIOD == 0 for stamp in stamps(seen["preview"]))


def test_what_this_robot_lacks_is_named_once_and_not_advertised(seen):
    assert seen["topics_before"] == []
    assert "/telex/cameras/front/image_raw/compressed" in seen["topics"]
    assert "/telex/cameras/rear/camera_info" in seen["topics"]
    assert not [topic for topic in seen["topics"] if "ghost" in topic]
    # At first, and when the link has gone again.
    assert seen["log"].count("this robot has no telex/no_lamp_link, telex/no_such_link") == 2


def test_zoom_is_taken_within_its_range_and_told_by_camera_info(seen):
    factors = [1.0, 2.5, 2.5, 4.0, 1.0]
    assert seen["zoom"] == pytest.approx([factor * FOCAL for factor in factors])
    assert "camera front: zoom is nan; 1 to 4 is possible" in seen["log"]
    assert "camera front: zoom is 99; 1 to 4 is possible, 4 is taken" in seen["log"]
    assert "camera front: zoom is -1; 1 to 4 is possible, 1 is taken" in seen["log"]


def test_a_camera_comes_and_goes_with_its_link(seen):
    assert seen["ghost_comes"]
    assert seen["ghost_goes"]


def test_depth_is_in_metres_and_offered_where_it_is_wanted(seen):
    assert all(depth["encoding"] == "32FC1" for depth in seen["depth"])
    assert all(depth["frame"] == "front_camera_optical_frame" for depth in seen["depth"])
    assert [depth["middle"] for depth in seen["depth"]] == pytest.approx([2.75] * 3, abs=0.01)
    # Beside the box there is nothing.
    assert all(depth["corner"] == np.inf for depth in seen["depth"])
    assert "/telex/cameras/front/depth" in seen["topics"]
    assert "/telex/cameras/rear/depth" not in seen["topics"]


def test_parameters_are_changed_while_it_runs(seen):
    changed = seen["changed"]
    assert changed["success"]
    assert "width: 80" in changed["parameters"]
    assert changed["on_server"] == 80
    assert changed["info"]["size"] == [80, 60]
    assert changed["info"]["k"][0] == pytest.approx(40.0 / EDGE)
    assert changed["picture"]["size"] == [80, 60]
    assert 3 <= changed["pictures_in_a_second"] <= 7
    # One EV less is half the light.
    assert changed["picture"]["brightness"] < 0.85 * changed["brightness_before"]
    assert changed["topics"] == ["/telex/cameras/rear/depth"]
    assert looks(changed["renderer"], GREEN)


def test_parameters_that_make_no_sense_are_refused_with_the_reason(seen):
    assert seen["refused"] == [
        "rate is -1.0; it must be above 0 and at most 240",
        "noise is nan; it must be finite",
        "frame cannot be changed while the node runs",
        "camera is 'side'; front, ghost, overview, rear are possible, or nothing for what all have"
        " in common",
        "quality is 'ultra'; auto, software, gpu are possible",
        "seed cannot be changed while the node runs",
    ]


def test_the_overview_goes_where_it_is_sent(seen):
    before, after, refused = seen["overview"]
    # From far ahead it sees the front box, from behind the other one.
    assert looks(before, RED)
    assert looks(after, GREEN)
    assert looks(refused, GREEN)
    assert after["frame"] == "overview_camera_optical_frame"
    assert "camera overview: distance is nan; it must be" in seen["log"]
    assert "camera overview: mode is 'fly'; follow, orbit, fixed are possible" in seen["log"]


def test_nothing_is_drawn_for_nobody_and_everybody_is_served(master):
    set_params(master, PARAMS)
    drill = subprocess.run(
        [sys.executable, __file__, "count"],
        env=master,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert drill.returncode == 0, drill.stdout[-2000:] + drill.stderr[-4000:]
    counted = json.loads(drill.stdout.splitlines()[-1])
    assert counted["info"] == {"ahead": 0, "back": 0}
    assert counted["front"]["ahead"] > 3
    assert counted["front"]["back"] == 0
    assert counted["rear"]["back"] > 3
    assert counted["rear"]["ahead"] == 0
    assert counted["sizes_alone"] == [SMALL[0]]
    assert counted["sizes_beside"] == [SIZE[0]]
    # At their rate of 20 in a second, none is drawn for the previews alone.
    assert counted["beside_preview"] > 1
    assert counted["beside"] <= 0.4 * 20.0 + 3
    assert counted["nobody"] == {"ahead": 0, "back": 0}
    # Whoever comes when all is late already is served as well, and who goes no more.
    assert counted["overloaded"]["back"] > 0
    assert counted["overloaded"]["ahead"] == 0


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
        ({**PARAMS, "renderer": "tiny"}, {}, "renderer is 'tiny'; auto, opengl are possible"),
        (PARAMS, NO_EGL, "apt-get install libegl1 libgl1 libgl1-mesa-dri"),
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
        self.ghost = False
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

        self._scenes.publish(
            SceneDescription(
                revision=self.revision,
                frames=self._frames(),
                visuals=[box(3.0, color), box(-3.0, GREEN)],
                ambient=ambient,
            )
        )

    def _frames(self):
        names = ["front_camera_optical_frame", "rear_camera_optical_frame", "lamp_link"]
        names += ["base_link"] + ["no_such_link"] * self.ghost
        return ["world", *(f"telex/{name}" for name in names)]

    def _run(self):
        from telex_msgs.msg import ScenePoses

        while not self._rospy.is_shutdown():
            if not self.paused:
                self.ticks += 1
            poses = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            # Optical frames that look along x, and against it.
            poses += [0.0, 0.0, 0.0, -0.5, 0.5, -0.5, 0.5]
            poses += [0.0, 0.0, 0.0, 0.5, 0.5, -0.5, -0.5]
            poses += [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] * (2 + self.ghost)
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
        return self._noted[-1]

    def newest(self, seconds):
        """The last message of some time, on a busy machine the first after it."""
        noted = self.note_for(seconds)
        return noted[-1] if noted else self.wait()

    def leave(self):
        self._subscriber.unregister()

    def _note(self, message):
        header = message.header
        note = {"stamp": header.stamp.to_nsec(), "frame": header.frame_id}
        if hasattr(message, "K"):
            note.update(size=[message.width, message.height], k=list(message.K), d=list(message.D))
        elif getattr(message, "encoding", "") == "32FC1":
            depth = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
            middle, corner = depth[message.height // 2, message.width // 2], depth[0, 0]
            note.update(encoding=message.encoding, middle=float(middle), corner=float(corner))
        else:
            pixels = self._pixels(message)
            rows, columns = pixels.shape[0] // 2, pixels.shape[1] // 2
            middle = pixels[rows - 2 : rows + 3, columns - 2 : columns + 3]
            note["middle"] = middle.reshape(-1, 3).mean(axis=0).tolist()
            note["brightness"] = float(middle.mean())
            note["size"] = [pixels.shape[1], pixels.shape[0]]
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

    miss_nothing()
    rospy.init_node("drill")
    seen = {"topics_before": camera_topics()}
    simulator = Simulator()
    simulator.describe(RED)
    time.sleep(0.5)
    seen["followed_before"] = simulator.followed

    front = Viewer("cameras/front/image_raw/compressed", CompressedImage)
    infos = Viewer("cameras/front/camera_info", CameraInfo)
    front.wait()
    infos.wait()
    seen["followed_while_looking"] = simulator.followed
    with_infos = []
    reader = threading.Thread(target=lambda: with_infos.extend(infos.note_for(1.2)))
    reader.start()
    pictures = front.note_for(1.2)
    reader.join()
    seen["running"] = {"pictures": pictures, "infos": with_infos}

    for name, topic, kind in (
        ("rear", "cameras/rear/image_raw/compressed", CompressedImage),
        ("raw", "cameras/front/image_raw", Image),
        ("preview", "cameras/rear/preview/compressed", CompressedImage),
        ("reduced", "cameras/front/preview/compressed", CompressedImage),
        ("depth", "cameras/front/depth", Image),
    ):
        viewer = Viewer(topic, kind)
        seen[name] = viewer.note_for(0.6)
        viewer.leave()
    seen["depth"] = seen["depth"][-3:]
    seen["topics"] = camera_topics()

    simulator.paused = True
    front.note_for(0.3)
    seen["paused"] = front.note_for(1.0)
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
            time.sleep(0.2)
            seen_values.append(look())
        return seen_values

    seen["zoom"] = command(
        "cameras/front/zoom",
        (2.5, float("nan"), 99.0, -1.0),
        lambda: infos.newest(0.2)["k"][0],
    )
    simulator.revision = 2
    simulator.describe(RED, ambient=0.0)
    front.note_for(0.3)
    seen["lamp"] = command(
        "lamps/head/command",
        (0.0, float("nan"), 1.0),
        lambda: max(front.newest(0.3)["middle"]),
    )
    simulator.ghost = True
    simulator.revision += 1
    simulator.describe(RED)
    seen["ghost_comes"] = eventually(
        lambda: "/telex/cameras/ghost/image_raw/compressed" in camera_topics()
    )
    simulator.ghost = False
    simulator.revision += 1
    simulator.describe(RED)
    seen["ghost_goes"] = eventually(
        lambda: not [topic for topic in camera_topics() if "ghost" in topic]
    )
    front.leave()
    infos.leave()
    seen.update(configure())
    seen["overview"] = fly()
    print(json.dumps(seen))


def camera_topics():
    import rospy

    return [topic for topic, _ in rospy.get_published_topics() if "/telex/cameras/" in topic]


def eventually(condition):
    deadline = time.monotonic() + 10.0
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)
    return condition()


def configure():
    """Change parameters of the rear camera; some that make no sense first."""
    import rospy
    from sensor_msgs.msg import CameraInfo, CompressedImage
    from telex_msgs.srv import ConfigureCamera

    service = rospy.ServiceProxy("cameras/configure", ConfigureCamera)
    service.wait_for_service(10.0)
    rear = Viewer("cameras/rear/image_raw/compressed", CompressedImage)
    before = rear.wait()
    refused = []
    for camera, parameters in (
        ("rear", "{rate: -1, width: 32}"),
        ("rear", "{noise: .nan}"),
        ("rear", "{frame: lamp_link}"),
        ("side", "{rate: 5}"),
        ("", "{quality: ultra}"),
        ("", "{seed: 5}"),
    ):
        answer = service(camera, parameters)
        assert not answer.success
        refused.append(answer.message)
    topics = set(camera_topics())
    answer = service("rear", "{width: 80, height: 60, rate: 5, depth: true, exposure: {ev: -1}}")
    info = Viewer("cameras/rear/camera_info", CameraInfo)
    rear.note_for(0.5)
    pictures = rear.note_for(1.0)
    changed = {
        "success": answer.success,
        "parameters": answer.parameters,
        "on_server": rospy.get_param("cameras/cameras/rear/width"),
        "brightness_before": before["brightness"],
        "pictures_in_a_second": len(pictures),
        "picture": pictures[-1] if pictures else rear.wait(),
        "info": info.wait(),
        "topics": sorted(set(camera_topics()) - topics),
    }
    # Another renderer takes the place of the first.
    assert service("", "{shadow_radius: 3}").success
    rear.note_for(0.3)
    changed["renderer"] = rear.wait()
    rear.leave()
    info.leave()
    return {"changed": changed, "refused": refused}


def fly():
    """Send the overview camera to the other side, and then nowhere."""
    import rospy
    from sensor_msgs.msg import CompressedImage
    from telex_msgs.msg import OverviewView

    viewer = Viewer("cameras/overview/image_raw/compressed", CompressedImage)
    sender = rospy.Publisher("cameras/overview/view", OverviewView, queue_size=1)
    seen = [viewer.wait()]
    while not sender.get_num_connections():
        time.sleep(0.01)
    for view in (
        OverviewView(mode="fixed", azimuth=np.pi, distance=6.0),
        OverviewView(mode="fixed", distance=float("nan")),
        OverviewView(mode="fly", distance=6.0),
    ):
        sender.publish(view)
        seen.append(viewer.newest(0.5))
    viewer.leave()
    return seen[:2] + seen[3:]


class CountingRenderer:
    """Counts pictures by the direction in which the camera looks."""

    repeats = False

    def __init__(self):
        self.counts = {"ahead": 0, "back": 0}
        self.sizes = set()
        self.seconds = 0.0

    def load_scene(self, scene):
        return []

    def set_lamp_levels(self, levels):
        pass

    def place(self, frames_in_world, focus, recast=True):
        pass

    def render(self, camera, optical_in_world, exposure=1.0, coarse=False):
        time.sleep(self.seconds)
        self.counts["ahead" if optical_in_world[0, 2] > 0.0 else "back"] += 1
        self.sizes.add(camera.width)
        return np.zeros((camera.height, camera.width, 4), np.uint8)

    def depth(self, camera):
        return np.zeros((camera.height, camera.width), np.float32)

    def release(self):
        pass


def count():
    """Count what a node draws for whom, in this process."""
    import rospy
    from sensor_msgs.msg import CameraInfo, CompressedImage

    from telex_control.common.params import read_config
    from telex_control.ros.node_start import until_shutdown
    from telex_sim.cameras.cameras_config import CamerasConfig
    from telex_sim.cameras.ros.cameras_node import CamerasNode

    miss_nothing()
    rospy.init_node("count")
    renderer = CountingRenderer()
    node = CamerasNode(read_config(CamerasConfig, PARAMS, "count"), lambda config: renderer)
    Simulator().describe(RED)
    counted = {}

    def watch():
        for name, topic, kind in (
            ("info", "front/camera_info", CameraInfo),
            ("front", "front/image_raw/compressed", CompressedImage),
            ("rear", "rear/image_raw/compressed", CompressedImage),
        ):
            viewer = Viewer(f"cameras/{topic}", kind)
            viewer.wait()
            before = dict(renderer.counts)
            viewer.note_for(0.5)
            counted[name] = {way: renderer.counts[way] - before[way] for way in before}
            viewer.leave()
        # Whoever looks at the small pictures alone has nothing larger drawn; beside the pictures of
        # full size, they cost nothing.
        preview = Viewer("cameras/rear/preview/compressed", CompressedImage)
        preview.wait()
        time.sleep(0.2)
        renderer.sizes.clear()
        preview.note_for(0.3)
        counted["sizes_alone"] = sorted(renderer.sizes)
        full = Viewer("cameras/rear/image_raw/compressed", CompressedImage)
        full.wait()
        time.sleep(0.2)
        renderer.sizes.clear()
        before = renderer.counts["back"]
        counted["beside_preview"] = len(preview.note_for(0.4))
        counted["beside"] = renderer.counts["back"] - before
        counted["sizes_beside"] = sorted(renderer.sizes)
        preview.leave()
        full.leave()
        time.sleep(0.3)
        before = dict(renderer.counts)
        time.sleep(0.5)
        counted["nobody"] = {way: renderer.counts[way] - before[way] for way in before}
        # Far longer than the period of the cameras: one of them is always late.
        renderer.seconds = 0.15
        front = Viewer("cameras/front/image_raw/compressed", CompressedImage)
        front.wait()
        Viewer("cameras/rear/image_raw/compressed", CompressedImage).wait()
        front.leave()
        time.sleep(0.5)
        before = dict(renderer.counts)
        time.sleep(0.5)
        counted["overloaded"] = {way: renderer.counts[way] - before[way] for way in before}
        rospy.signal_shutdown("counted")

    watcher = threading.Thread(target=watch)
    watcher.start()
    with until_shutdown():  # a picture may be under way
        node.run()
    watcher.join()
    print(json.dumps(counted))


if __name__ == "__main__":
    {"drill": drill, "count": count}[sys.argv[1]]()
