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
    def stamp(self):
        """Of the newest poses (ns)."""
        return self.ticks * POSES_PERIOD

    def go_on(self, seconds):
        """Wait until so much sim time has passed (s)."""
        end = self.ticks + seconds * POSES_RATE
        wait_until(lambda: self.ticks >= end, "the simulator's time")

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

        begun, before = time.monotonic(), 0
        while not self._ended.wait(1.0 / POSES_RATE):
            # As fast as wall time, however late this thread is.
            passed = int((time.monotonic() - begun) * POSES_RATE)
            if not self.paused:
                self.ticks += passed - before
            before = passed
            poses = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            # Optical frames that look along x, and against it.
            poses += [0.0, 0.0, 0.0, -0.5, 0.5, -0.5, 0.5]
            poses += [0.0, 0.0, 0.0, 0.5, 0.5, -0.5, -0.5]
            poses += [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] * (2 + self.ghost)
            if self.broken:
                poses[7] = float("nan")
            message = ScenePoses(revision=self.revision, poses=poses)
            message.header.stamp = self._time(*divmod(self.stamp, 10**9))
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
        # With room for all: of what is read at once, nothing is dropped.
        topics.subscriber(f"cameras/{topic}", kind, lambda m: self.noted.append(Note(m)))

    def note_for(self, seconds):
        """What comes within some time."""
        self.noted = []
        time.sleep(seconds)
        return list(self.noted)

    def wait(self):
        """The last message; the first, if none has come yet."""
        return wait_until(lambda: self.noted[-1:], "a message of a camera", 20.0)[0]

    def next(self, count):
        """What comes from now on, until there is something of so many poses."""
        self.noted = []
        return self.later(-1, count)

    def newest(self):
        """The last message of those that have come now."""
        return self.next(1)[-1]

    def later(self, stamp, count=1):
        """What has been noted with later stamps (ns), once that is of so many poses."""

        def noted():
            return [note for note in self.noted if note.stamp > stamp]

        wait_until(lambda: len(set(stamps(noted()))) >= count, f"messages of {count} poses", 20.0)
        return noted()


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

    def wait_for(self, words):
        """Wait until the node's log has some words."""
        wait_until(lambda: words in self.said, words, 20.0)

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


