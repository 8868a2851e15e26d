"""What the simulator hears of a robot's lamps, by their topics, without a master."""

from __future__ import annotations

import pytest
import rospy
from std_msgs.msg import Float64

from telex_sim.ros.malfunction_service import MalfunctionService

LAMPS = {
    "front_left": {"frame": "front_left_lamp_link", "level": 0.25},
    "gripper": {"frame": "gripper_lamp_link"},
}


class Nobody:
    """Stands for what a node opens."""

    def __init__(self, *_, **__):
        pass


@pytest.fixture
def heard(monkeypatch, robot):
    """Gives a robot's malfunctions, and a function that tells of a lamp."""
    callbacks = {}

    def subscribe(topic, kind, callback, callback_args):
        callbacks[topic] = lambda level: callback(Float64(level), callback_args)

    monkeypatch.setattr(rospy, "Subscriber", subscribe)
    monkeypatch.setattr(rospy, "Publisher", Nobody)
    monkeypatch.setattr(rospy, "Service", Nobody)
    params = {"/cameras/lamps": LAMPS}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: params.get(name, default))
    (body,) = robot().simulation.robots
    MalfunctionService(body, lambda change: change(), rospy.Time)
    return body.malfunctions, lambda topic, level: callbacks[f"/lamps/{topic}"](level)


def test_lamps_take_power_by_their_commands_and_by_how_they_are_switched(heard):
    malfunctions, tell = heard
    assert malfunctions.lamp_levels == 0.25
    tell("gripper/command", 0.5)
    assert malfunctions.lamp_levels == 0.75
    # Latched, to a simulator that begins after the commands.
    tell("front_left/level", 1.0)
    assert malfunctions.lamp_levels == 1.5
    tell("gripper/level", 0.0)
    assert malfunctions.lamp_levels == 1.0
