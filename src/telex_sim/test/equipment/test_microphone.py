"""What a robot's microphone tells of the ground."""

from __future__ import annotations

import pytest

from telex_sim.ros.sensors import microphone_publisher


@pytest.fixture
def said(monkeypatch):
    said = []

    class Publisher:
        def __init__(self, name, kind, queue_size, latch):
            assert latch
            self._name = name

        def publish(self, surface):
            said.append((self._name, surface))

        def unregister(self):
            said.append((self._name, None))

    monkeypatch.setattr(microphone_publisher.rospy, "Publisher", Publisher)
    return said


def test_it_says_once_what_the_belts_run_on(said, robot):
    simulation = robot().simulation
    hearing = simulation.robots[0]
    microphone = microphone_publisher.MicrophonePublisher(hearing)
    for _ in range(100):
        simulation.step()
        microphone.publish()
    microphone.close()
    topic = f"{hearing.namespace}/microphone/surface"
    # None yet before the first step.
    assert [surface for _, surface in said if surface] == ["concrete"]
    assert said[-1] == (topic, None)


def test_a_robot_without_one_says_nothing(said, robot):
    simulation = robot().simulation
    hearing = simulation.robots[0]
    hearing.equipment = ()
    microphone = microphone_publisher.MicrophonePublisher(hearing)
    simulation.step()
    microphone.publish()
    microphone.close()
    assert said == []
