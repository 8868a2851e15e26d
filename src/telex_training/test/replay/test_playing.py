"""Playing of recordings that cannot be drawn, with a drawing that the test stands in for."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest
import rospy
from replay_drill import drill, record

from telex_training.recording.writer import RecordingError
from telex_training.ros.replay import node as replay_node
from telex_training.ros.replay.node import ReplayNode
from telex_training.ros.replay.settings import ReplaySettings


class FakeDrawing:
    """Draws what it is told to, until it has a problem."""

    def __init__(self, *_settings):
        self.problem = ""
        self.placed = []
        self.on_its_way = lambda: None

    def place(self, _replay, moment):
        if self.problem:
            raise RecordingError(self.problem)
        self.on_its_way()
        self.placed.append(moment.time)


@pytest.fixture
def said():
    return []


@pytest.fixture
def node(tmp_path, monkeypatch, said):
    """The node with a recording that is open, without a master."""
    told = SimpleNamespace(publish=lambda message: None)
    monkeypatch.setattr(
        replay_node,
        "rospy",
        SimpleNamespace(
            Publisher=lambda *_, **__: told,
            Service=lambda *_: None,
            Time=rospy.Time,
            logerr=lambda form, *values: said.append(form % values),
        ),
    )
    monkeypatch.setattr(replay_node, "hear_decoded", lambda *_: None)
    monkeypatch.setattr(replay_node, "Drawing", FakeDrawing)
    monkeypatch.setattr(replay_node, "ReplayPages", lambda *_: None)
    record(tmp_path / "t1.mcap", drill().entries)
    made = ReplayNode(ReplaySettings(folder=str(tmp_path)))
    assert made._open(SimpleNamespace(trial="t1")).success
    return made


def seek(node, time, speed):
    return node._seek(SimpleNamespace(time=time, speed=speed))


def test_it_plays_from_where_it_was_sought(node):
    assert seek(node, 1.0, 2.0).success
    assert node._play(0.1)
    assert node._drawing.placed[-1] == pytest.approx(1.2, abs=0.021)


def test_what_is_played_does_not_come_after_what_is_sought(node):
    assert seek(node, 1.0, 1.0).success
    sought = threading.Thread(target=seek, args=(node, 0.5, 0.0))

    def seek_meanwhile():
        node._drawing.on_its_way = lambda: None
        sought.start()
        # Long enough for the other to overtake, if it could.
        sought.join(0.3)

    node._drawing.on_its_way = seek_meanwhile
    assert node._play(0.1)
    sought.join()
    assert node._drawing.placed[-1] == pytest.approx(0.5, abs=0.021)


def test_what_cannot_be_drawn_where_it_is_sought_does_not_play(node):
    node._drawing.problem = "t1.mcap: it cannot be drawn"
    answer = seek(node, 1.0, 1.0)
    assert (answer.success, answer.message) == (False, node._drawing.problem)
    node._drawing.problem = ""
    assert not node._play(0.1)


def test_what_cannot_be_drawn_on_the_way_stands_still_and_is_told(node, said):
    assert seek(node, 0.0, 1.0).success
    node._drawing.problem = "t1.mcap: it cannot be drawn"
    assert not node._play(0.1)
    assert said == ["replay: t1.mcap: it cannot be drawn"]
    node._drawing.problem = ""
    assert not node._play(0.1)
    assert seek(node, 0.0, 1.0).success
    assert node._play(0.1)
