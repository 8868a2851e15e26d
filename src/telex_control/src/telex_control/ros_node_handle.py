"""`NodeHandle` on rospy."""

from __future__ import annotations

import logging
from typing import Any, Callable, Dict, List

import rospy

from .node_handle import NodeHandle, Publisher


class RosPublisher(Publisher):
    """A rospy publisher, created once and closed with its node handle."""

    def __init__(self, topic: str, kind: Any, queue_size: int) -> None:
        self._publisher = rospy.Publisher(topic, kind, queue_size=queue_size, tcp_nodelay=True)

    def publish(self, message: Any) -> None:
        """Queue `message` for the sending threads."""
        try:
            self._publisher.publish(message)
        except rospy.ROSException:
            # The publisher was closed by an unload or a shutdown between two cycles.
            if not rospy.is_shutdown():
                rospy.logdebug("a message on the closed topic %s was dropped", self._publisher.name)

    def has_subscribers(self) -> bool:
        """Whether anybody listens."""
        return self._publisher.get_num_connections() > 0

    def close(self) -> None:
        """Take the topic back."""
        self._publisher.unregister()


class RosNodeHandle(NodeHandle):
    """Parameters and topics of the ROS graph under `namespace` (by default the node's own)."""

    def __init__(self, namespace: str = "") -> None:
        self.namespace = rospy.resolve_name(namespace or rospy.get_namespace()).rstrip("/")
        self.logger = logging.getLogger("rosout")
        self._publishers: List[RosPublisher] = []
        self._subscribers: List[rospy.Subscriber] = []

    def child(self, name: str) -> RosNodeHandle:
        """Return the handle of a namespace inside."""
        return RosNodeHandle(self.resolve(name))

    def params(self) -> Dict[str, Any]:
        """Ask the parameter server for the whole namespace."""
        values = rospy.get_param(self.namespace or "/", {})
        return values if isinstance(values, dict) else {}

    def find_param(self, name: str, default: Any) -> Any:
        """Ask the parameter server."""
        return rospy.get_param(self.resolve(name), default)

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        """Subscribe; the newest message wins when the callback is slow."""
        self._subscribers.append(
            rospy.Subscriber(self.resolve(topic), kind, callback, queue_size=1, tcp_nodelay=True)
        )

    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> RosPublisher:
        """Advertise; sending happens in rospy's own threads."""
        publisher = RosPublisher(self.resolve(topic), kind, queue_size)
        self._publishers.append(publisher)
        return publisher

    def shutdown(self) -> None:
        """Close all publishers and subscriptions of this handle."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        for publisher in self._publishers:
            publisher.close()
        self._subscribers, self._publishers = [], []
