"""A recording opened again: poses as the simulator had them, and what happened when."""

from __future__ import annotations

import json
import math

import numpy as np
import pybullet
import pytest
from genpy import Time
from replay_drill import CAMERAS, active, drill, failing, record
from std_msgs.msg import Float64, String
from telex_msgs.msg import ComponentDoses, Malfunctions, SceneLight, TruthContact, TruthSample
from training_truth import GROUPS, serialized

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.truth.messages import names_message, sample_message
from telex_sim.truth.sampler import TruthSampler
from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.exercises.seeds import scene_text
from telex_training.judging.entries import Entry
from telex_training.judging.moments import MomentNote
from telex_training.recording.amending import amend
from telex_training.recording.reader import read_recording
from telex_training.recording.trial_file import Trial as About
from telex_training.recording.trial_file import attachments, judged, sheet_attachment
from telex_training.recording.writer import Attachment, RecordingError, RecordingWriter
from telex_training.replay.cameras import CLEAR, OUTSIDE, replay_config
from telex_training.replay.replay import Replay, SilentCameraError
from telex_training.replay.scenery import base_of


@pytest.fixture
def replay(tmp_path):
    return Replay.open(record(tmp_path / "t1.mcap", drill().entries), {})


def with_contact_of_nothing(data):
    """A truth sample in which the tracks touch what has no name."""
    message = TruthSample().deserialize(data)
    message.contacts = [TruthContact(group=GROUPS.index("tracks"), object=32767, peak=1.0, steps=1)]
    return serialized(message)


def with_time_of_no_clock(data):
    """A truth sample of a time that ROS does not have."""
    return data[:4] + b"\xff" * 8 + data[12:]


class TestPoses:
    @pytest.fixture(scope="class")
    def simulated(self, tmp_path_factory):
        """Samples of a door that swings, and the simulator's own poses at each of them."""
        folder = tmp_path_factory.mktemp("door")
        made = load_exercise(find_exercise("door"))
        setting = made.first
        text = scene_text(setting, 7)
        scene = folder / "scene.yaml"
        scene.write_text(text)
        urdf = robot_description()
        offline = OfflineSimulation(urdf, world=str(scene))
        simulation = offline.simulation
        sampler = TruthSampler(simulation, simulation.robots[0])
        entries, poses = [], []

        def put(channel, message):
            number = len(entries) + 1
            data = serialized(message)
            entries.append(Entry(number, simulation.time, channel, message._type, data))

        put("sim/truth_names", names_message(sampler.names, 1))
        hinges = simulation.objects.joints()
        assert hinges
        names = [f"{sampler.names.robot}/{name}" for name in simulation.robots[0].body.link_names()]
        names += simulation.objects.frames()
        for number in range(20):
            for hinge in hinges:
                pybullet.resetJointState(
                    hinge.uid, hinge.joint, 0.02 * number, physicsClientId=simulation.world.client
                )
            for _ in range(10):
                simulation.step()
            sample = sample_message(sampler.sample())
            sample.sequence, sample.revision = number + 1, 1
            sample.header.stamp = Time.from_sec(simulation.time)
            put("sim/truth", sample)
            poses.append(dict(zip(names, np.reshape(simulation.link_poses(), (-1, 7)))))
        simulation.close()
        about = About("d", str(made.path), setting.setting, "practice", "ann", "test", 7)
        path = folder / "d.mcap"
        writer = RecordingWriter(path, attachments(about, made.text, text, urdf, {}, {}))
        for entry in entries:
            writer.put(entry, 0)
        writer.close({})
        return Replay.open(path, CAMERAS), poses

    def test_every_link_is_where_the_simulator_had_it(self, simulated):
        replay, poses = simulated
        for number in (0, 7, 19):
            moment = replay.timeline.at(number)
            frames = replay.scenery.description(moment, 1).frames
            message = replay.scenery.poses(moment, 1, moment.stamp, base_of(moment))
            found = dict(zip(frames, pose_matrices(np.reshape(message.poses, (-1, 7)))))
            assert set(poses[number]) <= set(found)
            for name, pose in poses[number].items():
                wanted = pose_matrices(pose[None])[0]
                assert np.abs(found[name] - wanted).max() < 1e-5, name

    def test_the_door_moves(self, simulated):
        replay, _ = simulated
        first, last = (replay.timeline.at(number) for number in (0, 19))
        a, b = (
            np.reshape(replay.scenery.poses(each, 1, 0, base_of(each)).poses, (-1, 7))
            for each in (first, last)
        )
        frames = replay.scenery.description(first, 1).frames
        swung = [
            name
            for name, before, after in zip(frames, a, b)
            if "/" in name and not name.startswith("telex/") and np.abs(before - after).max() > 0.05
        ]
        assert swung

    def test_shipped_cameras_stand_in(self, simulated):
        replay, _ = simulated
        assert replay.camera_names == ["front", "turret"]
        assert any("says nothing about the cameras" in each for each in replay.problems)


