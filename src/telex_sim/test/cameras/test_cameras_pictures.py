"""What a node makes of its renderer's pictures, each of one grey, without a master."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header
from telex_msgs.msg import ActiveMalfunction, Malfunctions, SceneDescription, ScenePoses

from telex_control.common.params import read_config
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.drawing.kept_pictures import KeptPictures
from telex_sim.cameras.optics.flaws import SOUND, Flaws
from telex_sim.cameras.ros import cameras_node
from telex_sim.cameras.ros.cameras_node import CamerasNode
from telex_sim.cameras.ros.robot_cameras import RobotCameras

SIZE = (64, 48)
RATE = 240.0
CAMERA = {"width": SIZE[0], "height": SIZE[1], "horizontal_fov": 1.2, "rate": RATE, "depth": True}
PARAMS = {
    "cameras": {
        "front": {**CAMERA, "frame": "front", "preview": {"width": 32, "rate": RATE}},
        "rear": {
            **CAMERA,
            "width": 80,
            "height": 60,
            "frame": "rear",
            "distortion": [-0.1, 0.02, 0.0, 0.0, 0.0],
            "preview": {"width": 80, "rate": RATE},
        },
    },
    "shadow_period": 0.0,
}
PICTURE, DEPTH, PREVIEW = "image_raw", "depth", "preview/compressed"


class Graph:
    """Topics of rospy, by their names within ``cameras``."""

    def __init__(self, monkeypatch):
        self.heard = set()
        self.told = {}
        self.callbacks = {}
        self.rounds = 0
        monkeypatch.setattr(rospy, "Publisher", lambda topic, *_, **__: Publisher(self, topic))
        monkeypatch.setattr(rospy, "Subscriber", self.subscribe)
        monkeypatch.setattr(rospy, "Service", lambda *_: None)
        monkeypatch.setattr(rospy, "is_shutdown", self.is_over)
        monkeypatch.setattr(cameras_node, "_PATIENCE", 2.0 / RATE)

    def subscribe(self, topic, kind, callback, **_):
        self.callbacks[topic] = callback

    def is_over(self):
        self.rounds -= 1
        return self.rounds < 0


class Publisher:
    def __init__(self, graph, topic):
        self._graph = graph
        self._topic = topic[len("cameras/") :]

    def get_num_connections(self):
        return int(self._topic in self._graph.heard)

    def publish(self, message):
        self._graph.told.setdefault(self._topic, []).append(message)

    def unregister(self):
        pass


class GreyRenderer:
    """Draws the height of the world's frame, as grey and, in metres, as depth."""

    on_card = repeats = False

    def __init__(self):
        self._size = None
        self._height = 0.0
        self._kept = KeptPictures()

    def load_scene(self, scene):
        return []

    def set_lamp_levels(self, levels):
        pass

    def place(self, frames_in_world, focus, recast=True):
        self._height = frames_in_world[0, 2, 3]
        self._kept.place(frames_in_world, focus, recast)

    def render(self, camera, optical_in_world, exposure=1.0, coarse=False):
        self._size = (camera.height, camera.width)
        picture = self._kept.find(camera, optical_in_world, exposure, coarse)
        self.repeats = picture is not None
        if not self.repeats:
            picture = np.full((*self._size, 4), self._height, np.uint8)
            self._kept.keep(camera, optical_in_world, exposure, picture, coarse)
        return picture

    def depth(self, camera):
        if self._size != (camera.height, camera.width):
            raise ValueError(f"the last picture was not of {camera.width}x{camera.height} pixels")
        return np.full(self._size, self._height, np.float32)


