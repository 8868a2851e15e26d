"""Which cameras a robot's doses are told of: those that its parameters had when they were read."""

from __future__ import annotations

import pytest

from telex_sim.ros.sensors import radiation_publisher

SCENE = "objects: [{type: source_capsule, position: [3.0, 0.0, 0.0], activity: 3.7e13}]\n"
FRONT = {"front": {"frame": "front_camera_optical_frame"}}
REAR = {"rear": {"frame": "rear_camera_optical_frame"}}


class Master:
    """Parameters and topics of rospy, as far as doses use them."""

    def __init__(self, monkeypatch):
        self.cameras = FRONT
        self.asked = 0
        self.is_gone = False
        self.told = []
        rospy = radiation_publisher.rospy
        monkeypatch.setattr(rospy, "get_param", self.get_param)
        monkeypatch.setattr(rospy, "Publisher", self.publisher)

    def get_param(self, name, default):
        self.asked += 1
        if self.is_gone:
            raise ConnectionRefusedError("nobody is there")
        return self.cameras if name.endswith("/cameras/cameras") else default

    def publisher(self, name, kind, **_):
        told = self.told if name.endswith("/cameras/radiation") else []

        class Publisher:
            def publish(self, message):
                told.append(getattr(message, "names", None))

        return Publisher()


@pytest.fixture
def hearing(monkeypatch, robot):
    """Gives the master, what publishes, and a function that resets and returns what is told."""
    from rospy import Time

    master = Master(monkeypatch)
    simulation = robot(world=SCENE).simulation
    publisher = radiation_publisher.RadiationPublisher(simulation.robots[0])

    def begin_anew():
        simulation.reset()
        publisher.publish(simulation, Time(1))
        return master.told[-1]

    return master, publisher, begin_anew


def test_the_loop_does_not_ask_for_parameters(hearing):
    master, _, begin_anew = hearing
    asked = master.asked
    assert begin_anew() == ["front"]
    assert begin_anew() == ["front"]
    assert master.asked == asked == 1


def test_what_is_read_anew_counts_from_the_next_start_on(hearing):
    master, publisher, begin_anew = hearing
    assert begin_anew() == ["front"]
    master.cameras = REAR
    publisher.find_cameras()
    assert begin_anew() == ["rear"]


def test_without_a_master_those_known_last_count(hearing, caplog):
    master, publisher, begin_anew = hearing
    master.is_gone = True
    publisher.find_cameras()
    assert begin_anew() == ["front"]
    assert "/cameras/cameras cannot be read: nobody is there" in caplog.text


def test_where_there_is_nothing_to_tell_cameras_forget_what_they_knew_before(monkeypatch, robot):
    from rospy import Time

    master = Master(monkeypatch)
    simulation = robot(world="name: calm\nobjects: []\n").simulation
    publisher = radiation_publisher.RadiationPublisher(simulation.robots[0])
    for second in range(3):
        publisher.publish(simulation, Time(second))
    assert master.told == [[]]
    simulation.change_scene(simulation.plan_scene(SCENE))
    publisher.publish(simulation, Time(3))
    assert master.told[1:] == [["front"]]
