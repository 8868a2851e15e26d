"""The ``cameras`` node on a ROS master of its own, with a fake simulator."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from own_ros import NodeProcess, Topics, wait_until_connected
from waiting import wait_until

pytestmark = pytest.mark.ros

HERE = Path(__file__).parents[1]
NODE = HERE.parent / "nodes" / "cameras"
NAMESPACE = "/telex"
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
REAR = "{width: 160, height: 120, rate: 20, depth: false, exposure: {ev: 0}}"
# Half the width of what the cameras see in the plane z = 1, and the front camera's focal length.
EDGE = np.tan(0.6)
FOCAL = SIZE[0] / 2 / (EDGE * (1.0 - 0.1 * EDGE**2 + 0.02 * EDGE**4))


class Simulator:
    """A box before and one behind the robot; a thread tells poses (context manager)."""

    def __init__(self, topics):
        import rospy
        from telex_msgs.msg import SceneDescription, ScenePoses

        self._time = rospy.Time
        self._scenes = topics.publisher("sim/scene", SceneDescription, queue_size=1, latch=True)
        self._poses = topics.publisher("sim/poses", ScenePoses, queue_size=1, tcp_nodelay=True)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._described = None
        self.revision = 0
        self.ticks = 0
        self.paused = False
        self.broken = False
        self.ghost = False
        self.times_lacking = 1  # how often the robot has come to lack the ghost's link

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *exception):
        self._ended.set()
        self._thread.join()

    @property
    def followed(self):
        return self._poses.get_num_connections() > 0

    def reset(self):
        """Go on with the red box ahead, in daylight."""
        self.paused = self.broken = False
        if self.ghost:
            self.let_ghost(False)
        if self._described != (self.revision, RED, 1.0):
            self.revision += 1
            self.describe(RED)

    def let_ghost(self, there):
        """Let the robot have the ghost's link, or not, in a new scene."""
        self.times_lacking += self.ghost and not there
        self.ghost = there
        self.revision += 1
        self.describe(RED)

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

        self._described = self.revision, color, ambient
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

        while not self._ended.wait(1.0 / POSES_RATE):
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
            message.header.stamp = self._time(nanoseconds // 10**9, nanoseconds % 10**9)
            self._poses.publish(message)


class Note:
    """What a test asks of a picture or of a camera's description."""

    def __init__(self, message):
        self.message = message
        self.stamp = message.header.stamp.to_nsec()
        self.frame = message.header.frame_id

    @property
    def pixels(self):
        """RGB values, or depths (m)."""
        import cv2

        message = self.message
        if not hasattr(message, "encoding"):
            bgr = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
            return bgr[..., ::-1]
        if message.encoding == "32FC1":
            return np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
        assert message.encoding == "rgb8"
        return np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, 3)

    @property
    def size(self):
        if hasattr(self.message, "K"):
            return self.message.width, self.message.height
        return self.pixels.shape[1], self.pixels.shape[0]

    @property
    def focal_length(self):
        return self.message.K[0]

    @property
    def middle(self):
        """Mean colour of the middle, shape (3,)."""
        pixels = self.pixels
        rows, columns = pixels.shape[0] // 2, pixels.shape[1] // 2
        middle = pixels[rows - 2 : rows + 3, columns - 2 : columns + 3]
        return middle.reshape(-1, 3).mean(axis=0)

    def looks(self, color):
        """Whether the middle of a picture has the hue of a colour."""
        middle = self.middle
        return middle.argmax() == np.argmax(color) and middle.max() > 1.5 * np.sort(middle)[1]


