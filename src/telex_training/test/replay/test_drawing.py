"""Pictures of moments, drawn by a cameras' node that the test stands in for."""

from __future__ import annotations

import threading
import time

import pytest
from own_ros import Topics
from replay_drill import drill, record
from rospy.impl.tcpros_base import TCPROSTransport
from waiting import wait_until

from telex_training.recording.writer import RecordingError
from telex_training.replay.cameras import OUTSIDE
from telex_training.replay.replay import Replay
from telex_training.ros.replay import drawing
from telex_training.ros.replay.drawing import Drawing, DrawingError

pytestmark = [pytest.mark.ros, pytest.mark.waiting]


class FakeProcess:
    """Runs until it is told otherwise; starts nothing."""

    def __init__(self, namespace):
        self.namespace = namespace
        self.runs = True

    def require(self, config):
        return False

    def end(self):
        self.runs = False


class FakeCameras:
    """Draws each pose once, as the node does, and sends pictures to whoever seems to listen."""

    def __init__(self, topics):
        from telex_msgs.msg import ScenePoses

        self._topics = topics
        self.poses = []
        topics.subscriber("sim/poses", ScenePoses, self._draw)
        self._pictures = None

    def advertise(self):
        from sensor_msgs.msg import CompressedImage

        self._message = CompressedImage
        self._pictures = self._topics.publisher(
            f"cameras/{OUTSIDE}/image_raw/compressed", CompressedImage
        )

    def _draw(self, poses):
        self.poses.append(poses)
        if self._pictures is not None:
            picture = self._message(data=b"picture")
            picture.header.stamp = poses.header.stamp
            self._pictures.publish(picture)


@pytest.fixture
def parts(master, tmp_path, monkeypatch):
    import rospy

    monkeypatch.setattr(drawing, "CamerasProcess", FakeProcess)
    # Latched messages of one test are none of the next one's.
    name = f"/drawing_{time.monotonic_ns()}"
    monkeypatch.setattr(rospy, "get_name", lambda: name)
    with Topics(name) as topics:
        cameras = FakeCameras(topics)
        made = Drawing(0, 60.0)
        replay = Replay.open(record(tmp_path / "t1.mcap", drill().entries), {})
        yield made, cameras, replay
        made.close()


def ask(made, replay, pictures):
    try:
        pictures.append(made.picture(replay, replay.timeline.moment(1.0), OUTSIDE))
    except DrawingError as error:
        pictures.append(error)


def test_poses_wait_for_whom_their_picture_is_for(parts, monkeypatch):
    made, cameras, replay = parts
    connect = TCPROSTransport.connect

    def connect_slowly(transport, *arguments, **options):
        time.sleep(0.3)
        connect(transport, *arguments, **options)

    monkeypatch.setattr(TCPROSTransport, "connect", connect_slowly)
    pictures = []
    asking = threading.Thread(target=ask, args=(made, replay, pictures))
    asking.start()
    try:
        time.sleep(0.5)
        # Drawn now, the picture would be lost, and its poses are not drawn again.
        assert cameras.poses == []
        cameras.advertise()
        wait_until(lambda: pictures, "the picture")
    finally:
        made._process.end()
        asking.join()
    assert pictures == [b"picture"]


def test_it_is_told_when_what_draws_ends_or_sends_nothing(parts, monkeypatch):
    made, cameras, replay = parts
    monkeypatch.setattr(drawing, "_STARTING", 0.3)
    pictures = []
    ask(made, replay, pictures)
    assert "no picture of the camera 'outside' came within 0.3 s" in str(pictures[0])
    made._process.end()
    ask(made, replay, pictures)
    assert "what draws has ended" in str(pictures[1])
    assert cameras.poses == []


def test_what_cannot_be_set_as_parameters_is_told_of_the_recording(parts, monkeypatch):
    made, _, replay = parts

    def refuse(_config):
        raise OverflowError("int exceeds XML-RPC limits")

    monkeypatch.setattr(made._process, "require", refuse)
    moment = replay.timeline.at(0)
    for draw in (
        lambda: made.start(replay),
        lambda: made.place(replay, moment),
        lambda: made.picture(replay, moment, OUTSIDE),
    ):
        with pytest.raises(RecordingError, match=r"t1\.mcap: it cannot be drawn: OverflowError"):
            draw()


def test_it_does_not_rest_just_when_somebody_looks(parts):
    made, _, _ = parts
    made._idle = 0.0
    with made._turn:
        resting = threading.Thread(target=made.rest)
        resting.start()
        resting.join(5.0)
        assert not resting.is_alive()
    assert made._process.runs
    made.rest()
    assert not made._process.runs