class TestTime:
    def test_a_time_finds_the_last_sample_before_it(self, replay):
        timeline = replay.timeline
        assert timeline.moment(0.0).number == 0
        assert timeline.moment(-5.0).number == 0
        assert timeline.moment(1e9).number == len(timeline.times) - 1
        assert timeline.moment(float(timeline.times[40])).number == 40
        assert timeline.moment(float(timeline.times[40]) + 0.019).number == 40
        assert timeline.moment(float(timeline.times[40]) - 0.001).number == 39

    @pytest.mark.parametrize("time", [float("nan"), float("inf")])
    def test_what_is_not_finite_is_refused(self, replay, time):
        with pytest.raises(ValueError, match="finite"):
            replay.timeline.moment(time)

    def test_stamps_are_those_that_were_recorded(self, replay):
        assert replay.timeline.stamps[0] == pytest.approx(10_020_000_000, abs=1000)
        assert replay.timeline.at(1).stamp == pytest.approx(10_040_000_000, abs=1000)

    def test_time_goes_on_where_the_simulator_began_anew(self, tmp_path):
        trial = drill()
        before = len(trial.entries)
        trial.time = 0.0
        trial.sample(10)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        times = replay.timeline.times
        assert (np.diff(times) >= 0.0).all()
        assert replay.timeline.at(len(times) - 1).stamp == 200_000_000
        assert before < len(trial.entries)

    def test_names_that_change_begin_another_part(self, tmp_path):
        trial = drill()
        trial.revision = 2
        trial.names()
        trial.sample(3)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        assert len(replay.timeline.parts) == 2
        last = replay.timeline.at(10**6)
        assert (last.part, last.row) == (replay.timeline.parts[1], 2)


