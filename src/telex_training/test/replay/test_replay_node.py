"""The real replay node with its own cameras: services, topics, pictures, and who may see them."""

from __future__ import annotations

import contextlib
import json
import urllib.error
import urllib.request
from pathlib import Path

import pytest
import simplejpeg
from own_ros import NodeProcess, Topics
from replay_drill import CAMERAS, drill, failing, record, record_faster
from telex_msgs.msg import SceneLight
from training_truth import serialized
from waiting import wait_until

from telex_training.recording.trial_file import CAMERAS as CAMERAS_JSON
from telex_training.recording.trial_file import EXPERTS, expert_path
from telex_training.recording.writer import Attachment
from telex_training.replay.replay import Replay

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

NODE = Path(__file__).parents[2] / "nodes" / "replay"
ROBOT = "/robot8"
NAMESPACE = f"{ROBOT}/replay"


class Station:
    """The node as the video server sees it, and as ROS does."""

    def __init__(self, topics, folder):
        from sensor_msgs.msg import JointState
        from telex_msgs.msg import ReplayState, SceneDescription, ScenePoses, TrainingState
        from telex_msgs.srv import OpenReplay, SeekReplay

        self.folder = folder
        self.training = topics.publisher("training/state", TrainingState, latch=True)
        self.state_message = TrainingState
        self.states = topics.heard("replay/state", ReplayState)
        self.scenes = topics.heard("replay/sim/scene", SceneDescription)
        self.poses = topics.heard("replay/sim/poses", ScenePoses)
        self.joints = topics.heard("replay/joint_states", JointState)
        self.open = topics.calls("replay/open", OpenReplay)
        self.seek = topics.calls("replay/seek", SeekReplay)
        wait_until(lambda: self.states, "the node's state", 60.0)
        self.address = self.handler()

    def handler(self):
        import rospy

        name = f"{ROBOT}/video_server/mounts/replay"
        wait_until(lambda: rospy.has_param(name), "the mount", 60.0)
        return rospy.get_param(name)["handler"]

    def ask(self, path, name="", role="operator", post=None):
        """Status and body of an answer, as the video server passes requests on."""
        headers = {"X-Telex-Role": role, "X-Telex-Name": name}
        data = None if post is None else json.dumps(post).encode()
        if data is not None:
            headers["Content-Type"] = "application/json"
        request = urllib.request.Request(f"{self.address}/replay/{path}", data, headers)
        try:
            with urllib.request.urlopen(request, timeout=90.0) as answer:
                return answer.status, answer.read(), dict(answer.headers)
        except urllib.error.HTTPError as error:
            return error.code, error.read(), dict(error.headers)

    def phase(self, phase):
        self.training.publish(self.state_message(phase=phase))


@pytest.fixture(scope="module")
def station(master, tmp_path_factory):
    import rospy

    folder = tmp_path_factory.mktemp("trials")
    (folder / EXPERTS).mkdir()
    record(folder / "t1.mcap", drill().entries)
    record(folder / "t3.mcap", failing(drill()).entries)
    dark = drill()
    dark.feed("sim/light", "telex_msgs/SceneLight", serialized(SceneLight(0.02, 1.0)))
    dark.seconds(1.0)
    record(folder / "t4.mcap", dark.entries)
    huge = json.loads(json.dumps(CAMERAS))
    # A number that no parameter can carry.
    huge["cameras"]["front"]["far"] = 2**40
    cameras = Attachment("application/json", json.dumps(huge).encode())
    record(folder / "t5.mcap", drill().entries, {CAMERAS_JSON: cameras})
    record_faster(folder / "t9.mcap")
    record_faster(expert_path(folder, "drill", "standard"))
    (folder / "broken.mcap").write_bytes(b"no recording")
    for key, value in (("folder", str(folder)), ("niceness", 0), ("busy_period", 0.1)):
        rospy.set_param(f"{NAMESPACE}/{key}", value)
    with contextlib.ExitStack() as stack:
        topics = stack.enter_context(Topics(ROBOT))
        stack.enter_context(NodeProcess([NODE], {**master, "ROS_NAMESPACE": ROBOT}))
        yield Station(topics, folder)


