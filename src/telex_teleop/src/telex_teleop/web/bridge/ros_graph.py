"""The bridge's side towards ROS, by rospy."""

from __future__ import annotations

import collections
import http.client
import socket
import threading
import urllib.parse
import xmlrpc.client
from typing import Any, Callable, Counter, Dict, List, Optional, Set, Tuple, Type

import genpy
import rosgraph
import rosgraph.names
import rospy
import rosservice

from ..ros_clock import RosClock
from .protocol.operations import OperationError
from .ros import Answer, BridgePublisher, Receive

_ONLY_NEWEST_COUNTS = (
    "sensor_msgs/Image",
    "sensor_msgs/CompressedImage",
    "sensor_msgs/PointCloud2",
)
_ORDERS = ("goal", "cancel")
_ANSWERS = ("status", "feedback", "result")
_NODE_TIMEOUT = 1.0
_OUTBOUND = "o"
_BUFFER_SIZE = 2**24
_QUEUE_SIZE = 100


class _RosPublisher:
    """A rospy.Publisher that never blocks: it has a queue and a thread for each subscriber."""

    def __init__(self, publisher: rospy.Publisher) -> None:
        self._publisher = publisher

    def publish(self, message: genpy.Message) -> None:
        try:
            self._publisher.publish(message)
        except (rospy.ROSException, rospy.ROSSerializationException) as error:
            raise OperationError(str(error)) from None

    def connections(self) -> int:
        return int(self._publisher.get_num_connections())

    def unregister(self) -> None:
        self._publisher.unregister()


def _reachable(address: Optional[str]) -> bool:
    """Whether somebody listens at a node's address."""
    if address is None:
        return False
    try:
        parts = urllib.parse.urlsplit(address)
        socket.create_connection((parts.hostname or "", parts.port or 0), _NODE_TIMEOUT).close()
    except (OSError, ValueError):  # a node may have told the master what is no address
        return False
    return True


class _Transport(xmlrpc.client.Transport):
    """Asks a node, which may hang."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = _NODE_TIMEOUT
        return connection


def _outbound(connections: List[Any]) -> Set[Tuple[str, str]]:
    """Return who gets which topics, from a node's list of connections (getBusInfo)."""
    return {(row[1], row[4]) for row in connections if row[2] == _OUTBOUND and row[5]}