def period(pictures):
    """Median time between pictures of different poses (s)."""
    return np.median(np.diff(np.unique(stamps(pictures)))) / 1e9


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
        pictures = front.next(20)
        assert 0.045 < period(pictures) < 0.1
        assert all(picture.looks(RED) for picture in pictures)
        found = stamps(pictures)
        assert found == sorted(found)
        # None comes twice, unless there were no newer poses for 0.2 s.
        taken, times = np.unique(found, return_counts=True)
        assert (np.diff(taken)[times[:-1] > 1] > 190_000_000).all()
        assert all(stamp % POSES_PERIOD == 0 for stamp in found)
        # A slow listener may miss one.
        wait_until(lambda: len(set(found) & set(stamps(infos.noted))) >= len(found) - 2)
        info = infos.noted[-1]
        assert info.frame == "front_camera_optical_frame"
        assert info.size == SIZE
        assert info.message.K[2] == pytest.approx((SIZE[0] - 1) / 2)
        assert info.focal_length == pytest.approx(FOCAL)
        assert list(info.message.D) == [-0.1, 0.02, 0.0, 0.0, 0.0]

    def test_the_other_camera_looks_the_other_way(self, stage):
        viewer = stage.pictures("rear")
        seen = viewer.next(5)
        assert all(picture.looks(GREEN) for picture in seen)
        assert all(picture.frame == "rear_camera_optical_frame" for picture in seen)

    def test_raw_pictures_while_somebody_listens(self, stage):
        viewer = stage.pictures("front", "image_raw")
        seen = viewer.next(5)
        assert all(picture.looks(RED) for picture in seen)

    @pytest.mark.parametrize(("camera", "color"), [("rear", GREEN), ("front", RED)])
    def test_previews_show_the_same_in_fewer_pixels(self, stage, camera, color):
        viewer = stage.pictures(camera, "preview/compressed")
        seen = viewer.next(5)
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
            return front.newest().pixels[50:70, 70:90].astype(float).std(axis=(0, 1)).max()

        calm = grain()
        tell(1000.0, 80.0, False)
        wait_until(lambda: grain() > calm + 3.0, "dots in the pictures", 20.0)
        tell(-1.0, 0.0, False)
        stage.wait_for("it is not heeded")
        tell(0.0, 90.0, True)
        wait_until(lambda: not front.note_for(1.0), "no pictures any more", 20.0)
        tell(0.0, 0.0, False)
        wait_until(lambda: front.note_for(0.5), "pictures", 20.0)
        wait_until(lambda: grain() < calm + 3.0, "clear pictures", 20.0)

    def test_malfunctions_show_in_pictures(self, stage, front):
        from telex_msgs.msg import ActiveMalfunction, Malfunctions

        told = stage.commands("sim/malfunctions", Malfunctions)

        def tell(kind="", value=0.0, unpowered=(), group="camera", what="front", more=()):
            active = [ActiveMalfunction(what=what, group=group, kind=kind, value=value)]
            told.publish(
                Malfunctions(active=active * bool(kind) + [*more], unpowered=list(unpowered))
            )

        tell("dark", 1.0)
        wait_until(lambda: front.newest().middle.max() < 3.0, "dark pictures", 20.0)
        tell("dark", float("nan"))
        wait_until(lambda: front.newest().looks(RED), "what is no number not heeded", 20.0)
        stage.wait_for("sim/malfunctions: front: value is nan")

        # A frozen picture is as the one before: the rear camera shows that this is heeded.
        rear = stage.pictures("rear")
        dark = ActiveMalfunction(what="rear", group="camera", kind="dark", value=1.0)
        tell("frozen", more=[dark])
        wait_until(lambda: rear.newest().middle.max() < 3.0, "the rear camera dark", 20.0)
        front.later(rear.noted[-1].stamp)
        stage.simulator.revision += 1
        changed = stage.simulator.stamp
        stage.simulator.describe(BLUE)
        small = stage.pictures("front", "preview/compressed")
        frozen = front.later(changed, 5)
        assert all(picture.looks(RED) for picture in frozen)
        assert small.later(changed)[-1].looks(RED)
        tell()
        wait_until(lambda: front.newest().looks(BLUE), "live pictures", 20.0)

        stage.simulator.describe(BLUE, ambient=0.0)
        wait_until(lambda: front.newest().looks(BLUE), "lit by the lamp", 20.0)
        tell("dead", what="head", group="lamp")
        wait_until(lambda: front.newest().middle.max() == 0.0, "the dark", 20.0)
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

        def stays_at(factor):
            length = pytest.approx(factor * FOCAL)
            wait_until(lambda: infos.newest().focal_length == length, f"zoom {factor}", 20.0)
            assert all(info.focal_length == length for info in infos.next(3))

        for value, factor, said in (
            (2.5, 2.5, ""),
            (nan, 2.5, "camera front: zoom is nan; 1 to 4 is possible"),
            (inf, 2.5, "camera front: zoom is inf; 1 to 4 is possible"),
            (99.0, 4.0, "camera front: zoom is 99; 1 to 4 is possible, 4 is taken"),
            (-1.0, 1.0, "camera front: zoom is -1; 1 to 4 is possible, 1 is taken"),
        ):
            zoom.publish(value)
            stage.wait_for(said)
            stays_at(factor)
        wait_until(lambda: len(told) >= 4, "the last factor")
        assert [each.data for each in told] == [1.0, 2.5, 4.0, 1.0]
        # Who comes later is told as well.
        late = stage.topics.heard("cameras/front/zoom_factor", Float64)
        wait_until(lambda: late, "the factor that it has now")
        assert late[0].data == 1.0

    def test_depth_is_in_metres(self, stage):
        viewer = stage.pictures("front", "depth")
        for depth in viewer.next(3):
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
            wait_until(lambda: rear.newest().size == (80, 60), "smaller pictures", 20.0)
            pictures = rear.next(6)
            assert 0.15 < period(pictures) < 0.33
            assert {picture.size for picture in pictures} == {(80, 60)}
            # One EV less is half the light.
            assert pictures[-1].middle.mean() < 0.85 * brightness
            assert rospy.get_param(f"{NAMESPACE}/cameras/cameras/rear/width") == 80

            def cameras():
                return json.loads(told[-1].data)["cameras"]

            wait_until(lambda: cameras()["rear"]["exposure"]["ev"] == -1, "the settings")
            assert "overview" not in cameras()
            info = infos.later(pictures[0].stamp)[0]
            assert info.size == (80, 60)
            assert info.focal_length == pytest.approx(40.0 / EDGE)
            depth = "/telex/cameras/rear/depth"
            wait_until(lambda: set(camera_topics()) - topics == {depth}, "depth")
            # Another renderer takes the place of the first.
            renderers = stage.said.count("rendering with")
            assert stage.configure("", "{shadow_radius: 3}").success
            wait_until(lambda: stage.said.count("rendering with") > renderers, "another", 20.0)
            assert rear.next(2)[-1].looks(GREEN)
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
        wait_until(lambda: viewer.newest().looks(GREEN), "the overview behind")
        assert viewer.wait().frame == "overview_camera_optical_frame"
        # Where it has gone to is told with the pictures.
        behind = pytest.approx(-6.0, abs=0.1)
        wait_until(lambda: poses[-1].pose.position.x == behind, "its place")
        assert poses[-1].header.frame_id == "world"
        for refused, said in (
            (OverviewView(mode="fixed", distance=float("nan")), "distance is nan; it must be"),
            (
                OverviewView(mode="fly", distance=6.0),
                "mode is 'fly'; follow, orbit, fixed are possible",
            ),
        ):
            sender.publish(refused)
            stage.wait_for(f"camera overview: {said}")
            assert all(picture.looks(GREEN) for picture in viewer.next(3))

    def test_lamps_are_switched(self, stage, front):
        from std_msgs.msg import Float64

        told = stage.topics.heard("lamps/head/level", Float64)
        wait_until(lambda: told, "the level that it begins with")
        level = stage.commands("lamps/head/command", Float64)
        stage.simulator.revision += 1
        darkened = stage.simulator.stamp
        stage.simulator.describe(RED, ambient=0.0)

        def brightness():
            return front.newest().middle.max()

        starting = front.later(darkened)[-1].middle.max()
        assert starting > 10.0
        level.publish(0.0)
        wait_until(lambda: brightness() == 0.0, "the dark")
        level.publish(float("nan"))
        stage.wait_for("lamp head: level is nan; 0 to 1 is possible, it stays at 0")
        assert all(picture.middle.max() == 0.0 for picture in front.next(3))
        level.publish(1.0)
        wait_until(lambda: brightness() > starting, "more light than before")
        level.publish(0.5)
        wait_until(lambda: brightness() == starting, "as much light as before")
        wait_until(lambda: len(told) >= 4, "the last level")
        assert [each.data for each in told] == [0.5, 0.0, 1.0, 0.5]

    def test_while_paused_a_picture_now_and_then(self, stage, front):
        begun = time.monotonic()
        # The poses that stay are later than that.
        stage.simulator.go_on(0.1)
        stage.simulator.paused = True

        def repeated():
            return [note for note in front.noted if note.stamp == front.noted[-1].stamp]

        wait_until(lambda: len(repeated()) >= 8, "eight pictures of the same poses", 20.0)
        assert len(repeated()) <= 12.0 * (time.monotonic() - begun)

    def test_poses_with_nan_move_nothing(self, stage, front):
        stage.simulator.broken = True
        front.noted = []
        broken = stage.simulator.stamp
        stage.wait_for("poses are left out")
        count = len(front.noted)
        stage.simulator.go_on(0.5)
        mended = stage.simulator.stamp
        stage.simulator.broken = False
        front.later(mended)
        found = stamps(front.noted)
        assert not [stamp for stamp in found if broken < stamp <= mended]
        # One may have been on its way.
        assert len([stamp for stamp in found[count:] if stamp <= broken]) <= 1

    def test_poses_wait_for_their_scene(self, stage, front):
        stage.simulator.revision += 1
        front.noted = []
        changed = stage.simulator.stamp
        stage.simulator.go_on(0.3)
        count = len(front.noted)
        stage.simulator.go_on(0.5)
        found = stamps(front.noted)
        assert all(stamp <= changed for stamp in found)
        assert len(found) <= count + 1
        stage.simulator.describe(BLUE)
        assert all(picture.looks(BLUE) for picture in front.later(changed, 5))

    def test_a_simulator_that_starts_again_is_followed(self, stage, front):
        now = stage.simulator.stamp
        stage.simulator.ticks += round(60.0 * POSES_RATE)  # later than it will be again
        last = front.later(now + 50 * 10**9)[-1].stamp
        stage.simulator.revision, stage.simulator.ticks = 1, 0
        stage.simulator.describe(GREEN)
        wait_until(lambda: front.noted[-1].stamp < last - 50 * 10**9, "pictures of the new one")
        restarted = front.next(5)
        assert all(picture.looks(GREEN) for picture in restarted)
        assert max(stamps(restarted)) < last - 50 * 10**9