class TestServices:
    def test_a_recording_is_opened_and_sought_in(self, station):
        opened = station.open("t1")
        assert opened.success, opened.message
        assert opened.trial == "t1"
        assert "software test" in opened.message
        assert opened.frames > 200
        found = station.seek(1.0, 0.0)
        assert found.success
        assert found.time == pytest.approx(1.0, abs=0.021)
        wait_until(
            lambda: station.poses and station.poses[-1].header.stamp.to_sec() > 11.0, "the poses"
        )
        # Each topic has a connection of its own: one may be made before another.
        wait_until(lambda: station.scenes and station.joints, "the scene and the joints")
        # Recorded time begins at 10.02 s.
        assert station.poses[-1].header.stamp.to_sec() == pytest.approx(11.02, abs=0.021)
        assert len(station.poses[-1].poses) == 7 * len(station.scenes[-1].frames)
        assert station.poses[-1].revision == station.scenes[-1].revision
        assert "turret_joint" in station.joints[-1].name

    def test_it_plays_on_and_ends_at_the_end(self, station):
        station.open("t1")
        assert station.seek(0.0, 8.0).success
        wait_until(lambda: station.states[-1].time > 1.0, "that it plays")
        wait_until(lambda: station.states[-1].speed == 0.0, "the end")
        assert station.states[-1].time == pytest.approx(station.states[-1].duration)

    @pytest.mark.parametrize(
        ("time", "speed", "why"),
        [(float("nan"), 0.0, "finite"), (0.0, float("nan"), "speed"), (0.0, 9.0, "0 to 8")],
    )
    def test_numbers_that_make_no_sense_are_refused(self, station, time, speed, why):
        station.open("t1")
        answer = station.seek(time, speed)
        assert not answer.success
        assert why in answer.message

    @pytest.mark.parametrize(("trial", "why"), [("t2", "t2"), ("broken", "no recording")])
    def test_what_is_no_recording_is_refused(self, station, trial, why):
        answer = station.open(trial)
        assert not answer.success
        assert why in answer.message

    def test_what_cannot_be_drawn_is_told_and_ends_nothing(self, station):
        answer = station.open("t5")
        assert not answer.success
        assert "it cannot be drawn" in answer.message
        assert not station.seek(1.0, 1.0).success
        status, body, _ = station.ask("api/trial/t5", name="ann")
        assert status == 422
        assert b"it cannot be drawn" in body
        assert station.ask("api/picture/t5", name="ann")[0] == 422
        assert station.open("t1").success
        assert station.seek(0.0, 8.0).success

    def test_there_is_no_clock(self, station):
        import rospy

        assert "/clock" not in [name for name, _ in rospy.get_published_topics()]