class Stage:
    """A node, who looks, and what is there to be seen."""

    def __init__(self, monkeypatch):
        self._graph = Graph(monkeypatch)
        config = read_config(CamerasConfig, PARAMS, "cameras")
        self._node = CamerasNode(config, lambda _: GreyRenderer())
        frames = ["world", "telex/front", "telex/rear"]
        self._graph.callbacks["sim/scene"](SceneDescription(revision=1, frames=frames))
        self._ticks = 0

    def freeze(self, *cameras):
        active = [ActiveMalfunction(what=each, group="camera", kind="frozen") for each in cameras]
        self._graph.callbacks["sim/malfunctions"](Malfunctions(active=active))

    def look(self, height, *topics):
        """Greys, and depths, that come on topics of cameras while the scene is so high."""
        self._graph.heard, self._graph.told = set(topics), {}
        place = [0.0, 0.0, height, 0.0, 0.0, 0.0, 1.0]
        for _ in range(4):
            self._graph.rounds = 4
            self._ticks += 1
            stamp = rospy.Time(self._ticks)
            poses = ScenePoses(header=Header(stamp=stamp), revision=1, poses=3 * place)
            self._node._inbox.put_poses(poses)
            self._node.run()
        return [self._value(self._graph.told[topic][-1]) for topic in topics]

    @staticmethod
    def _value(message):
        if isinstance(message, CompressedImage):
            return len(message.data)
        assert isinstance(message, Image)
        kind = np.float32 if message.encoding == "32FC1" else np.uint8
        return float(np.frombuffer(message.data, kind).mean())


@pytest.fixture
def stage(monkeypatch):
    return Stage(monkeypatch)


FRONT, DEEP, REAR = f"front/{PICTURE}", f"front/{DEPTH}", f"rear/{PICTURE}"


def test_depths_are_those_of_the_picture_that_stands(stage):
    stage.freeze("front")
    assert stage.look(10.0, FRONT, DEEP, REAR) == [10.0, 10.0, 10.0]
    # The rear camera, of another size, took the last picture.
    assert stage.look(20.0, FRONT, DEEP, REAR) == [10.0, 10.0, 20.0]
    stage.freeze()
    assert stage.look(30.0, FRONT, DEEP, REAR) == [30.0, 30.0, 30.0]


def test_who_listens_to_depths_later_gets_those_of_the_same_moment(stage):
    stage.freeze("front")
    stage.look(10.0, f"front/{PREVIEW}")
    assert stage.look(20.0, FRONT, DEEP) == [10.0, 10.0]


def test_a_camera_that_freezes_again_shows_what_it_saw_then(stage):
    stage.freeze("front")
    assert stage.look(10.0, FRONT) == [10.0]
    # Nobody looks at it meanwhile.
    stage.freeze()
    stage.freeze("front")
    assert stage.look(20.0, FRONT) == [20.0]


def test_it_stays_frozen_while_other_things_fail(stage):
    stage.freeze("front")
    stage.look(10.0, FRONT)
    stage.freeze("rear", "front")
    assert stage.look(20.0, FRONT, REAR) == [10.0, 20.0]


def test_a_picture_is_of_now_where_a_preview_of_its_size_was_taken_before(stage):
    assert stage.look(10.0, REAR) == [10.0]
    # Both are of one view: the renderer gives the one picture again for the other.
    stage.look(20.0, f"rear/{PREVIEW}")
    assert stage.look(20.0, REAR) == [20.0]


def test_cameras_of_robots_alike_have_noise_and_dirt_of_their_own(monkeypatch):
    Graph(monkeypatch)
    noisy = {**PARAMS, "cameras": {"front": {**CAMERA, "frame": "front", "noise": 4.0}}}
    config = read_config(CamerasConfig, noisy, "cameras")

    def seen(namespace, flaws=SOUND):
        (stream,) = RobotCameras(config, namespace).streams
        grey = np.full((SIZE[1], SIZE[0], 4), 128, np.uint8)
        return stream.full_sensor().develop([grey], False, 0.0, 10**9, flaws=flaws)[..., :3]

    for flaws in (SOUND, Flaws(dirty=0.3)):
        first = seen("", flaws)
        assert (first == seen("", flaws)).all()
        assert (first != seen("/second", flaws)).mean() > 0.5
        assert (seen("/third", flaws) != seen("/second", flaws)).mean() > 0.5
    # As it is without further robots.
    assert config.seed_of("front") == zlib.crc32(b"front")
