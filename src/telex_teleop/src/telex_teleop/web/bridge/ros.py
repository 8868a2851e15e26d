"""Interface between the bridge and ROS, so that it can be tested without a master."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Protocol, Type

import genpy

Receive = Callable[[genpy.Message, Optional[str]], None]
"""Takes a message in any thread; the name of its publisher, if that publisher latches."""

Answer = Callable[[genpy.Message], genpy.Message]
"""Answers a call of a service in any thread; OperationError says why it cannot."""


class BridgePublisher(Protocol):
    """A publisher of one topic."""

    def publish(self, message: genpy.Message) -> None:
        """Publish without blocking; raises OperationError if that cannot be done."""

    def connections(self) -> int:
        """Return how many subscribers are connected now."""

    def unregister(self) -> None:
        """End it; may block."""


class Ros(Protocol):
    """Topics, services and parameters; all methods may block, unless they say otherwise.

    They raise OperationError for what the client got wrong and OSError when the master does not
    answer.
    """

    def now(self) -> genpy.Time:
        """Return the present ROS time; does not block."""

    def sim_time(self) -> float:
        """Return the present ROS time (s), finer than it is published; on one thread."""

    def resolve(self, name: str) -> str:
        """Return a name in its global form, relative to the bridge's namespace; does not block."""

    def topic_types(self) -> Dict[str, str]:
        """Return the types of all topics that have been published or subscribed to."""

    def topics(self) -> List[str]:
        """Return all topics that somebody publishes or subscribes to now."""

    def nodes(self) -> List[str]:
        """Return all nodes."""

    def node_answers(self, node: str) -> bool:
        """Tell whether a node that the master knows can be reached."""

    def node_details(self, node: str) -> Dict[str, List[str]]:
        """Return the topics and services of a node: `subscribing`, `publishing`, `services`."""

    def services(self) -> List[str]:
        """Return all services."""

    def service_nodes(self, service: str) -> List[str]:
        """Return the nodes that offer a service."""

    def service_host(self, service: str) -> str:
        """Return the host at which a service is offered, empty if there is no such service."""

    def own_host(self) -> str:
        """Return the host at which others reach this node; does not block."""

    def publishers(self, topic: str) -> List[str]:
        """Return the nodes that publish a topic."""

    def subscribers(self, topic: str) -> List[str]:
        """Return the nodes that have subscribed to a topic."""

    def action_connected(self, action: str) -> bool:
        """Return whether the servers of an action and this node are connected both ways.

        That is: ``goal`` and ``cancel`` of this node go to each of them, and each sends its
        ``status``, ``feedback`` and ``result`` to this node, as far as it listens to them. Servers
        that do not answer are not counted.
        """

    def advertise(
        self, topic: str, message_class: Type[genpy.Message], *, latch: bool, queue_size: int
    ) -> BridgePublisher:
        """Begin to publish a topic."""

    def subscribe(
        self, topic: str, message_class: Type[genpy.Message], receive: Receive
    ) -> Callable[[], None]:
        """Begin to receive a topic; return the function that ends it, which may block."""

    def service_type(self, service: str) -> Optional[str]:
        """Return the type of a service, None if there is no such service."""

    def call_service(self, service: str, service_class: Any, request: genpy.Message) -> Any:
        """Call a service and return its response."""

    def serve(self, service: str, service_class: Any, answer: Answer) -> Callable[[], None]:
        """Begin to offer a service; return the function that ends it, which may block."""

    def get_param(self, name: str) -> Any:
        """Return a parameter; raises KeyError if it is not set."""

    def set_param(self, name: str, value: Any) -> None:
        """Set a parameter."""

    def delete_param(self, name: str) -> None:
        """Delete a parameter; raises KeyError if it is not set."""

    def param_names(self) -> List[str]:
        """Return the names of all parameters."""