class RosGraph:
    """Implements `ros.Ros`; the node must have been initialised."""

    def __init__(self) -> None:
        self._addresses: Dict[str, str] = {}
        self._listening: Counter[str] = collections.Counter()
        self._lock = threading.Lock()
        self._clock = RosClock()

    def now(self) -> genpy.Time:
        """Return the present ROS time."""
        return rospy.get_rostime()

    def sim_time(self) -> float:
        """Return the present ROS time (s) as it goes on between two messages of `/clock`."""
        return self._clock()

    def resolve(self, name: str) -> str:
        """Return a name in its global form; raises OperationError if it is no ROS name."""
        if not rosgraph.names.is_legal_name(name):
            raise OperationError(f"{name[:80]!r} is no ROS name")
        return str(rospy.resolve_name(name))

    def topic_types(self) -> Dict[str, str]:
        """Return the types of all topics that the master has heard of."""
        return dict(self._master().getTopicTypes())

    def topics(self) -> List[str]:
        """Return all topics that somebody publishes or subscribes to now."""
        publishers, subscribers, _ = self._master().getSystemState()
        return sorted({topic for topic, _ in publishers + subscribers})

    def nodes(self) -> List[str]:
        """Return all nodes that publish, subscribe or serve."""
        state = self._master().getSystemState()
        return sorted({node for part in state for _, nodes in part for node in nodes})

    def node_answers(self, node: str) -> bool:
        """Tell whether a node that the master knows can be reached."""
        if _reachable(self._addresses.get(node)):
            return True
        try:
            # It may have been started again meanwhile, at another port.
            self._addresses[node] = self._master().lookupNode(node)
        except rosgraph.MasterError:
            return True  # it has taken its leave: nobody misses it
        return _reachable(self._addresses[node])

    def node_details(self, node: str) -> Dict[str, List[str]]:
        """Return the topics and services of a node."""
        publishers, subscribers, services = (
            sorted(name for name, nodes in part if node in nodes)
            for part in self._master().getSystemState()
        )
        return {"subscribing": subscribers, "publishing": publishers, "services": services}

    def services(self) -> List[str]:
        """Return all services."""
        return sorted(name for name, _ in self._master().getSystemState()[2])

    def service_nodes(self, service: str) -> List[str]:
        """Return the nodes that offer a service."""
        return sorted(dict(self._master().getSystemState()[2]).get(service, []))

    def service_host(self, service: str) -> str:
        """Return the host at which a service is offered, empty if there is no such service."""
        try:
            return urllib.parse.urlsplit(self._master().lookupService(service)).hostname or ""
        except rosgraph.MasterError:
            return ""

    def own_host(self) -> str:
        """Return the host at which others reach this node."""
        return str(rosgraph.network.get_host_name())

    def publishers(self, topic: str) -> List[str]:
        """Return the nodes that publish a topic."""
        return sorted(dict(self._master().getSystemState()[0]).get(topic, []))

    def subscribers(self, topic: str) -> List[str]:
        """Return the nodes that have subscribed to a topic."""
        return sorted(dict(self._master().getSystemState()[1]).get(topic, []))

    def advertise(
        self, topic: str, message_class: Type[genpy.Message], *, latch: bool, queue_size: int
    ) -> BridgePublisher:
        """Begin to publish a topic."""
        try:
            publisher = rospy.Publisher(
                topic, message_class, latch=latch, queue_size=queue_size, tcp_nodelay=True
            )
        except (rospy.ROSException, ValueError) as error:
            raise OperationError(str(error)) from None
        return _RosPublisher(publisher)

    def subscribe(
        self, topic: str, message_class: Type[genpy.Message], receive: Receive
    ) -> Callable[[], None]:
        """Begin to receive a topic; return the function that ends it."""

        def callback(message: Any) -> None:
            header = message._connection_header
            latching = header.get("latching") == "1"
            receive(message, header.get("callerid", "") if latching else None)

        only_newest = message_class._type in _ONLY_NEWEST_COUNTS
        try:
            subscriber = rospy.Subscriber(
                topic,
                message_class,
                callback,
                queue_size=1 if only_newest else _QUEUE_SIZE,
                buff_size=_BUFFER_SIZE if only_newest else rospy.topics.DEFAULT_BUFF_SIZE,
                tcp_nodelay=True,
            )
        except (rospy.ROSException, ValueError) as error:
            raise OperationError(str(error)) from None
        with self._lock:
            self._listening[topic] += 1

        def end() -> None:
            with self._lock:
                self._listening[topic] -= 1
            subscriber.unregister()

        return end

    def action_connected(self, action: str) -> bool:
        """Return whether the servers of an action and this node are connected both ways."""
        publishers, subscribers, _ = map(dict, self._master().getSystemState())
        own = _outbound(rospy.topics.get_topic_manager().get_pub_sub_info())
        with self._lock:
            answers = {f"{action}/{name}" for name in _ANSWERS}
            answers = {topic for topic in answers if self._listening[topic] > 0}
        for server in subscribers.get(f"{action}/goal", []):
            # Of what a server says to this node only the server knows: its connection is made a
            # moment later than this end of it, and what is published in between is lost.
            sent = self._sent_by(server)
            if sent is None:
                continue
            orders = {f"{action}/{name}" for name in _ORDERS}
            heard = {(server, topic) for topic in orders if server in subscribers.get(topic, [])}
            said = {
                (rospy.get_name(), topic)
                for topic in answers
                if server in publishers.get(topic, [])
            }
            if not (heard <= own and said <= sent):
                return False
        return True

    def _sent_by(self, node: str) -> Optional[Set[Tuple[str, str]]]:
        """Return to whom a node sends which topics; None if it does not answer."""
        try:
            uri = self._master().lookupNode(node)
            proxy = xmlrpc.client.ServerProxy(uri, transport=_Transport())
            code, _, connections = proxy.getBusInfo(rospy.get_name())  # type: ignore[misc]
        except (
            OSError,
            ValueError,
            rosgraph.MasterError,
            http.client.HTTPException,
            xmlrpc.client.Error,
        ):
            return None
        return _outbound(connections) if code == 1 else None  # type: ignore[arg-type]

    def service_type(self, service: str) -> Optional[str]:
        """Return the type of a service, None if there is no such service."""
        try:
            uri = self._master().lookupService(service)
        except rosgraph.MasterError:
            return None
        try:
            return rosservice.get_service_headers(service, uri).get("type")
        except (rosservice.ROSServiceException, rosgraph.network.ROSHandshakeException) as error:
            raise OperationError(f"the service {service} does not answer: {error}") from None

    def call_service(self, service: str, service_class: Any, request: genpy.Message) -> Any:
        """Call a service and return its response."""
        try:
            return rospy.ServiceProxy(service, service_class)(request)
        except (rospy.ServiceException, rospy.ROSException) as error:
            raise OperationError(str(error)) from None

    def serve(self, service: str, service_class: Any, answer: Answer) -> Callable[[], None]:
        """Begin to offer a service; return the function that ends it."""
        # The master would let a newcomer take any service from its node without a word.
        others = set(dict(self._master().getSystemState()[2]).get(service, []))
        others.discard(rospy.get_name())
        if others:
            raise OperationError(f"{service} is offered by {', '.join(sorted(others))} already")

        def handle(request: Any) -> Any:
            try:
                return answer(request)
            except OperationError as error:
                raise rospy.ServiceException(str(error)) from None

        try:
            offered = rospy.Service(service, service_class, handle)
        except (rospy.ServiceException, ValueError) as error:
            raise OperationError(str(error)) from None
        return lambda: offered.shutdown("its client has withdrawn it")

    def get_param(self, name: str) -> Any:
        """Return a parameter; raises KeyError if it is not set."""
        try:
            return self._master().getParam(name)
        except rosgraph.MasterError:
            raise KeyError(name) from None

    def set_param(self, name: str, value: Any) -> None:
        """Set a parameter."""
        self._master().setParam(name, value)

    def delete_param(self, name: str) -> None:
        """Delete a parameter; raises KeyError if it is not set."""
        try:
            self._master().deleteParam(name)
        except rosgraph.MasterError:
            raise KeyError(name) from None

    def param_names(self) -> List[str]:
        """Return the names of all parameters."""
        return list(self._master().getParamNames())

    def _master(self) -> rosgraph.Master:
        # A proxy is not made for several threads, and services are called in threads of their own.
        return rosgraph.Master(rospy.get_name())
