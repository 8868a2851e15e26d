"""Lets no subscriber of rospy miss a publisher, nor its first messages.

A subscriber learns of its publishers by the master's answer to its registration, and by the
updates that the master sends. An update may overtake the answer, which is older then. rospy keeps
of what it has not worked off only what has come last: the publisher that the update has named is
never connected to.

A publisher of rospy answers a subscriber and counts it among its listeners only after that. What is
published in between never reaches the subscriber, though it has seen itself connected: a client
that sends its goal at once may wait for ever for the result.
"""

from __future__ import annotations

import socket
from typing import Any, Dict, List, Optional

from rospy.impl.registration import RegManager, get_topic_manager
from rospy.impl.tcpros_pubsub import TCPROSHandler

_answer = TCPROSHandler.topic_connection_handler


def miss_nothing() -> None:
    """Let no subscriber miss a publisher, nor what is published once it is connected.

    This holds for subscribers of this process and publishers of this process; it is called before
    the node is initialised.
    """
    RegManager.publisher_update = _publisher_update
    TCPROSHandler.topic_connection_handler = _answer_and_add


def _publisher_update(self: RegManager, resolved_name: str, uris: List[str]) -> None:
    """Add publishers to those that a topic is still to be connected to.

    To one that has gone meanwhile there is no connection, which rospy takes for an answer.
    """
    with self.cond:
        waiting = [uri for name, named in self.updates if name == resolved_name for uri in named]
        self.updates = [update for update in self.updates if update[0] != resolved_name]
        self.updates.append((resolved_name, list(dict.fromkeys([*waiting, *uris]))))
        self.cond.notify_all()


def _answer_and_add(
    self: TCPROSHandler, sock: socket.socket, client_addr: Any, header: Dict[str, str]
) -> Optional[str]:
    """Publish nothing on a topic while a subscriber is answered and added to its listeners."""
    topic = get_topic_manager().get_publisher_impl(header.get("topic", ""))
    publishing = topic and topic.publock  # None once it is closed
    if not publishing:
        return _answer(self, sock, client_addr, header)
    with publishing:
        return _answer(self, sock, client_addr, header)
