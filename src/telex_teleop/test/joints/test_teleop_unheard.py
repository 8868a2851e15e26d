"""A command that nobody listens to is said to move nothing."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.ros


class Publisher:
    """Of a controller's commands."""

    def __init__(self, name, listeners):
        self.resolved_name = name
        self.listeners = listeners
        self.published = []

    def publish(self, message):
        self.published.append(message)

    def get_num_connections(self):
        return self.listeners


def test_a_controller_that_is_not_there_is_named_once_in_a_while(monkeypatch):
    import rospy

    from telex_teleop.ros.common import command

    warned = []
    monkeypatch.setattr(rospy, "logwarn", warned.append)
    lacking = Publisher("/own/wrist_position_controller/command", 0)
    there = Publisher("/own/elbow_position_controller/command", 1)
    for _ in range(50):
        command(lacking, 0.1)
        command(there, 0.2)
    assert (lacking.published, there.published) == ([0.1] * 50, [0.2] * 50)
    assert warned == [
        "nobody listens to /own/wrist_position_controller/command, so nothing moves: "
        "is its controller loaded?"
    ]
