"""A rehearsed trial of two robots: each is told, judged, recorded and drawn again."""

from __future__ import annotations

import numpy as np
import pytest

from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.operators.port import Drive
from telex_training.recording.reader import read_recording
from telex_training.recording.trial_file import Trial, judged
from telex_training.rehearsal.recorded import record
from telex_training.rehearsal.trial import rehearsed_trial
from telex_training.replay.replay import Replay

pytestmark = pytest.mark.slow

BEAM = load_exercise(find_exercise("beam"))
SEED = 7


@pytest.fixture(scope="module")
def driven():
    """A trial in which the second robot has driven for a second."""
    with rehearsed_trial(BEAM.first, SEED) as trial:
        trial.begin()
        for _ in range(25):
            trial.ports["second"].send(Drive(0.4))
            trial.advance(0.04)
        yield trial


def place(port):
    x, y, _ = port.observe().base.position
    return x, y


def test_each_robot_obeys_its_own_port(driven):
    first, second = (place(driven.ports[name]) for name in ("", "second"))
    assert first[1] > 0.8
    assert second[1] < -0.8
    assert second[0] - first[0] > 0.3


def test_the_second_robots_command_begins_the_repetition(driven):
    assert driven.judge.phase == "running"
    assert {"sim/truth", "second/sim/truth", "second/track_teleop/cmd_vel"} <= {
        entry.channel for entry in driven.entries
    }


def test_its_recording_is_judged_the_same_and_shows_both(driven, tmp_path):
    about = Trial("t1", str(BEAM.path), "standard", "practice", "script", "test", SEED)
    path = record(tmp_path / "t1.mcap", about, BEAM.text, driven)
    assert judged(read_recording(path)).text() == driven.judge.text()
    replay = Replay.open(path, {})
    moment = replay.timeline.moment(replay.timeline.duration)
    nowhere = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    frames = list(replay.scenery.description(moment, 1).frames)
    poses = np.reshape(replay.scenery.poses(moment, 1, moment.stamp, nowhere).poses, (-1, 7))
    for model, robot in (("telex", ""), ("telex_second", "second")):
        shown = poses[frames.index(f"{model}/base_link")][:2]
        assert shown == pytest.approx(place(driven.ports[robot]), abs=0.02)