class TestWhatHappened:
    def test_marks_are_the_judges_events(self, replay):
        marks = replay.marks()
        kinds = [mark["kind"] for mark in marks]
        assert kinds.index("begin") < kinds.index("step") < kinds.index("end")
        step = next(mark for mark in marks if mark["event"] == "step")
        assert step["name"] == "drive"
        moment = replay.timeline.moment(step["time"])
        assert moment.part.base[moment.row][0] == pytest.approx(1.0, abs=0.03)

    def test_the_sheet_that_it_ends_with_is_believed(self, tmp_path):
        trial = drill()
        ending = {"sheet.json": sheet_attachment(trial.judge.text())}
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries, ending=ending), {})
        again = Replay.open(record(tmp_path / "t2.mcap", trial.entries), {})
        assert replay.marks() == again.marks()

    @pytest.mark.parametrize(
        "odd",
        [
            {"events": [7]},
            {"events": [{"event": ["begin"], "time": 1.0}]},
            {"events": [], "real_time_factor": 1.0},
            {"events": [], "real_time_factor": {"slow": [3.0]}},
        ],
    )
    def test_what_the_judge_would_not_write_is_judged_anew(self, tmp_path, odd):
        trial = drill()
        ending = {"sheet.json": sheet_attachment(json.dumps(odd))}
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries, ending=ending), {})
        again = Replay.open(record(tmp_path / "t2.mcap", trial.entries), {})
        assert replay.marks() == again.marks()
        assert replay.stretches() == again.stretches()

    @pytest.mark.parametrize("time", [math.nan, -math.inf, 10**400])
    def test_an_event_at_no_time_is_no_mark(self, tmp_path, time):
        events = [
            {"event": "begin", "time": time},
            {"event": "note", "time": 1.0, "detail": {"at": time}},
        ]
        ending = {"sheet.json": sheet_attachment(json.dumps({"events": events}))}
        replay = Replay.open(record(tmp_path / "t1.mcap", drill().entries, ending=ending), {})
        (mark,) = replay.marks()
        assert mark["event"] == "note"
        assert math.isfinite(mark["time"])

    def test_notes_at_moments_stand_among_them(self, tmp_path):
        ending = {"sheet.json": sheet_attachment(drill().judge.text())}
        path = record(tmp_path / "t1.mcap", drill().entries, ending=ending)
        before = read_recording(path)
        notes = [MomentNote(1.0, "slower", "ann", False), MomentNote(2.0, "good", "", True)]
        assert amend(path, [note.content() for note in notes], 1) == drill().judge.text()
        after = read_recording(path)
        assert after.attachments == before.attachments
        assert after.entries[: len(before.entries)] == before.entries
        assert judged(after).text() == judged(before).text()
        replay = Replay.open(path, {})
        assert replay.notes == notes
        marks = [mark for mark in replay.marks() if mark["event"] == "moment"]
        assert [(mark["time"], mark["name"]) for mark in marks] == [
            (1.0, "ann"),
            (2.0, "instructor"),
        ]
        assert marks[0]["detail"]["text"] == "slower"

    def test_a_recording_with_a_gap_is_told_of_and_shown(self, tmp_path):
        entries = drill().entries
        replay = Replay.open(record(tmp_path / "t1.mcap", [*entries[:200], *entries[201:]]), {})
        told = [mark["event"] for mark in replay.about()["marks"]]
        assert "invalid" in told

    def test_strips_show_speed_and_force(self, replay):
        strips = {strip["name"]: strip for strip in replay.strips()}
        assert max(x for x in strips["speed"]["high"] if x is not None) == pytest.approx(0.5)
        # Tracks always press on the floor.
        assert max(x for x in strips["force"]["high"] if x is not None) == pytest.approx(250.0)
        assert strips["picture age"]["high"] == [None]

    def test_keys_are_held_while_commands_come(self, replay):
        (span,) = replay.about()["keys"]["track_teleop"]
        assert span[1] - span[0] == pytest.approx(4.0, abs=0.4)

    def test_stops_and_ages_are_told(self, tmp_path):
        trial = drill()
        trial.status(e_stop=True)
        trial.sample(50)
        trial.status(e_stop=False)
        text = json.dumps({"view": "front", "picture_age": 0.4, "released": "focus lost"})
        trial.feed("console/telemetry", "std_msgs/String", serialized(String(text)))
        trial.sample(50)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        (stopped,) = [each for each in replay.stretches() if each["kind"] == "stopped"]
        assert stopped["end"] - stopped["begin"] == pytest.approx(1.0, abs=0.03)
        assert [m["name"] for m in replay.marks() if m["event"] == "released"] == ["focus lost"]
        end = replay.timeline.duration
        assert replay.seen_at(end) == pytest.approx(end - 0.4)
        assert replay.seen_at(0.1) == 0.1

    def test_about_is_plain_data(self, replay):
        text = json.dumps(replay.about(), allow_nan=False)
        assert json.loads(text)["operator"] == "ann"


class TestCameras:
    @pytest.mark.parametrize(
        ("lamp", "zoom"),
        [
            ("lamps/front_left/level", "cameras/turret/zoom_factor"),
            ("lamps/front_left/command", "cameras/turret/zoom"),  # as it was recorded before
        ],
    )
    def test_lamps_and_zoom_are_as_they_were(self, tmp_path, lamp, zoom):
        trial = drill()
        for channel, value in ((lamp, 1.0), (zoom, 3.0)):
            trial.feed(channel, "std_msgs/Float64", serialized(Float64(value)))
        trial.sample(5)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        timeline = replay.timeline
        before = {"lamps/front_left/command": 0.5, "cameras/turret/zoom": 1.0}
        after = {"lamps/front_left/command": 1.0, "cameras/turret/zoom": 3.0}
        assert replay.switches(timeline.at(0)) == before
        assert replay.switches(timeline.moment(timeline.duration)) == after

    def test_each_camera_is_there_as_it_was_and_clear(self):
        config = replay_config(CAMERAS, "telex", 19)
        assert set(config["cameras"]) >= {OUTSIDE, "front", f"front{CLEAR}"}
        assert config["cameras"]["front"]["noise"] == 2.0
        assert config["cameras"][f"front{CLEAR}"]["noise"] == 0.0
        assert "zoom_max" not in config["cameras"][f"turret{CLEAR}"]
        assert "overview" not in config

    def test_only_cameras_that_the_robot_has_are_offered(self, replay):
        assert replay.camera_names == ["front"]


