"""Who is connected to a subscriber, by names that may be missing."""

from __future__ import annotations

from types import SimpleNamespace as Namespace

from telex_control.ros.rospy_fixes.connections import (
    has_answer,
    is_connected,
    open_publishers,
    sender_of,
)


def test_a_publisher_without_a_name_is_known_as_rospy_calls_it():
    subscriber = Namespace(impl=Namespace(connections=[Namespace(callerid_pub="unknown")]))
    sender = sender_of(Namespace(_connection_header={}))
    assert is_connected(subscriber, sender)
    assert sender in open_publishers(subscriber)
    assert not is_connected(Namespace(impl=None), sender)


def test_a_publisher_has_answered_once_its_name_is_known():
    connection = Namespace(callerid_pub="unknown")
    subscriber = Namespace(impl=Namespace(connections=[connection]))
    assert not has_answer(subscriber)
    connection.callerid_pub = "/cameras"
    assert has_answer(subscriber)
    assert not has_answer(Namespace(impl=None))
