"""Another run beside a trial: aligned at begin, steps and end, and drawn where it was."""

from __future__ import annotations

import numpy as np
import pytest
from replay_drill import TEXT, drill, faster, record, record_faster
from training_truth import SCENE, Trial, exercise

from telex_training.recording.writer import Attachment
from telex_training.replay.ghost import NAME, Ghost, GhostError, Span, anchors, spans
from telex_training.replay.replay import Replay
from telex_training.replay.scenery import base_of


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A trial, and a run that was faster."""
    folder = tmp_path_factory.mktemp("runs")
    return (
        Replay.open(record(folder / "t1.mcap", drill().entries), {}),
        Replay.open(record_faster(folder / "t2.mcap"), {}),
    )


def time_of(replay, event):
    return next(mark["time"] for mark in replay.marks() if mark["event"] == event)


class TestAligned:
    @pytest.mark.parametrize("event", ["begin", "step"])
    def test_begins_and_ends_of_steps_coincide(self, runs, event):
        trial, other = runs
        ghost = Ghost(trial, other)
        assert ghost.time(time_of(trial, event)) == pytest.approx(time_of(other, event), abs=0.021)

    def test_between_steps_its_time_runs_evenly(self, runs):
        trial, other = runs
        middle = 0.5 * (time_of(trial, "begin") + time_of(trial, "step"))
        expected = 0.5 * (time_of(other, "begin") + time_of(other, "step"))
        ghost = Ghost(trial, other)
        assert ghost.time(middle) == pytest.approx(expected, abs=0.021)
        # Both drive evenly: at half of the time, both have half of the way.
        (x, _, _), _ = ghost.poses(middle)[0]
        row = base_of(trial.timeline.moment(middle))
        assert x == pytest.approx(row[0][0], abs=0.03)
        assert ghost.ahead(middle) == pytest.approx(
            middle - time_of(trial, "begin") - (expected - time_of(other, "begin")), abs=0.03
        )
        assert ghost.ahead(middle) > 0.3

    def test_before_the_begin_both_begins_coincide(self, runs):
        trial, other = runs
        ghost = Ghost(trial, other)
        begin, there = time_of(trial, "begin"), time_of(other, "begin")
        assert ghost.time(begin - 0.2) == pytest.approx(there - 0.2, abs=0.001)
        assert Ghost(other, trial).time(0.0) == 0.0
        assert ghost.ahead(begin - 0.2) == 0.0

    def test_after_the_end_it_stands(self, runs):
        trial, other = runs
        ghost = Ghost(trial, other)
        assert ghost.time(trial.timeline.duration) == pytest.approx(
            time_of(other, "step"), abs=0.03
        )

    def test_each_repetition_has_its_own_alignment(self):
        marks = [
            {"event": event, "name": name, "time": time}
            for event, name, time in (
                ("begin", "", 2.0),
                ("step", "a", 4.0),
                ("repetition", "tipped over", 5.0),
                ("begin", "", 8.0),
                ("step", "a", 9.0),
                ("repetition", "passed", 12.0),
                ("begin", "", 15.0),
                ("moment", "ann", 16.0),
            )
        ]
        assert spans(marks, 20.0) == [
            Span(0.0, 2.0, (("a", 4.0),), 5.0, False),
            Span(5.0, 8.0, (("a", 9.0),), 12.0, True),
            Span(12.0, 15.0, (), 20.0, False),
        ]

    def test_only_what_both_did_in_one_order_is_aligned(self):
        mine = Span(0.0, 1.0, (("a", 3.0), ("b", 5.0), ("c", 6.0)), 9.0, True)
        other = Span(0.0, 2.0, (("a", 4.0), ("c", 5.0), ("b", 6.0)), 8.0, True)
        assert anchors(mine, other) == ([1.0, 3.0, 5.0, 9.0], [2.0, 4.0, 6.0, 8.0])
        left = Span(0.0, 1.0, (), 4.0, False)
        assert anchors(left, other) == ([1.0], [2.0])


class TestDrawn:
    def test_its_robot_is_translucent_and_stands_before_the_objects(self, runs):
        trial, other = runs
        ghost, moment = Ghost(trial, other), trial.timeline.moment(2.0)
        plain = trial.scenery.description(moment, 1)
        description = trial.scenery.description(moment, 1, ghost.robot)
        added = [name for name in description.frames if name.startswith(f"{NAME}/")]
        assert len(description.frames) == len(plain.frames) + len(added)
        (shown,) = [v for v in description.visuals if description.frames[v.frame] in added]
        assert 0.1 < shown.color.a < 0.6
        outside = base_of(moment)
        message = trial.scenery.poses(moment, 1, 0, outside, ghost.poses(moment.time))
        poses = dict(zip(description.frames, np.reshape(message.poses, (-1, 7))))
        before = dict(
            zip(plain.frames, np.reshape(trial.scenery.poses(moment, 1, 0, outside).poses, (-1, 7)))
        )
        for name, pose in before.items():
            assert poses[name] == pytest.approx(pose)
        expected = base_of(other.timeline.moment(ghost.time(moment.time)))
        assert poses[f"{NAME}/base_link"][:3] == pytest.approx(expected[0])
        assert all(position[2] < -100.0 for position, _ in ghost.away())

    def test_another_exercise_is_refused(self, runs, tmp_path):
        trial, _ = runs
        text = TEXT.replace("name: drill", "name: other")
        changes = {"exercise.yaml": Attachment("text/yaml", f"{text}\nscene: {{}}".encode())}
        other = Replay.open(record(tmp_path / "t3.mcap", faster().entries, changes), {})
        with pytest.raises(GhostError, match="'other'; 'drill' is needed"):
            Ghost(trial, other)

    def test_a_run_that_was_not_completed_is_refused(self, runs, tmp_path):
        trial, _ = runs
        begun = Trial(exercise(TEXT), scene=SCENE).begin()
        begun.drive(0.5)
        other = Replay.open(record(tmp_path / "t3.mcap", begun.entries), {})
        with pytest.raises(GhostError, match="completed"):
            Ghost(trial, other)
        # Where the trial's own never began, the other stands at its start.
        assert Ghost(other, trial).time(0.0) <= time_of(trial, "begin")
