"""Recordings as episodes: what was seen, commanded and credited."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any, List, Sequence, Tuple

import numpy as np
import pytest
from ahead_exercise import AHEAD
from std_msgs.msg import String
from telex_msgs.msg import (
    ActiveMalfunction,
    ComponentDoses,
    Malfunctions,
    SceneLight,
    TrackTeleopStatus,
)
from training_truth import serialized

from telex_sim.cameras.cameras_config import shipped_params
from telex_training.command_lines import export
from telex_training.exercises.exercise_file import load_exercise
from telex_training.judging.entries import DOSES, LIGHT, MALFUNCTIONS, Entry
from telex_training.operators.experts.brief import Brief
from telex_training.operators.handling import Hand
from telex_training.operators.port import Command, Drive, Jog
from telex_training.recording.reader import read_recording
from telex_training.recording.trial_file import CAMERAS, Trial, judged
from telex_training.recording.writer import Attachment, RecordingError, RecordingWriter
from telex_training.rehearsal.recorded import record
from telex_training.rehearsal.trial import rehearsed
from telex_training.replay.replay import Replay
from telex_training.research import data_set
from telex_training.research.command_vector import CommandVector
from telex_training.research.data_set import write_data_set
from telex_training.research.episodes import Episode, Given, episodes
from telex_training.research.redrawing import redrawn
from telex_training.ros.commands import message_of

pytestmark = pytest.mark.slow

EXERCISE = (
    AHEAD
    + """
  there: {center: [1.2, 0.0, 0.5], size: [0.4, 1.0, 1.2]}
