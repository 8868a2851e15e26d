from __future__ import annotations

import threading

import pytest
import rospy
from waiting import wait_until

from telex_control.ros import publisher as ros_publisher
from telex_control.ros.publisher import RosPublisher


class FakePublisher:
    """Stands in for rospy.Publisher, which needs a master."""

    name = "/topic"

    def __init__(self, *arguments, **options):
        self.sent, self.threads = [], set()
        self.gate = threading.Event()
        self.gate.set()
        self.begun = threading.Event()

    def publish(self, message):
        self.begun.set()
        self.gate.wait(5.0)
        self.threads.add(threading.current_thread())
        if isinstance(message, Exception):
            raise message
        self.sent.append(message)

    def get_num_connections(self):
        return 1

    def unregister(self): ...


@pytest.fixture
def publisher(monkeypatch):
    monkeypatch.setattr(ros_publisher.rospy, "Publisher", FakePublisher)
    return RosPublisher("/topic", None, queue_size=3)


def test_messages_are_sent_in_order_by_another_thread(publisher):
    fake = publisher._publisher
    for number in range(3):
        publisher.publish(number)
    wait_until(lambda: fake.sent == [0, 1, 2])
    assert threading.current_thread() not in fake.threads


def test_a_sender_that_is_held_up_holds_nobody_up_and_drops_the_oldest(publisher):
    fake = publisher._publisher
    fake.gate.clear()
    publisher.publish("first")
    assert fake.begun.wait(5.0)
    for number in range(10):
        publisher.publish(number)
    fake.gate.set()
    wait_until(lambda: fake.sent == ["first", 7, 8, 9])
    publisher.publish("last")
    wait_until(lambda: fake.sent[-1] == "last")


@pytest.mark.parametrize(
    "error",
    [
        rospy.ROSException("closed"),
        rospy.ROSSerializationException("no number"),
        AttributeError("'NoneType' object has no attribute 'seq'"),
    ],
)
def test_what_cannot_be_sent_does_not_end_the_sending(publisher, error, caplog):
    publisher.publish(error)
    publisher.publish(error)
    publisher.publish("next")
    wait_until(lambda: publisher._publisher.sent == ["next"])
    complaints = caplog.text.count(f"topic /topic: a message is dropped: {error!r}")
    assert complaints == (type(error) is not rospy.ROSException)


def test_many_messages_from_many_threads_arrive(publisher):
    publisher._messages = type(publisher._messages)(maxlen=10_000)
    threads = [
        threading.Thread(target=lambda: [publisher.publish(i) for i in range(1000)])
        for _ in range(4)
    ]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    wait_until(lambda: len(publisher._publisher.sent) == 4000)
