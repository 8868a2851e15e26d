"""Who is connected to a subscriber of rospy, which tells nobody when a connection closes."""

from __future__ import annotations

from typing import FrozenSet

import rospy


def open_publishers(subscriber: rospy.Subscriber) -> FrozenSet[str]:
    """Return the names of the nodes whose connections to a subscriber are open now.

    That of a process which ends, however it ends, closes within milliseconds; that of one which
    stands still stays open.
    """
    topic = subscriber.impl
    # None once the subscriber has ended.
    connections = () if topic is None else topic.connections
    return frozenset(each.callerid_pub for each in connections)
