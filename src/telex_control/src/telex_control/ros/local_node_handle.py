"""`NodeHandle` without ROS, for tests and benchmarks: everything stays in the process."""

from __future__ import annotations

import logging
from typing import Any, Callable, Dict, List, Optional, Sequence

from .node_handle import (
    ActionGoal,
    NodeHandle,
    Number,
    Publisher,
    ReconfigurableParameter,
    Subscription,
)


class _Topic(Subscription):
    """The callbacks of one topic, and how many publish on it."""

    def __init__(self) -> None:
        self.callbacks: List[Callable[[Any], None]] = []
        self.publishers = 0

    def publisher_count(self) -> int:
        return self.publishers

    def is_connected(self, message: Any) -> bool:
        return self.publishers > 0


class LocalPublisher(Publisher):
    """Hands messages straight to the subscribers, in the publishing thread."""

    def __init__(self, topic: _Topic) -> None:
        self._topic = topic
        topic.publishers += 1

    def publish(self, message: Any) -> None:
        """Call every subscriber, in this thread."""
        for callback in list(self._topic.callbacks):
            callback(message)

    def has_subscribers(self) -> bool:
        """Whether anybody listens."""
        return bool(self._topic.callbacks)

    def close(self) -> None:
        """Publish no more."""
        self._topic.publishers -= 1


class LocalGoal(ActionGoal):
    """A goal that remembers what became of it.

    Attributes
    ----------
    status : str
        ``pending``, ``active``, ``rejected``, ``succeeded``, ``aborted`` or ``cancelled``.
    result, text
        As the server ended it.
    feedback : list
    """

    def __init__(self, message: Any) -> None:
        super().__init__(message)
        self.status = "pending"
        self.result: Any = None
        self.text = ""
        self.feedback: List[Any] = []

    def _end(self, status: str, before: str, result: Any, text: str) -> None:
        if self.status not in before.split():
            raise AssertionError(f"a goal that is {self.status} cannot become {status}")
        self.status, self.result, self.text = status, result, text

    def accept(self) -> None:
        """Make the goal active."""
        self._end("active", "pending", None, "")

    def reject(self, result: Any, text: str) -> None:
        """Refuse the goal."""
        self._end("rejected", "pending", result, text)

    def succeed(self, result: Any, text: str = "") -> None:
        """End the goal: it was reached."""
        self._end("succeeded", "active", result, text)

    def abort(self, result: Any, text: str) -> None:
        """End the goal: it cannot be reached."""
        self._end("aborted", "active", result, text)

    def cancel(self, result: Any, text: str = "") -> None:
        """End the goal: it is no longer wanted."""
        self._end("cancelled", "pending active", result, text)

    def publish_feedback(self, feedback: Any) -> None:
        """Keep the feedback."""
        self.feedback.append(feedback)


class _Graph:
    """What the handles of one process share."""

    def __init__(self) -> None:
        self.topics: Dict[str, _Topic] = {}
        self.services: Dict[str, Callable[[Any], Any]] = {}
        self.actions: Dict[str, Callable[[ActionGoal], None]] = {}
        self.reconfigurations: Dict[str, Callable[[Dict[str, Any]], Dict[str, Any]]] = {}


class LocalNodeHandle(NodeHandle):
    """A node handle without ROS: parameters from a dict, the rest within the process.

    Parameters
    ----------
    params : dict, optional
        Nested parameters, as the YAML file has them.
    """

    def __init__(self, params: Optional[Dict[str, Any]] = None, namespace: str = "") -> None:
        self.namespace = namespace
        self.logger = logging.getLogger("telex_control")
        self._params: Dict[str, Any] = params if params is not None else {}
        self._graph = _Graph()
        self._undo: List[Callable[[], Any]] = []

    def child(self, name: str) -> LocalNodeHandle:
        """Return the handle of a namespace inside; everything is shared with it."""
        node = LocalNodeHandle(self._params, f"{self.namespace}/{name}")
        node._graph = self._graph
        return node

    def params(self) -> Dict[str, Any]:
        """Return the part of the dict that stands at this namespace."""
        value: Any = self._params
        for part in self.namespace.strip("/").split("/") if self.namespace else ():
            value = value.get(part, {}) if isinstance(value, dict) else {}
        return value if isinstance(value, dict) else {}

    def find_param(self, name: str, default: Any) -> Any:
        """Return the value at the full name of `name` in the nested dict, or `default`."""
        value: Any = self._params
        for part in self.resolve(name).strip("/").split("/"):
            if not isinstance(value, dict) or part not in value:
                return default
            value = value[part]
        return value

    def _topic(self, name: str) -> _Topic:
        return self._graph.topics.setdefault(self.resolve(name), _Topic())

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> Subscription:
        """Register `callback`; it runs in the publishing thread."""
        found = self._topic(topic)
        found.callbacks.append(callback)
        self._undo.append(lambda: found.callbacks.remove(callback))
        return found

    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> LocalPublisher:
        """Return a publisher on `topic`."""
        publisher = LocalPublisher(self._topic(topic))
        self._undo.append(publisher.close)
        return publisher

    def advertise_service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> None:
        """Register `handler` for `call_service`."""
        services, full_name = self._graph.services, self.resolve(name)
        services[full_name] = handler
        self._undo.append(lambda: services.pop(full_name))

    def serve_action(self, name: str, kind: Any, on_goal: Callable[[ActionGoal], None]) -> None:
        """Register `on_goal` for `send_goal`."""
        actions, full_name = self._graph.actions, self.resolve(name)
        actions[full_name] = on_goal
        self._undo.append(lambda: actions.pop(full_name))

    def serve_reconfiguration(
        self,
        name: str,
        parameters: Sequence[ReconfigurableParameter],
        values: Dict[str, Number],
        on_change: Callable[[Dict[str, Any]], None],
    ) -> None:
        """Register `on_change` for `reconfigure`."""
        current: Dict[str, Any] = dict(values)

        def change(changes: Dict[str, Any]) -> Dict[str, Any]:
            wanted = dict(current)
            for parameter in parameters:
                if parameter.name in changes:
                    value = type(parameter.default)(changes[parameter.name])
                    bounded = min(max(value, parameter.minimum), parameter.maximum)
                    wanted[parameter.name] = bounded
            on_change(wanted)
            current.update(wanted)
            return dict(current)

        servers, full_name = self._graph.reconfigurations, self.resolve(name)
        servers[full_name] = change
        self._undo.append(lambda: servers.pop(full_name))

    def shutdown(self) -> None:
        """End everything that was made through this handle."""
        for undo in self._undo:
            undo()
        self._undo = []

    # --- the other side, which in ROS other nodes have -----------------------------------------

    def call_service(self, name: str, request: Any) -> Any:
        """Call a service of the process.

        Raises
        ------
        ServiceError
            As the handler raises it.
        KeyError
            There is no such service.
        """
        return self._graph.services[self.resolve(name)](request)

    def send_goal(self, name: str, message: Any) -> LocalGoal:
        """Send a goal to an action of the process.

        Raises
        ------
        KeyError
            There is no such action.
        """
        goal = LocalGoal(message)
        self._graph.actions[self.resolve(name)](goal)
        return goal

    def reconfigure(self, name: str, **changes: Any) -> Dict[str, Any]:
        """Change parameters at run time, and return what they are then.

        Raises
        ------
        ValueError
            They are refused.
        KeyError
            There are none to change at `name`.
        """
        return self._graph.reconfigurations[self.resolve(name)](changes)

    def offers_reconfiguration(self) -> List[str]:
        """Names of the namespaces that can be reconfigured, sorted."""
        return sorted(self._graph.reconfigurations)