class Viewer:
    """Notes what comes on a topic."""

    def __init__(self, topics, topic, kind):
        self.noted = []
        topics.subscriber(
            f"cameras/{topic}", kind, lambda m: self.noted.append(Note(m)), queue_size=10
        )

    def note_for(self, seconds):
        """What comes within some time."""
        self.noted = []
        time.sleep(seconds)
        return list(self.noted)

    def wait(self):
        """The last message; the first, if none has come yet."""
        return wait_until(lambda: self.noted[-1:], "a message of a camera", 20.0)[0]

    def newest(self, seconds):
        """The last message of some time, on a busy machine the first after it."""
        noted = self.note_for(seconds)
        return noted[-1] if noted else self.wait()


class Stage:
    """A simulator and a node, and who looks at what."""

    def __init__(self, topics, simulator, log):
        self.simulator, self.log = simulator, log
        self._all_along, self._commands = topics, {}
        self.topics_before = camera_topics()
        self.topics = Topics(NAMESPACE)  # of one test
        self._looking = Topics(NAMESPACE)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.leave()
        self.topics.__exit__(*exception)

    def leave(self):
        """Let nobody look any more."""
        self._looking.__exit__(None, None, None)

    @property
    def said(self):
        """The node's log."""
        return self.log.read_text(errors="replace")

    def pictures(self, camera, kind="image_raw/compressed"):
        return Viewer(self._looking, f"{camera}/{kind}", picture_type(kind))

    def infos(self, camera):
        from sensor_msgs.msg import CameraInfo

        return Viewer(self._looking, f"{camera}/camera_info", CameraInfo)

    def commands(self, topic, kind):
        """A publisher that the node hears."""
        # Not anew for each test: a node that has not noticed yet that the last one went would not
        # connect to the next, which has the same address.
        if topic not in self._commands:
            self._commands[topic] = self._all_along.publisher(topic, kind)
        wait_until_connected(self._commands[topic])
        return self._commands[topic]

    def configure(self, camera, parameters):
        import rospy
        from telex_msgs.srv import ConfigureCamera

        service = rospy.ServiceProxy(f"{NAMESPACE}/cameras/configure", ConfigureCamera)
        service.wait_for_service(10.0)
        return service(camera, parameters)


def picture_type(topic):
    from sensor_msgs.msg import CompressedImage, Image

    return CompressedImage if topic.endswith("compressed") else Image


def camera_topics():
    import rospy

    return [topic for topic, _ in rospy.get_published_topics() if "/telex/cameras/" in topic]


def stamps(pictures):
    return [picture.stamp for picture in pictures]


@contextlib.contextmanager
def running(environment, log, *command):
    """Give a stage with a node; afterwards the node must be there still, and end in order."""
    import rospy

    rospy.set_param("/use_sim_time", True)
    rospy.set_param(f"{NAMESPACE}/cameras", PARAMS)
    with Topics(NAMESPACE) as topics, Simulator(topics) as simulator, log.open("w") as output:
        stage = Stage(topics, simulator, log)
        with NodeProcess(
            [sys.executable, *command, "__name:=cameras"],
            dict(environment, ROS_NAMESPACE=NAMESPACE, PYTHONUNBUFFERED="1"),
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        ) as node:
            simulator.reset()
            yield stage
            assert node.process.poll() is None, stage.said
            assert node.end() == 0, stage.said
    assert "Traceback" not in stage.said


@pytest.fixture
def stage(started):
    with started:
        started.simulator.reset()
        yield started


