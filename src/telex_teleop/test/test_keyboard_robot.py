"""What the keyboard publishes to a robot, without ROS around it."""

from __future__ import annotations

import pytest
import rospy
from telex_msgs.msg import FlipperPresets

from telex_teleop.keyboard.commands import Commands
from telex_teleop.keyboard.robot import Robot


class Graph:
    """Stands for ROS: what was published, and who listens."""

    def __init__(self):
        self.sent = []
        self.receivers = {}

    def publisher(self, name, _kind, **_options):
        graph = self

        class Publisher:
            def publish(self, message):
                graph.sent.append((name, message))

        return Publisher()

    def subscriber(self, name, _kind, callback, **_options):
        self.receivers[name] = callback


@pytest.fixture
def graph(monkeypatch):
    graph = Graph()
    monkeypatch.setattr(rospy, "Publisher", graph.publisher)
    monkeypatch.setattr(rospy, "Subscriber", graph.subscriber)
    monkeypatch.setattr(rospy.Time, "now", rospy.Time)
    return graph


def test_a_preset_that_the_robot_lacks_is_told_and_not_sent(graph):
    robot = Robot("/r")
    presets = "/r/flipper_teleop/presets"
    graph.receivers[presets](FlipperPresets(names=["flat", "high"]))
    for name in ("somersault", "high", ""):
        robot.send(Commands(jogs={}, drive=(), preset=(name,)))
    topic = "/r/flipper_teleop/preset_cmds"
    sent = [(name, message.preset) for name, message in graph.sent]
    assert sent == [(topic, "high"), (topic, "")]
    assert robot.notice == "preset somersault: the robot has flat, high"


def test_before_the_robot_has_named_its_presets_they_are_sent(graph):
    robot = Robot("/r")
    robot.send(Commands(jogs={}, drive=(), preset=("somersault",)))
    assert [message.preset for _, message in graph.sent] == ["somersault"]
    assert robot.notice == ""
