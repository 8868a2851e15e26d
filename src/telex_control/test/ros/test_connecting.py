"""Neither an answer of the master that was overtaken nor a slow publisher hides anything."""

from __future__ import annotations

import socket
import threading

import pytest
from rospy.impl import registration
from rospy.impl.registration import RegManager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSHandler
from rospy.topics import _PublisherImpl
from std_msgs.msg import String

from telex_control.ros.rospy_fixes.connecting import miss_nothing


@pytest.fixture(autouse=True)
def patched(monkeypatch):
    monkeypatch.setattr(RegManager, "publisher_update", RegManager.publisher_update)
    handler = TCPROSHandler.topic_connection_handler
    monkeypatch.setattr(TCPROSHandler, "topic_connection_handler", handler)
    miss_nothing()


@pytest.mark.parametrize("older_answer", [[], ["http://first:1"], ["http://gone:1"]])
def test_an_overtaken_answer_hides_no_publisher(older_answer):
    manager = RegManager.__new__(RegManager)  # its initialiser would outlive the test
    manager.cond, manager.updates = threading.Condition(), []
    manager.publisher_update("/topic", ["http://first:1", "http://second:2"])
    manager.publisher_update("/other", ["http://third:3"])
    manager.publisher_update("/topic", older_answer)
    # rospy takes the last one of a topic, and drops its others.
    (last,) = (set(uris) for topic, uris in manager.updates if topic == "/topic")
    assert last == {"http://first:1", "http://second:2", *older_answer}
    assert ("/other", ["http://third:3"]) in manager.updates


class Topics:
    def __init__(self, publisher):
        self.publisher = publisher

    def get_publisher_impl(self, name):
        return self.publisher if name == "/topic" else None

    def get_publications(self):
        return ["/topic"]


@pytest.fixture
def publisher(monkeypatch):
    made = _PublisherImpl("/topic", String)
    made.set_queue_size(10)
    monkeypatch.setattr(registration, "_topic_manager", Topics(made))
    yield made
    made.close()


HEADER = {"topic": "/topic", "md5sum": String._md5sum, "callerid": "/listener", "tcp_nodelay": "1"}


def test_what_is_published_once_a_listener_is_answered_reaches_it(publisher, monkeypatch):
    write_header, publishing = TCPROSTransport.write_header, []

    def publish():
        publisher.acquire()
        try:
            publisher.publish(String("result"))
        finally:
            publisher.release()

    def write_and_be_slow(transport):
        write_header(transport)
        publishing.append(threading.Thread(target=publish))
        publishing[0].start()
        publishing[0].join(0.3)  # it ends at once where nothing holds it up

    monkeypatch.setattr(TCPROSTransport, "write_header", write_and_be_slow)
    with socket.create_server(("127.0.0.1", 0)) as server:
        listener = socket.create_connection(server.getsockname())
        own, address = server.accept()
    with listener:
        listener.settimeout(30.0)
        assert TCPROSHandler().topic_connection_handler(own, address, dict(HEADER)) is None
        publishing[0].join(30.0)
        received = b""
        while not received.endswith(b"result"):
            received += listener.recv(4096)


@pytest.mark.parametrize("topic", ["/other", None])
def test_a_listener_of_an_unknown_topic_is_refused(publisher, topic):
    header = {key: value for key, value in {**HEADER, "topic": topic}.items() if value}
    own, other = socket.socketpair()
    with own, other:
        refused = TCPROSHandler().topic_connection_handler(own, "local", header)
    assert "not a publisher" in refused if topic else "Missing required 'topic'" in refused


def test_a_listener_of_a_closed_topic_is_refused(publisher):
    publisher.close()
    own, other = socket.socketpair()
    with own, other:
        refused = TCPROSHandler().topic_connection_handler(own, "local", dict(HEADER))
    assert "Internal error" in refused
    publisher.publock = threading.RLock()  # what the fixture's close() takes