steps: [{name: whole, until: {inside: {what: robot, zone: there}}}]
repetitions: {most: 1, time: 20}
"""
)
SPEED = 0.4


def drives(hand: Hand, brief: Brief) -> None:
    """Drive ahead, with a jog of the turret all the time, and fold the flippers at the end."""
    station = hand.station
    station.drive(SPEED)
    while station.base()[0, 3] < 0.5:
        station.port.send(Jog("arm_teleop", {"turret_joint": 0.1}))
        station.tick()
    station.hold_preset("folded")
    while True:
        station.tick()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("trials")
    path = folder / "ahead.yaml"
    path.write_text(EXERCISE)
    file = load_exercise(path)
    trial = rehearsed(file.first, drives, 7)
    about = Trial("t", str(path), file.first.setting, "practice", "ann", "test", 7)
    return record(folder / "t.mcap", about, file.text, trial)


@pytest.fixture(scope="module")
def found(recorded: Path) -> Tuple[Replay, CommandVector, List[Episode]]:
    recording = read_recording(recorded)
    replay = Replay(recording, shipped_params())
    vector = CommandVector(replay.urdf)
    return replay, vector, list(episodes(recording, replay, vector, 10.0))


def test_a_repetition_is_an_episode(
    recorded: Path, found: Tuple[Replay, CommandVector, List[Episode]]
) -> None:
    (episode,) = found[2]
    count = len(episode.moments)
    assert episode.task == "Ahead: Drive half a metre ahead."
    assert episode.success
    assert len(episode.states) == len(episode.actions) == len(episode.rewards) == count
    assert np.diff([moment.time for moment in episode.moments]) == pytest.approx(0.1, abs=0.03)
    # From 0.15 m on, where it begins, to 1.0 m; SPEED is reached.
    assert episode.states[0, 0] == pytest.approx(0.15, abs=0.06)
    assert episode.states[-1, 0] == pytest.approx(1.0, abs=0.06)
    seconds = judged(read_recording(recorded)).sheet()["repetitions"][0]["seconds"]
    assert 0.1 * count == pytest.approx(seconds, abs=0.11)
    assert episode.rewards.sum() == pytest.approx(2.0 - seconds / 20.0, abs=1e-3)


def test_actions_are_what_was_commanded(
    found: Tuple[Replay, CommandVector, List[Episode]],
) -> None:
    _, vector, (episode,) = found
    drive, turret = (vector.names.index(name) for name in ("drive.linear", "turret.rate"))
    assert episode.actions[:, drive] == pytest.approx(SPEED)
    jogged = episode.states[:, 0] < 0.45
    assert episode.actions[jogged, turret] == pytest.approx(0.1)
    # A preset is no rate: how the joints moved tells.
    led = episode.states[:, 0] > 0.65
    moved = np.clip(np.diff(episode.states, axis=0) / 0.1, -1.0, 1.0)
    flippers = [rate for rate in vector.rates if rate.part == "flippers"]
    found = episode.actions[:-1, [vector.rates.index(rate) for rate in flippers]]
    columns = [7 + vector.joints.index(rate.key) for rate in flippers]
    assert np.abs(found[led[:-1]]).max() > 0.1
    assert found[led[:-1]] == pytest.approx(moved[led[:-1]][:, columns], abs=1e-3)


def test_motion_is_measured_over_the_time_between_the_samples(
    recorded: Path, found: Tuple[Replay, CommandVector, List[Episode]]
) -> None:
    replay, vector, _ = found
    (episode,) = episodes(read_recording(recorded), replay, vector, 30.0)
    apart = np.diff([moment.time for moment in episode.moments])
    assert apart.max() > 1.5 * apart.min()  # the truth comes every 20 ms
    joint = "front_left_flipper_joint"
    moved = np.diff(episode.states[:, 7 + vector.joints.index(joint)]) / apart
    (number,) = (i for i, rate in enumerate(vector.rates) if rate.key == joint)
    led = (episode.states[:-1, 0] > 0.65) & (np.abs(moved) > 0.1)
    assert led.sum() > 10
    limited = np.clip(moved[led], -vector.most[number], vector.most[number])
    assert episode.actions[:-1, number][led] == pytest.approx(limited, rel=1e-3)


def test_moments_are_drawn_again(found: Tuple[Replay, CommandVector, List[Episode]]) -> None:
    replay, _, (episode,) = found
    moments = [episode.moments[0], episode.moments[-1]]
    first, last = (each["mast"] for each in redrawn(replay, moments, ["mast"], 64))
    assert first.shape == (48, 64, 3)
    assert first.std() > 5.0
    assert np.abs(first.astype(int) - last).mean() > 1.0


class TestWhatFailed:
    """Pictures of what an instructor, malfunctions and radiation have made of a trial."""

    def look(self, recorded: Path, told: Sequence[Tuple[float, str, Any]]) -> List[np.ndarray]:
        """Draw five moments, in the middle of which messages came at a time of the replay (s)."""
        recording = read_recording(recorded)
        entries, times = recording.entries, Replay(recording, shipped_params()).timeline.entry_times
        for time, channel, message in reversed(told):
            index = int(np.searchsorted(times, time))
            entry = Entry(0, entries[index].time, channel, message._type, serialized(message))
            entries.insert(index, entry)
        replay = Replay(recording, shipped_params())
        moments = [replay.timeline.moment(0.4 + 0.4 * i) for i in range(5)]
        return [each["front"] for each in redrawn(replay, moments, ["front"], 64)]

    def test_the_light_is_what_it_was(self, recorded: Path) -> None:
        shown = self.look(recorded, [(1.0, LIGHT, SceneLight(daylight=0.0, lamps=0.0))])
        assert shown[2].mean() < 0.5 * shown[1].mean()

    def test_a_frozen_camera_shows_what_it_saw_last(self, recorded: Path) -> None:
        frozen = ActiveMalfunction(what="front", group="camera", kind="frozen")
        shown = self.look(
            recorded,
            [
                (0.7, MALFUNCTIONS, Malfunctions(active=[frozen])),
                (1.5, MALFUNCTIONS, Malfunctions()),
            ],
        )
        assert (shown[1] == shown[2]).all()
        assert (shown[0] != shown[1]).any()
        assert np.abs(shown[3].astype(int) - shown[2]).mean() > 1.0

    def test_a_camera_without_power_leaves_its_last_picture(self, recorded: Path) -> None:
        nothing = Malfunctions(unpowered=["cameras"])
        shown = self.look(recorded, [(1.0, MALFUNCTIONS, nothing)])
        assert all((picture == shown[1]).all() for picture in shown[2:])
        shown = self.look(recorded, [(0.0, MALFUNCTIONS, nothing)])
        assert not np.any(shown)

    def test_flaws_and_radiation_are_in_its_picture(self, recorded: Path) -> None:
        sound = self.look(recorded, [])
        dark = ActiveMalfunction(what="front", group="camera", kind="dark", value=0.9)
        shown = self.look(recorded, [(1.0, MALFUNCTIONS, Malfunctions(active=[dark]))])
        assert shown[2].mean() < 0.5 * sound[2].mean()
        doses = ComponentDoses(names=["front"], dose_rate=[2000.0], dose=[0.0], failed=[False])
        shown = self.look(recorded, [(1.0, DOSES, doses)])
        assert (shown[1] == sound[1]).all()
        assert (shown[2] != sound[2]).any()


class TestGiven:
    @pytest.fixture(scope="class")
    def vector(self, found: Tuple[Replay, CommandVector, List[Episode]]) -> CommandVector:
        return found[1]

    def give(self, given: Given, command: Command, time: float) -> None:
        channel, message = message_of(command)
        given.take(Entry(1, time, channel, message._type, serialized(message)), time)

    def test_a_command_counts_until_the_watchdog_ends_it(self, vector: CommandVector) -> None:
        given = Given()
        self.give(given, Drive(0.5, -0.2), 1.0)
        assert given.at(1.2, vector)[:2] == pytest.approx([0.5, -0.2])
        assert not given.at(1.4, vector).any()

    def test_the_operators_speed_and_the_limits_count(self, vector: CommandVector) -> None:
        given = Given()
        status = TrackTeleopStatus(speed_scale=0.5)
        entry = Entry(1, 0.9, "track_teleop/status", status._type, serialized(status))
        given.take(entry, 0.9)
        self.give(given, Drive(9.0, 0.2), 1.0)
        assert given.at(1.0, vector)[:2] == pytest.approx([0.6, 0.1])

    def test_what_is_damaged_is_left_out(self, vector: CommandVector) -> None:
        given = Given()
        given.take(Entry(1, 1.0, "track_teleop/cmd_vel", "geometry_msgs/Twist", b"x"), 1.0)
        text = serialized(String(""))
        given.take(Entry(2, 1.0, "arm_teleop/named_pose_cmds", "std_msgs/String", text), 1.0)
        assert not given.at(1.0, vector).any()


def test_libraries_that_are_missing_are_named(
    recorded: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(data_set, "MISSING", "No module named 'av'")
    assert export.main(["--lerobot", str(recorded.parent / "set"), str(recorded)]) == 1
    assert "requirements-lerobot.txt" in capsys.readouterr().err


class _NoFiles:
    """Stands in for a data set, whose libraries are extras."""

    episodes = frames = 0

    def __init__(self, *_: Any) -> None:
        pass

    def add(self, episode: Episode, pictures: Any) -> None:
        self.episodes += 1

    def finish(self) -> None:
        pass

    discard = finish


def test_recordings_with_cameras_of_another_size_do_not_go_together(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data_set, "MISSING", "")
    monkeypatch.setattr(data_set, "DataSet", _NoFiles)
    params = copy.deepcopy(shipped_params())
    front = params["cameras"]["front"]
    front["height"] = front["width"] // 2
    recording = read_recording(recorded)
    cameras = Attachment("application/json", json.dumps(params).encode())
    flat = tmp_path / "flat.mcap"
    writer = RecordingWriter(flat, {**recording.attachments, CAMERAS: cameras})
    for entry in recording.entries:
        writer.put(entry, 0)
    writer.close({})

    def write(*files: Path) -> str:
        return write_data_set(tmp_path / "set", files, ["front"], 64, 10, False)

    assert "2 episodes" in write(flat, flat)
    with pytest.raises(RecordingError, match=r"flat.*'front' makes 64 x 32, 64 x 48 that of .*t\."):
        write(recorded, flat)
