"""The little of ROS that a controller needs: parameters and topics, under one namespace.

Controllers see only this, so that they run in tests and benchmarks without a ROS master
(`LocalNodeHandle`), and in a node (`ros_node_handle.RosNodeHandle`).
"""

from __future__ import annotations

import abc
import logging
import time
from typing import Any, Callable, Dict, List

_REQUIRED = object()


class ParameterError(ValueError):
    """A parameter is missing or wrong; the message names it, its value and what would be right."""


class Publisher(abc.ABC):
    """The sending end of a topic."""

    @abc.abstractmethod
    def publish(self, message: Any) -> None:
        """Send `message`; never blocks on a slow subscriber."""

    @abc.abstractmethod
    def has_subscribers(self) -> bool:
        """Whether anybody listens; what nobody hears need not be built."""


class NodeHandle(abc.ABC):
    """Parameters and topics under one namespace.

    Attributes
    ----------
    namespace : str
        Full name, without a slash at its end.
    logger : logging.Logger
    """

    namespace: str
    logger: logging.Logger
    _next_warning = 0.0

    def warn(self, text: str) -> None:
        """Log a warning about what comes from outside: at most one a second."""
        if time.monotonic() >= self._next_warning:
            self._next_warning = time.monotonic() + 1.0
            self.logger.warning("%s", text)

    @abc.abstractmethod
    def child(self, name: str) -> NodeHandle:
        """Return the handle of the namespace `name` inside this one."""

    @abc.abstractmethod
    def params(self) -> Dict[str, Any]:
        """Return all parameters of this namespace."""

    @abc.abstractmethod
    def find_param(self, name: str, default: Any) -> Any:
        """Return the value of parameter `name` here, or `default`."""

    @abc.abstractmethod
    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        """Call `callback` in another thread for each message of class `kind` on `topic`."""

    @abc.abstractmethod
    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> Publisher:
        """Return a publisher of messages of class `kind` on `topic`."""

    @abc.abstractmethod
    def shutdown(self) -> None:
        """End all subscriptions and publishers made through this handle."""

    def resolve(self, name: str) -> str:
        """Full name of `name`, which is relative to this namespace unless it begins with /."""
        return name if name.startswith("/") else f"{self.namespace}/{name}"

    def param(self, name: str, kind: Any, default: Any = _REQUIRED) -> Any:
        """Return parameter `name`, checked to be a `kind`.

        Parameters
        ----------
        kind : type or tuple of types
            What the value must be. For ``float``, integers are taken too, and the value must be
            finite.

        Raises
        ------
        ParameterError
            Missing without a default, or of another kind.
        """
        value = self.find_param(name, None)
        full_name = self.resolve(name)
        if value is None:
            if default is _REQUIRED:
                raise ParameterError(
                    f"parameter {full_name} is missing; was the controller configuration loaded "
                    "on the parameter server in this namespace?"
                )
            return default
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            wanted = getattr(kind, "__name__", str(kind))
            raise ParameterError(f"parameter {full_name} is {value!r}; a {wanted} is needed")
        if kind is float and not abs(value) < float("inf"):
            raise ParameterError(f"parameter {full_name} is {value}; it must be finite")
        return value


class LocalPublisher(Publisher):
    """A publisher of `LocalNodeHandle`: hands messages straight to the subscribers."""

    def __init__(self, subscribers: List[Callable[[Any], None]]) -> None:
        self._subscribers = subscribers

    def publish(self, message: Any) -> None:
        """Call every subscriber, in this thread."""
        for callback in list(self._subscribers):
            callback(message)

    def has_subscribers(self) -> bool:
        """Whether anybody listens."""
        return bool(self._subscribers)


class LocalNodeHandle(NodeHandle):
    """A node handle without ROS: parameters from a dict, topics within the process.

    Parameters
    ----------
    params : dict, optional
        Nested parameters, as the YAML file has them.
    """

    def __init__(self, params: Any = None, namespace: str = "") -> None:
        self.namespace = namespace
        self.logger = logging.getLogger("telex_control")
        self._params: Dict[str, Any] = params if params is not None else {}
        self._topics: Dict[str, List[Callable[[Any], None]]] = {}
        self._own: List[Any] = []

    def child(self, name: str) -> LocalNodeHandle:
        """Return the handle of a namespace inside; parameters and topics are shared."""
        node = LocalNodeHandle(self._params, f"{self.namespace}/{name}")
        node._topics = self._topics
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

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        """Register `callback`; it runs in the publishing thread."""
        name = self.resolve(topic)
        self._topics.setdefault(name, []).append(callback)
        self._own.append((name, callback))

    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> LocalPublisher:
        """Return a publisher on `topic`."""
        return LocalPublisher(self._topics.setdefault(self.resolve(topic), []))

    def shutdown(self) -> None:
        """End the subscriptions."""
        for name, callback in self._own:
            self._topics[name].remove(callback)
        self._own = []