class TestPages:
    def test_whose_trial_it_is_sees_it(self, station):
        status, body, headers = station.ask(
            "api/picture/t1?time=2.0&azimuth=1.0&distance=3", name="ann"
        )
        assert status == 200, body
        assert body.startswith(b"\xff\xd8")
        assert float(headers["X-Replay-Time"]) == pytest.approx(2.0, abs=0.021)
        # Neither that there is one, nor that a file is damaged.
        for trial in ("t1", "broken", "t2"):
            status, body, _ = station.ask(f"api/trial/{trial}", name="bob")
            assert status == 404
            assert b"under your name" in body
        assert station.ask("api/trial/t1", role="instructor")[0] == 200
        status, body, _ = station.ask("api/trial/broken", role="instructor")
        assert status == 422
        assert b"broken.mcap" in body

    def test_another_view_makes_another_picture(self, station):
        first, second, third = (
            station.ask(f"api/picture/t1?time=2.0&azimuth={azimuth}", name="ann")[1]
            for azimuth in (1.0, 2.0, 1.0)
        )
        assert first != second
        assert first == third

    @pytest.mark.parametrize("query", ["time=nan", "time=x", "distance=0", "camera=roof"])
    def test_what_an_address_cannot_mean_is_refused(self, station, query):
        assert station.ask(f"api/picture/t1?{query}", name="ann")[0] == 400

    def test_while_a_trial_runs_only_instructors_see_it(self, station):
        try:
            station.phase("running")
            wait_until(
                lambda: station.ask("api/trial/t1", name="ann")[0] == 409, "that it is refused"
            )
            assert station.ask("api/picture/t1?time=1", role="instructor")[0] == 200
        finally:
            station.phase("ended")
        wait_until(lambda: station.ask("api/trial/t1", name="ann")[0] == 200, "that it is back")

    def test_what_failed_is_seen_wherever_one_looks(self, station):
        # Each fails for a second, two seconds apart: dark, frozen, dead, without power.
        began = Replay.open(station.folder / "t3.mcap", {}).timeline.duration - 8.0

        def seen(seconds, more="&seen=1"):
            address = f"api/picture/t3?time={began + seconds}&camera=front{more}"
            return station.ask(address, name="ann")

        def light(answer):
            assert answer[0] == 200, answer[1]
            return simplejpeg.decode_jpeg(answer[1]).mean()

        bright = light(seen(-0.5))
        for seconds, is_dark in ((0.5, True), (1.5, False), (0.6, True), (2.5, False)):
            assert (light(seen(seconds)) < 0.2 * bright) == is_dark, seconds
            assert light(seen(seconds, "")) > 0.8 * bright
        for seconds in (4.5, 6.5):
            status, body, headers = seen(seconds)
            assert (status, body) == (204, b"")
            assert "front sends nothing" in headers["X-Replay-Silent"]
            assert light(seen(seconds, "")) > 0.8 * bright
        assert light(seen(5.5)) > 0.8 * bright

    def test_it_is_night_from_when_somebody_made_it_so(self, station):
        end = Replay.open(station.folder / "t4.mcap", {}).timeline.duration
        day, night, again = (
            station.ask(f"api/picture/t4?time={time}&camera=front", name="ann")[1]
            for time in (end - 1.5, end, end - 1.5)
        )
        assert simplejpeg.decode_jpeg(night).mean() < 0.5 * simplejpeg.decode_jpeg(day).mean()
        assert again == day

    def test_other_runs_are_drawn_beside_it(self, station):
        status, body, _ = station.ask("api/ghosts/t1", name="ann")
        assert status == 200, body
        assert [each["ghost"] for each in json.loads(body)] == ["expert", "t9"]
        plain, _, ghost, expert = (
            station.ask(f"api/picture/t1?time=1.0{more}", name="ann")
            for more in ("", "&camera=front&ghost=t9", "&ghost=t9", "&ghost=expert")
        )
        assert ghost[1] != plain[1]
        assert ghost[1] == expert[1]
        assert float(ghost[2]["X-Replay-Ghost-Ahead"]) > 0.1
        assert "X-Replay-Ghost-Ahead" not in plain[2]
        # The robot's own cameras show what they showed, and what is not there is refused.
        front, beside = (
            station.ask(f"api/picture/t1?time=1.0&camera=front{more}", name="ann")[1]
            for more in ("", "&ghost=t9")
        )
        assert front == beside
        assert station.ask("api/picture/t1?ghost=t2", name="ann")[0] == 404
        assert station.ask("api/picture/t9?ghost=t1", name="bob")[0] == 404

    def test_notes_are_kept_with_the_trial(self, station):
        note = {"at": 1.0, "text": "slower", "by": "somebody else"}
        status, body, _ = station.ask("api/notes/t1", name="ann", post=note)
        assert status == 200, body
        status, body, _ = station.ask("api/notes/t1", role="instructor", post={**note, "at": 2})
        told = [each for each in json.loads(body)["marks"] if each["event"] == "moment"]
        assert [each["name"] for each in told] == ["ann", "instructor"]
        kept = Replay.open(station.folder / "t1.mcap", {}).notes
        assert [each.at for each in kept] == [1.0, 2.0]
        assert (
            json.loads(station.ask("api/trial/t1", name="ann")[1])["marks"]
            == (json.loads(body)["marks"])
        )
        # Whose it is not, and what is no note.
        assert station.ask("api/notes/t1", name="bob", post=note)[0] == 404
        for change in ({"at": 1e9}, {"at": float("nan")}, {"text": ""}):
            assert station.ask("api/notes/t1", name="ann", post={**note, **change})[0] == 400
        assert station.ask("api/notes/t1", name="ann", post=[])[0] == 400

    def test_the_page_is_there_for_every_trial(self, station):
        status, body, _ = station.ask("t1")
        assert status == 200
        assert b"replay.js" in body