class TestLight:
    def test_it_is_as_the_instructor_had_set_it(self, tmp_path):
        trial = drill()
        for light in ((0.02, 1.0), (float("nan"), 1.0), (1.0, 2.0)):
            trial.feed("sim/light", "telex_msgs/SceneLight", serialized(SceneLight(*light)))
            trial.sample(5)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        timeline = replay.timeline
        assert timeline.bad == 2
        day, dark = (
            replay.scenery.description(moment, 1, None, replay.light(moment))
            for moment in (timeline.at(0), timeline.moment(timeline.duration))
        )
        assert dark.ambient == pytest.approx(0.02 * day.ambient)
        assert dark.sun.r == pytest.approx(0.02 * day.sun.r)


class TestWhatFailed:
    @pytest.fixture
    def failed(self, tmp_path):
        trial = drill()
        before = len(trial.entries)
        failing(trial)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        replay.begins = replay.timeline.entry_times[before]
        return replay

    @staticmethod
    def at(replay, seconds):
        """Moment so long after the first thing failed."""
        return replay.timeline.moment(replay.begins + seconds)

    def test_flaws_are_there_while_they_were(self, failed):
        for seconds, kinds in ((-0.5, []), (0.5, ["dark"]), (1.5, []), (0.6, ["dark"])):
            found = failed.condition(self.at(failed, seconds)).malfunctions.active
            assert [each.kind for each in found] == kinds

    def test_a_frozen_camera_shows_when_it_froze(self, failed):
        first, late = (self.at(failed, seconds) for seconds in (2.1, 2.9))
        for moment in (late, first):
            frozen = failed.sent_by("front", moment)
            assert frozen.time == pytest.approx(failed.begins + 2.0, abs=0.021)
            assert not failed.condition(frozen).malfunctions.active
        after = self.at(failed, 3.1)
        assert failed.sent_by("front", after) == after
        assert failed.sent_by("turret", late) == late

    def test_doses_are_those_of_the_moment(self, failed):
        before, after = (
            failed.condition(self.at(failed, seconds)).radiation for seconds in (1.0, 4.5)
        )
        assert (before.names, before.dose_rate, before.dose) == (["front"], [0.0], [0.0])
        assert (after.names, after.dose_rate, after.dose) == (["front"], [2.0], [90.0])

    @pytest.mark.parametrize(("seconds", "why"), [(4.5, "dose"), (6.5, "battery")])
    def test_a_dead_camera_sends_nothing(self, failed, seconds, why):
        with pytest.raises(SilentCameraError, match=f"front.*{why}"):
            failed.sent_by("front", self.at(failed, seconds))
        back = self.at(failed, seconds - 1.0)
        assert failed.sent_by("front", back) == back

    def test_without_power_the_views_from_outside_go_on(self, failed):
        condition = failed.condition(self.at(failed, 6.5))
        assert condition.malfunctions.unpowered == ["drives", "lamps"]
        assert condition.radiation.failed == [True]
        assert [each.what for each in condition.malfunctions.active] == ["front_left"]

    def test_what_makes_no_sense_is_left_out(self, tmp_path):
        trial = drill()
        dark = active("front", "camera", "dark", float("nan"))
        for kind, message in (
            ("telex_msgs/Malfunctions", Malfunctions(active=[dark])),
            ("telex_msgs/ComponentDoses", ComponentDoses(names=["front"], dose=[1.0])),
            (
                "telex_msgs/ComponentDoses",
                ComponentDoses(
                    names=["front"], dose_rate=[float("inf")], dose=[1.0], failed=[False]
                ),
            ),
        ):
            channel = "sim/doses" if "Doses" in kind else "sim/malfunctions"
            trial.feed(channel, kind, serialized(message))
        trial.sample(5)
        replay = Replay.open(record(tmp_path / "t1.mcap", trial.entries), {})
        assert replay.timeline.bad == 3
        condition = replay.condition(replay.timeline.at(10**6))
        assert not condition.malfunctions.active
        assert not condition.radiation.names