class TestCameras:
    @pytest.fixture(scope="class")
    def started(self, master, tmp_path_factory):
        with running(master, tmp_path_factory.mktemp("cameras") / "log", NODE) as stage:
            yield stage

    @pytest.fixture
    def front(self, stage):
        """Who looks at the front camera and sees the red box of the scene that is there now."""
        viewer = stage.pictures("front")
        wait_until(lambda: viewer.wait().looks(RED), "the red box", 20.0)
        return viewer

    def test_poses_are_not_followed_before_somebody_looks(self, stage):
        # For a while they are, after somebody has looked.
        wait_until(lambda: not stage.simulator.followed, "nobody to follow the poses", 20.0)
        time.sleep(0.5)
        assert not stage.simulator.followed
        stage.pictures("front").wait()
        assert stage.simulator.followed

    def test_pictures_at_the_rate_of_the_camera_with_stamps_of_the_poses_and_infos(
        self, stage, front
    ):
        infos = stage.infos("front")
        infos.wait()
        infos.note_for(0.0)
        pictures = front.note_for(1.2)
        noted = {info.stamp: info for info in infos.noted}
        assert 10 <= len(pictures) <= 26
        assert all(picture.looks(RED) for picture in pictures)
        # None comes twice.
        found = stamps(pictures)
        assert found == sorted(set(found))
        assert all(stamp % POSES_PERIOD == 0 for stamp in found)
        # The ends of the two recordings may differ.
        assert len(set(found) & set(noted)) >= len(found) - 2
        info = next(iter(noted.values()))
        assert info.frame == "front_camera_optical_frame"
        assert info.size == SIZE
        assert info.message.K[2] == pytest.approx((SIZE[0] - 1) / 2)
        assert info.focal_length == pytest.approx(FOCAL)
        assert list(info.message.D) == [-0.1, 0.02, 0.0, 0.0, 0.0]

    def test_the_other_camera_looks_the_other_way(self, stage):
        viewer = stage.pictures("rear")
        viewer.wait()
        seen = viewer.note_for(0.4)
        assert seen
        assert all(picture.looks(GREEN) for picture in seen)
        assert all(picture.frame == "rear_camera_optical_frame" for picture in seen)

    def test_raw_pictures_while_somebody_listens(self, stage):
        viewer = stage.pictures("front", "image_raw")
        viewer.wait()
        seen = viewer.note_for(0.4)
        assert seen
        assert all(picture.looks(RED) for picture in seen)

    @pytest.mark.parametrize(("camera", "color"), [("rear", GREEN), ("front", RED)])
    def test_previews_show_the_same_in_fewer_pixels(self, stage, camera, color):
        viewer = stage.pictures(camera, "preview/compressed")
        viewer.wait()
        seen = viewer.note_for(0.4)
        assert seen
        assert all(picture.looks(color) for picture in seen)
        assert all(picture.size == SMALL for picture in seen)
        assert {picture.frame for picture in seen} == {f"{camera}_camera_optical_frame"}
        assert all(stamp % POSES_PERIOD == 0 for stamp in stamps(seen))

    def test_radiation_shows_in_pictures_and_a_dead_camera_takes_none(self, stage, front):
        from telex_msgs.msg import CameraRadiation

        told = stage.commands("cameras/radiation", CameraRadiation)

        def tell(rate, dose, failed):
            told.publish(
                CameraRadiation(names=["front"], dose_rate=[rate], dose=[dose], failed=[failed])
            )

        def grain():
            # Of the middle of the box, which has one colour.
            return front.newest(0.2).pixels[50:70, 70:90].astype(float).std(axis=(0, 1)).max()

        calm = grain()
        tell(1000.0, 80.0, False)
        wait_until(lambda: grain() > calm + 3.0, "dots in the pictures", 20.0)
        tell(-1.0, 0.0, False)
        wait_until(lambda: "it is not heeded" in stage.said, "a refusal", 20.0)
        tell(0.0, 90.0, True)
        wait_until(lambda: not front.note_for(1.0), "no pictures any more", 20.0)
        tell(0.0, 0.0, False)
        wait_until(lambda: front.note_for(0.5), "pictures", 20.0)
        wait_until(lambda: grain() < calm + 3.0, "clear pictures", 20.0)

    def test_malfunctions_show_in_pictures(self, stage, front):
        from telex_msgs.msg import ActiveMalfunction, Malfunctions

        told = stage.commands("sim/malfunctions", Malfunctions)

        def tell(kind="", value=0.0, unpowered=(), group="camera", what="front"):
            active = [ActiveMalfunction(what=what, group=group, kind=kind, value=value)]
            told.publish(Malfunctions(active=active * bool(kind), unpowered=list(unpowered)))

        tell("dark", 1.0)
        wait_until(lambda: front.newest(0.2).middle.max() < 3.0, "dark pictures", 20.0)
        tell("dark", float("nan"))
        wait_until(lambda: front.newest(0.2).looks(RED), "what is no number not heeded", 20.0)
        assert "sim/malfunctions: front: value is nan" in stage.said

        tell("frozen")
        # Whatever was on its way is through.
        wait_until(lambda: len({bytes(n.message.data) for n in front.note_for(0.5)}) == 1, "frozen")
        stage.simulator.revision += 1
        stage.simulator.describe(BLUE)
        small = stage.pictures("front", "preview/compressed")
        frozen = front.note_for(0.5)
        assert all(picture.looks(RED) for picture in frozen)
        assert len(set(stamps(frozen))) > 1, "the stamps go on"
        assert small.newest(0.3).looks(RED)
        tell()
        wait_until(lambda: front.newest(0.2).looks(BLUE), "live pictures", 20.0)

        stage.simulator.describe(BLUE, ambient=0.0)
        wait_until(lambda: front.newest(0.2).looks(BLUE), "lit by the lamp", 20.0)
        tell("dead", what="head", group="lamp")
        wait_until(lambda: front.newest(0.2).middle.max() == 0.0, "the dark", 20.0)
        tell(unpowered=["drives", "lamps", "cameras"])
        wait_until(lambda: not front.note_for(1.0), "no pictures any more", 20.0)
        tell()
        wait_until(lambda: front.note_for(0.5), "pictures", 20.0)

    def test_topics_of_cameras_that_the_robot_has(self, stage):
        assert stage.topics_before == []
        wait_until(lambda: "/telex/cameras/front/depth" in camera_topics(), "the topics")
        topics = camera_topics()
        assert "/telex/cameras/front/image_raw/compressed" in topics
        assert "/telex/cameras/rear/camera_info" in topics
        assert "/telex/cameras/rear/depth" not in topics

    def test_a_camera_comes_and_goes_with_its_link_whose_lack_is_named_once(self, stage):
        lack = "this robot has no telex/no_lamp_link, telex/no_such_link"

        def ghosts():
            return [topic for topic in camera_topics() if "ghost" in topic]

        wait_until(lambda: not ghosts(), "no ghost")
        assert stage.said.count(lack) == stage.simulator.times_lacking
        stage.simulator.let_ghost(True)
        wait_until(lambda: "/telex/cameras/ghost/image_raw/compressed" in ghosts(), "the ghost")
        stage.simulator.let_ghost(False)
        wait_until(lambda: not ghosts(), "no ghost")
        # Once more, when the link has gone again.
        assert stage.said.count(lack) == stage.simulator.times_lacking

    def test_zoom_is_taken_within_its_range_and_told_by_camera_info(self, stage):
        from std_msgs.msg import Float64

        infos = stage.infos("front")
        assert infos.wait().focal_length == pytest.approx(FOCAL)
        told = stage.topics.heard("cameras/front/zoom_factor", Float64)
        wait_until(lambda: told, "the factor that it begins with")
        zoom = stage.commands("cameras/front/zoom", Float64)
        nan, inf = float("nan"), float("inf")
        for value, factor in ((2.5, 2.5), (nan, 2.5), (inf, 2.5), (99.0, 4.0), (-1.0, 1.0)):
            zoom.publish(value)
            time.sleep(0.2)
            assert infos.newest(0.2).focal_length == pytest.approx(factor * FOCAL)
        assert [each.data for each in told] == [1.0, 2.5, 4.0, 1.0]
        # Who comes later is told as well.
        late = stage.topics.heard("cameras/front/zoom_factor", Float64)
        wait_until(lambda: late, "the factor that it has now")
        assert late[0].data == 1.0
        for what in (nan, inf):
            assert f"camera front: zoom is {what}; 1 to 4 is possible" in stage.said
        assert "camera front: zoom is 99; 1 to 4 is possible, 4 is taken" in stage.said
        assert "camera front: zoom is -1; 1 to 4 is possible, 1 is taken" in stage.said

    def test_depth_is_in_metres(self, stage):
        viewer = stage.pictures("front", "depth")
        viewer.wait()
        seen = viewer.note_for(0.6)[-3:]
        assert seen
        for depth in seen:
            assert depth.message.encoding == "32FC1"
            assert depth.frame == "front_camera_optical_frame"
            assert depth.pixels[SIZE[1] // 2, SIZE[0] // 2] == pytest.approx(2.75, abs=0.01)
            # Beside the box there is nothing.
            assert depth.pixels[0, 0] == np.inf

    def test_parameters_are_changed_while_it_runs(self, stage):
        import rospy
        from std_msgs.msg import String

        rear, infos = stage.pictures("rear"), stage.infos("rear")
        told = stage.topics.heard("cameras/settings", String)
        brightness = rear.wait().middle.mean()
        topics = set(camera_topics())
        try:
            answer = stage.configure(
                "rear", "{width: 80, height: 60, rate: 5, depth: true, exposure: {ev: -1}}"
            )
            assert answer.success
            assert "width: 80" in answer.parameters
            rear.note_for(0.5)
            infos.note_for(0.0)
            pictures = rear.note_for(1.0)
            assert 3 <= len(pictures) <= 7
            assert pictures[-1].size == (80, 60)
            # One EV less is half the light.
            assert pictures[-1].middle.mean() < 0.85 * brightness
            assert rospy.get_param(f"{NAMESPACE}/cameras/cameras/rear/width") == 80
            cameras = json.loads(told[-1].data)["cameras"]
            assert cameras["rear"]["exposure"]["ev"] == -1
            assert "overview" not in cameras
            assert infos.wait().size == (80, 60)
            assert infos.wait().focal_length == pytest.approx(40.0 / EDGE)
            assert set(camera_topics()) - topics == {"/telex/cameras/rear/depth"}
            # Another renderer takes the place of the first.
            assert stage.configure("", "{shadow_radius: 3}").success
            rear.note_for(0.3)
            assert rear.wait().looks(GREEN)
        finally:
            assert stage.configure("rear", REAR).success
        wait_until(lambda: "/telex/cameras/rear/depth" not in camera_topics(), "no depth")

    @pytest.mark.parametrize(
        ("camera", "parameters", "reason"),
        [
            ("rear", "{rate: -1, width: 32}", "rate is -1.0; it must be above 0 and at most 240"),
            ("rear", "{noise: .nan}", "noise is nan; it must be finite"),
            ("rear", "{frame: lamp_link}", "frame cannot be changed while the node runs"),
            (
                "side",
                "{rate: 5}",
                "camera is 'side'; front, ghost, overview, rear are possible, or nothing for what"
                " all have in common",
            ),
            ("", "{quality: ultra}", "quality is 'ultra'; auto, software, gpu are possible"),
            ("", "{seed: 5}", "seed cannot be changed while the node runs"),
        ],
    )
    def test_parameters_that_make_no_sense_are_refused_with_the_reason(
        self, stage, camera, parameters, reason
    ):
        answer = stage.configure(camera, parameters)
        assert not answer.success
        assert answer.message == reason

    def test_the_overview_goes_where_it_is_sent(self, stage):
        from geometry_msgs.msg import PoseStamped
        from telex_msgs.msg import OverviewView

        viewer = stage.pictures("overview")
        poses = []
        stage.topics.subscriber("cameras/overview/pose", PoseStamped, poses.append)
        sender = stage.commands("cameras/overview/view", OverviewView)
        sender.publish(OverviewView(mode="fixed", distance=6.0))
        # From far ahead it sees the front box, from behind the other one.
        wait_until(lambda: viewer.wait().looks(RED), "the overview ahead")
        sender.publish(OverviewView(mode="fixed", azimuth=np.pi, distance=6.0))
        after = viewer.newest(0.5)
        assert after.looks(GREEN)
        assert after.frame == "overview_camera_optical_frame"
        # Where it has gone to is told with the pictures.
        assert poses[-1].header.frame_id == "world"
        assert poses[-1].pose.position.x == pytest.approx(-6.0, abs=0.1)
        for refused in (
            OverviewView(mode="fixed", distance=float("nan")),
            OverviewView(mode="fly", distance=6.0),
        ):
            sender.publish(refused)
            assert viewer.newest(0.5).looks(GREEN)
        assert "camera overview: distance is nan; it must be" in stage.said
        assert "camera overview: mode is 'fly'; follow, orbit, fixed are possible" in stage.said

    def test_lamps_are_switched(self, stage, front):
        from std_msgs.msg import Float64

        told = stage.topics.heard("lamps/head/level", Float64)
        wait_until(lambda: told, "the level that it begins with")
        level = stage.commands("lamps/head/command", Float64)
        stage.simulator.revision += 1
        stage.simulator.describe(RED, ambient=0.0)
        front.note_for(0.3)
        starting = front.newest(0.3).middle.max()
        seen = []
        for value in (0.0, float("nan"), 1.0, 0.5):
            level.publish(value)
            time.sleep(0.2)
            seen.append(front.newest(0.3).middle.max())
        off, still_off, full, _ = seen
        assert off == still_off == 0.0
        assert 10.0 < starting < full
        assert [each.data for each in told] == [0.5, 0.0, 1.0, 0.5]
        assert "lamp head: level is nan; 0 to 1 is possible, it stays at 0" in stage.said

    def test_while_paused_a_picture_now_and_then(self, stage, front):
        stage.simulator.paused = True
        front.note_for(0.3)
        pictures = front.note_for(1.0)
        assert len(set(stamps(pictures))) == 1
        assert 2 <= len(pictures) <= 12

    def test_poses_with_nan_move_nothing(self, stage, front):
        stage.simulator.broken = True
        front.note_for(0.3)
        assert front.note_for(0.5) == []
        assert "poses are left out" in stage.said
        stage.simulator.broken = False
        assert front.note_for(0.5)

    def test_poses_wait_for_their_scene(self, stage, front):
        stage.simulator.revision += 1
        front.note_for(0.3)
        assert front.note_for(0.5) == []
        stage.simulator.describe(BLUE)
        front.note_for(0.3)
        come = front.note_for(0.5)
        assert come
        assert all(picture.looks(BLUE) for picture in come)

    def test_a_simulator_that_starts_again_is_followed(self, stage, front):
        stage.simulator.ticks += round(60.0 * POSES_RATE)  # later than it will be again
        front.note_for(0.3)
        before = front.note_for(0.3)
        assert before
        stage.simulator.revision, stage.simulator.ticks = 1, 0
        stage.simulator.describe(GREEN)
        front.note_for(0.3)
        restarted = front.note_for(0.5)
        assert restarted
        assert all(picture.looks(GREEN) for picture in restarted)
        assert max(stamps(restarted)) < min(stamps(before))


class Counter:
    """Counts the pictures that a node of counting_cameras.py draws."""

    def __init__(self, stage):
        from std_msgs.msg import Float64, String

        self._rendered = []  # direction and width of each
        self._time = stage.commands("render_time", Float64)
        wait_until_connected(
            stage.topics.subscriber(
                "rendered", String, lambda m: self._rendered.append(m.data.split())
            )
        )
        self.take_for_each(0.0)

    def take_for_each(self, seconds):
        """Let each picture take so long (s)."""
        from std_msgs.msg import Float64

        self._time.publish(Float64(seconds))

    def within(self, seconds):
        """How many are drawn in each direction within some time (s), and in which widths."""
        begin = len(self._rendered)
        time.sleep(seconds)
        ways, widths = zip(*self._rendered[begin:]) if self._rendered[begin:] else ((), ())
        counts = {"ahead": ways.count("ahead"), "back": ways.count("back")}
        return counts, {int(width) for width in widths}


class TestCounted:
    """What a node draws for whom."""

    @pytest.fixture(scope="class")
    def started(self, master, tmp_path_factory):
        log = tmp_path_factory.mktemp("counting") / "log"
        with running(master, log, HERE / "counting_cameras.py") as stage:
            yield stage

    @pytest.fixture
    def counter(self, stage):
        counter = Counter(stage)
        nothing = {"ahead": 0, "back": 0}
        wait_until(lambda: counter.within(0.3)[0] == nothing, "who looked before to be gone")
        yield counter
        counter.take_for_each(0.0)

    def test_nothing_is_drawn_for_infos(self, stage, counter):
        stage.infos("front").wait()
        counts, _ = counter.within(0.5)
        assert counts == {"ahead": 0, "back": 0}

    @pytest.mark.parametrize(
        ("camera", "looks", "not_there"), [("front", "ahead", "back"), ("rear", "back", "ahead")]
    )
    def test_one_camera_is_drawn_for_who_looks_at_it(
        self, stage, counter, camera, looks, not_there
    ):
        stage.pictures(camera).wait()
        counts, _ = counter.within(0.5)
        assert counts[looks] > 3
        assert counts[not_there] == 0

    def test_nothing_larger_is_drawn_for_who_looks_at_previews(self, stage, counter):
        stage.pictures("rear", "preview/compressed").wait()
        time.sleep(0.2)
        _, widths = counter.within(0.3)
        assert widths == {SMALL[0]}

    def test_previews_cost_nothing_beside_pictures_of_full_size(self, stage, counter):
        preview = stage.pictures("rear", "preview/compressed")
        preview.wait()
        stage.pictures("rear").wait()
        time.sleep(0.2)
        preview.note_for(0.0)
        counts, widths = counter.within(0.4)
        assert len(preview.noted) > 1
        # At their rate of 20 in a second, none is drawn for the previews alone.
        assert counts["back"] <= 0.4 * 20.0 + 3
        assert widths == {SIZE[0]}

    def test_nothing_is_drawn_for_nobody_any_more(self, stage, counter):
        stage.pictures("rear").wait()
        stage.leave()
        time.sleep(0.3)
        counts, _ = counter.within(0.5)
        assert counts == {"ahead": 0, "back": 0}

    def test_when_all_is_late_who_comes_is_served_and_who_goes_no_more(self, stage, counter):
        # Far longer than the period of the cameras: one of them is always late.
        counter.take_for_each(0.15)
        stage.pictures("front").wait()
        with Topics(NAMESPACE) as topics:
            rear = Viewer(topics, "rear/image_raw/compressed", picture_type("compressed"))
            rear.wait()
            stage.leave()
            time.sleep(0.5)
            counts, _ = counter.within(0.5)
        assert counts["back"] > 0
        assert counts["ahead"] == 0


@pytest.mark.parametrize(
    ("params", "environment", "complaint"),
    [
        ({**PARAMS, "cameras": {}}, {}, "cameras is empty"),
        (PARAMS, NO_EGL, "apt-get install libegl1 libgl1 libgl1-mesa-dri"),
    ],
)
def test_what_cannot_work_ends_with_one_line(master, params, environment, complaint):
    import rospy

    rospy.set_param(f"{NAMESPACE}/wrong", params)
    node = subprocess.run(
        [sys.executable, str(NODE), "__name:=wrong", f"__ns:={NAMESPACE}"],
        env={**master, **environment},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    rospy.delete_param(f"{NAMESPACE}/wrong")
    assert node.returncode == 1
    assert complaint in node.stderr
    assert "[FATAL]" in node.stderr
    assert "Traceback" not in node.stderr
