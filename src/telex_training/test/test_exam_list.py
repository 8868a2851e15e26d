"""The list that holds during an exam, as the training node asks the bridge for it."""

from __future__ import annotations

import threading
from functools import partial
from types import SimpleNamespace

import pytest
from std_msgs.msg import String
from waiting import wait_until

from telex_training.ros.exam import exam_list
from telex_training.ros.exam.exam_list import ExamList, ExamListError


class Bridge:
    """Plays rospy and, while it is there, the bridge."""

    def __init__(self):
        self.params = {"rosbridge/instructor_token_file": "/teacher.token"}
        self.there = True
        self.deaf = None
        self.says = {}
        self.said = []
        self.Publisher, self.Subscriber = self.publisher, self.subscriber

    def get_param(self, name, default):
        return self.params.get(name, default)

    def resolve_name(self, name):
        return f"/telex/{name}"

    def publisher(self, topic, kind, queue_size, latch):
        robot, name, rest = topic.partition("training/exam")
        assert (name, rest, kind, latch) == ("training/exam", "", String, True)
        return SimpleNamespace(publish=partial(self.hear, robot))

    def subscriber(self, topic, kind, callback, **_):
        robot, name, rest = topic.partition("bridge/exam")
        assert (name, rest, kind) == ("bridge/exam", "", String)
        self.says[robot] = callback

    def say(self, message, robot=""):
        self.says[robot](message)

    def hear(self, robot, message):
        if not robot:
            self.said.append(message.data)
        if self.there and robot in self.says and robot != self.deaf:
            # As from the thread of a connection: whoever publishes may hold a lock.
            threading.Thread(target=self.say, args=(message, robot)).start()


@pytest.fixture
def bridge(monkeypatch):
    played = Bridge()
    monkeypatch.setattr(exam_list, "rospy", played)
    return played


@pytest.fixture
def lifted():
    return []


@pytest.fixture
def listed(bridge, lifted):
    return ExamList("rosbridge", lambda: lifted.append(True), within=5.0)


def test_without_a_token_it_says_what_to_do(bridge, listed):
    bridge.params.clear()
    with pytest.raises(ExamListError, match=r"run\.sh instructor_token_file:=~/teacher\.token"):
        listed.take("t1")
    assert bridge.said == [""]


def test_it_holds_until_it_is_let_go(bridge, listed, lifted):
    assert bridge.said == [""]  # of a node that comes anew
    listed.take("t1")
    assert listed.trial == "t1"
    assert listed.holds("t1")
    assert not listed.holds("t0")
    listed.release("t0")
    assert listed.holds("t1")
    listed.release("t1")
    assert listed.trial == ""
    assert bridge.said == ["", "t1", ""]
    wait_until(lambda: not listed._open())
    assert lifted == []


def test_a_bridge_that_does_not_answer_makes_no_exam(bridge, lifted):
    bridge.there = False
    listed = ExamList("rosbridge", lambda: lifted.append(True), within=0.05)
    with pytest.raises(ExamListError, match=r"within 0\.05 s; is it running \(/telex/rosbridge\)"):
        listed.take("t1")
    assert bridge.said == ["", "t1", ""]
    assert lifted == []


def test_who_ends_it_is_noticed_once_and_a_bridge_that_starts_anew_is_none(bridge, listed, lifted):
    listed.take("t1")
    bridge.say(String("t1"))
    assert lifted == []
    assert listed.holds("t1")
    bridge.say(String(""))
    assert not listed.holds("t1")
    bridge.say(String(""))
    assert lifted == [True]


def test_it_holds_at_the_bridge_of_each_robot_or_at_none(bridge, lifted, monkeypatch):
    bridge.params["/telex_b/rosbridge/instructor_token_file"] = "/teacher.token"
    made = partial(ExamList, "rosbridge", lambda: lifted.append(True), others=["/telex_b"])
    listed = made(within=5.0)
    listed.take("t1")
    bridge.say(String(""), "/telex_b/")
    assert lifted == [True]
    bridge.deaf = "/telex_b/"
    bridge.says.clear()  # of the node before
    listed = made(within=0.05)
    wait_for = listed._lock.wait_for

    def until_the_other_has_answered(answered, within):
        """The time is over then, and not before."""
        assert wait_for(lambda: listed._open() == ["/telex_b/"], 60.0)
        return answered()

    monkeypatch.setattr(listed._lock, "wait_for", until_the_other_has_answered)
    with pytest.raises(ExamListError, match=r"is it running \(/telex//telex_b/rosbridge\)"):
        listed.take("t2")
    assert bridge.said[-2:] == ["t2", ""]


def test_every_bridge_needs_the_instructors_token(bridge):
    listed = ExamList("rosbridge", lambda: None, others=["/telex_b"])
    with pytest.raises(ExamListError, match="an exam needs an instructor's token"):
        listed.take("t1")