class TestWhatIsNotAsItWas:
    def test_cameras_of_other_software_give_way_to_this_machines(self, tmp_path):
        changes = {"cameras.json": Attachment("text/json", b'{"cameras": {"a": {"lens": 1}}}')}
        path = record(tmp_path / "t1.mcap", drill().entries, changes)
        replay = Replay.open(path, CAMERAS)
        assert replay.camera_names == ["front"]
        assert any("lens" in each for each in replay.problems)

    def test_software_and_meshes_are_compared(self, replay):
        assert replay.compare("test", {"package://a/b.obj": "1234"}) == []
        software, meshes = replay.compare("other", {"package://a/b.obj": "5678"})
        assert "test" in software
        assert "other" in software
        assert "package://a/b.obj" in meshes

    def test_a_scene_that_cannot_be_read_leaves_the_robot(self, tmp_path):
        changes = {"scene.yaml": Attachment("text/yaml", b"objects: [{type: gone, name: a}]")}
        ending = {"sheet.json": sheet_attachment(drill().judge.text())}
        path = record(tmp_path / "t1.mcap", drill().entries, changes, ending)
        replay = Replay.open(path, {})
        assert any("robot is shown alone" in each for each in replay.problems)
        moment = replay.timeline.at(0)
        frames = replay.scenery.description(moment, 1).frames
        poses = replay.scenery.poses(moment, 1, 0, base_of(moment)).poses
        assert len(poses) == 7 * len(frames)

    def test_objects_that_came_later_are_named(self, tmp_path):
        scene = "objects: [{type: cube, name: cube, position: [2.0, 0.0, 0.0]}]"
        changes = {"scene.yaml": Attachment("text/yaml", scene.encode())}
        replay = Replay.open(record(tmp_path / "t1.mcap", drill().entries, changes), {})
        assert any("door, plug, wall" in each for each in replay.problems)

    def test_a_file_that_was_cut_off_is_shown_as_far_as_it_goes(self, tmp_path):
        path = record(tmp_path / "t1.mcap", drill().entries)
        data = path.read_bytes()
        path.write_bytes(data[: len(data) * 2 // 3])
        replay = Replay.open(path, {})
        assert any("cut off" in each for each in replay.problems)

    @pytest.mark.parametrize("content", [b"", b"no recording at all", b"\x89MCAP0\r\n"])
    def test_what_is_no_recording_is_refused(self, tmp_path, content):
        path = tmp_path / "t1.mcap"
        path.write_bytes(content)
        with pytest.raises(RecordingError, match=r"t1\.mcap"):
            Replay.open(path, {})

    def test_a_recording_without_truth_is_refused(self, tmp_path):
        path = record(tmp_path / "t1.mcap", [])
        with pytest.raises(RecordingError, match="no truth"):
            Replay.open(path, {})

    @pytest.mark.parametrize("name", ["robot.urdf", "cameras.json", "trial.json"])
    def test_a_damaged_attachment_is_named(self, tmp_path, name):
        changes = {name: Attachment("text/plain", b"\xff{")}
        path = record(tmp_path / "t1.mcap", drill().entries, changes)
        with pytest.raises(RecordingError, match=name.split(".")[0] + "|UTF-8|JSON"):
            Replay.open(path, {})

    @pytest.mark.parametrize("name", ["cameras.json", "meshes.json", "sheet.json"])
    def test_an_attachment_that_is_too_deep_is_refused(self, tmp_path, name):
        changes = {name: Attachment("text/json", b"[" * 100_000)}
        path = record(tmp_path / "t1.mcap", drill().entries, changes)
        with pytest.raises(RecordingError, match=r"t1\.mcap: it cannot be shown"):
            Replay.open(path, {})

    @pytest.mark.parametrize(
        "change",
        [lambda data: b"short", with_contact_of_nothing, with_time_of_no_clock],
        ids=["cut off", "object without a name", "time"],
    )
    @pytest.mark.parametrize("at", [0, -1])
    def test_a_sample_that_makes_no_sense_is_left_out(self, tmp_path, change, at):
        trial = drill()
        count = sum(entry.channel == "sim/truth" for entry in trial.entries)
        made = list(trial.entries)
        bad = [i for i, entry in enumerate(made) if entry.channel == "sim/truth"][at]
        made[bad] = made[bad]._replace(data=change(made[bad].data))
        replay = Replay.open(record(tmp_path / "t1.mcap", made), {})
        timeline = replay.timeline
        assert len(timeline.times) == count - 1
        assert len(timeline.speed) == len(timeline.stamps) == count - 1
        moment = timeline.at(count)
        assert moment.row == len(moment.part) - 1
        assert base_of(moment)
        assert any("1 entries" in each for each in replay.problems)
