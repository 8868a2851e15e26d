"""The thread that tells what there is to see."""

from __future__ import annotations

import queue

import pytest
import rospy

from telex_sim.ros import scene_publisher
from telex_sim.ros.scene_publisher import ScenePublisher


class Topic:
    """Stands for a publisher of rospy; what it is given to raise, it raises."""

    def __init__(self, *_arguments, **_options):
        self.told = queue.Queue()

    def publish(self, message):
        self.told.put(message)
        if isinstance(message, Exception):
            raise message


@pytest.fixture
def topic(monkeypatch):
    made = Topic()
    monkeypatch.setattr(scene_publisher.rospy, "Publisher", lambda *_, **__: made)
    return made


@pytest.mark.parametrize(
    "error", [OverflowError("float too large to pack"), rospy.ROSSerializationException("a field")]
)
def test_what_cannot_be_told_is_logged_and_what_comes_next_is_told(topic, caplog, error):
    descriptions = [error, "next"]
    publisher = ScenePublisher(lambda: descriptions.pop(0))
    publisher.publish_soon()
    assert topic.told.get(timeout=5.0) is error
    publisher.publish_soon()
    assert topic.told.get(timeout=5.0) == "next"
    publisher.close()
    assert str(error) in caplog.text


def test_it_ends_with_ros(topic, monkeypatch, caplog):
    monkeypatch.setattr(scene_publisher.rospy, "is_shutdown", lambda: True)
    publisher = ScenePublisher(lambda: rospy.ROSException("publish() to a closed topic"))
    publisher.publish_soon()
    topic.told.get(timeout=5.0)
    publisher.publish_soon()
    with pytest.raises(queue.Empty):
        topic.told.get(timeout=0.2)
    assert "cannot be told" not in caplog.text
