"""Connections of a rospy subscriber, which itself reports none that closes."""

from __future__ import annotations

from typing import Any, FrozenSet, Sequence

import rospy

UNNAMED = "unknown"
"""What rospy calls a publisher whose header has no name."""


def sender_of(message: Any) -> str:
    """Return the name of the node that sent a message."""
    return str(message._connection_header.get("callerid", UNNAMED))


def is_connected(subscriber: rospy.Subscriber, name: str) -> bool:
    """Whether a node of this name is among `open_publishers`; cheap enough for each cycle."""
    return any(each.callerid_pub == name for each in _connections(subscriber))


def has_answer(subscriber: rospy.Subscriber) -> bool:
    """Return whether a publisher has answered a subscriber, and will send it what it publishes.

    What rospy counts are connections from when they begin to be made.
    """
    return any(each.callerid_pub != UNNAMED for each in _connections(subscriber))


def open_publishers(subscriber: rospy.Subscriber) -> FrozenSet[str]:
    """Return the names of the nodes whose connections to a subscriber are open now.

    That of a process which ends, however it ends, closes within milliseconds; that of one which
    stands still stays open.
    """
    return frozenset(each.callerid_pub for each in _connections(subscriber))


def _connections(subscriber: rospy.Subscriber) -> Sequence[Any]:
    topic = subscriber.impl
    # None once the subscriber has ended.
    return () if topic is None else topic.connections