NOTHING = {"ahead": 0, "back": 0}


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

    @property
    def count(self):
        return len(self._rendered)

    def since(self, begin):
        """How many have been drawn in each direction since a count, and in which widths."""
        ways, widths = zip(*self._rendered[begin:]) if self._rendered[begin:] else ((), ())
        counts = {"ahead": ways.count("ahead"), "back": ways.count("back")}
        return counts, [int(width) for width in widths]

    def within(self, seconds):
        """How many are drawn in each direction within some time (s)."""
        begin = self.count
        time.sleep(seconds)
        return self.since(begin)[0]

    def until(self, way, count):
        """Draw so many in a direction, and return what `since` does of that time."""
        begin = self.count
        wait_until(lambda: self.since(begin)[0][way] >= count, f"{count} pictures {way}", 20.0)
        return self.since(begin)


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
        wait_until(lambda: counter.within(0.3) == NOTHING, "who looked before to be gone")
        yield counter
        counter.take_for_each(0.0)

    def test_nothing_is_drawn_for_infos(self, stage, counter):
        begin = counter.count
        stage.infos("front").next(10)
        assert counter.since(begin)[0] == NOTHING

    @pytest.mark.parametrize(
        ("camera", "looks", "not_there"), [("front", "ahead", "back"), ("rear", "back", "ahead")]
    )
    def test_one_camera_is_drawn_for_who_looks_at_it(
        self, stage, counter, camera, looks, not_there
    ):
        stage.pictures(camera).wait()
        counts, _ = counter.until(looks, 6)
        assert counts[not_there] == 0

    def test_nothing_larger_is_drawn_for_who_looks_at_previews(self, stage, counter):
        stage.pictures("rear", "preview/compressed").wait()
        _, widths = counter.until("back", 6)
        assert set(widths) == {SMALL[0]}

    def test_previews_cost_nothing_beside_pictures_of_full_size(self, stage, counter):
        begin, begun = counter.count, time.monotonic()
        preview = stage.pictures("rear", "preview/compressed")
        preview.wait()
        full = stage.pictures("rear")
        full.wait()
        counter.until("back", 8)
        widths = counter.since(begin)[1]
        passed = time.monotonic() - begun
        assert len(preview.later(full.noted[0].stamp, 3)) >= 3
        # At their rate of 20 in a second, none is drawn for the previews alone.
        assert len(widths) <= passed * 20.0 + 3
        assert set(widths[widths.index(SIZE[0]) :]) == {SIZE[0]}

    def test_nothing_is_drawn_for_nobody_any_more(self, stage, counter):
        stage.pictures("rear").wait()
        stage.leave()
        wait_until(lambda: counter.within(0.8) == NOTHING, "nothing to be drawn")

    def test_when_all_is_late_who_comes_is_served_and_who_goes_no_more(self, stage, counter):
        # Far longer than the period of the cameras: one of them is always late.
        counter.take_for_each(0.15)
        stage.pictures("front").wait()
        with Topics(NAMESPACE) as topics:
            rear = Viewer(topics, "rear/image_raw/compressed", picture_type("compressed"))
            rear.wait()
            stage.leave()
            wait_until(lambda: counter.until("back", 3)[0]["ahead"] == 0, "nothing ahead")
            counts, _ = counter.until("back", 4)
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
