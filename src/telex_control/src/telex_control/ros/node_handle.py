"""The little of ROS that a controller needs, under one namespace.

Parameters, topics, services, action servers and parameters that change at run time. Controllers
see only this, so that they run in tests and benchmarks without a ROS master
(`local_node_handle.LocalNodeHandle`), and in a node (`ros_node_handle.RosNodeHandle`).
"""

from __future__ import annotations

import abc
import logging
import time
from dataclasses import dataclass
from typing import Any, Callable, Dict, Sequence, Union

from ..common.params import ConfigError, read_value

_REQUIRED = object()

Number = Union[bool, int, float]


class ServiceError(Exception):
    """A service cannot answer; the message tells the caller why."""


class Publisher(abc.ABC):
    """The sending end of a topic."""

    @abc.abstractmethod
    def publish(self, message: Any) -> None:
        """Send `message`; never blocks on a slow subscriber."""

    @abc.abstractmethod
    def has_subscribers(self) -> bool:
        """Whether anybody listens; what nobody hears need not be built."""


class Subscription(abc.ABC):
    """The receiving end of a topic."""

    @abc.abstractmethod
    def publisher_count(self) -> int:
        """How many publishers there are."""

    @abc.abstractmethod
    def is_connected(self, message: Any) -> bool:
        """Whether the publisher that sent `message` is still there."""


class ActionGoal(abc.ABC):
    """One goal that an action server has received.

    A new goal is pending: it is to be accepted or rejected. An accepted goal is active, until it
    succeeds, is aborted or cancelled. Every method returns at once, so that the control loop may
    call it.

    Attributes
    ----------
    message
        The goal, e.g. a control_msgs/FollowJointTrajectoryGoal.
    cancel_requested : bool
        Whether a client has asked to cancel it; the server of the goal looks at it now and then.
    """

    def __init__(self, message: Any) -> None:
        self.message = message
        self.cancel_requested = False

    @abc.abstractmethod
    def accept(self) -> None:
        """Make the goal active."""

    @abc.abstractmethod
    def reject(self, result: Any, text: str) -> None:
        """Refuse a pending goal; `text` says why."""

    @abc.abstractmethod
    def succeed(self, result: Any, text: str = "") -> None:
        """End the goal: it was reached."""

    @abc.abstractmethod
    def abort(self, result: Any, text: str) -> None:
        """End the goal: it cannot be reached; `text` says why."""

    @abc.abstractmethod
    def cancel(self, result: Any, text: str = "") -> None:
        """End the goal because a client, or a newer goal, wanted so."""

    @abc.abstractmethod
    def publish_feedback(self, feedback: Any) -> None:
        """Tell clients how far it is."""


@dataclass(frozen=True)
class ReconfigurableParameter:
    """A parameter that may be changed at run time, as dynamic_reconfigure describes it.

    Attributes
    ----------
    default : bool, int or float
        Its type is the parameter's type.
    minimum, maximum : bool, int or float
        Values outside are bounded to them.
    """

    name: str
    default: Number
    minimum: Number
    maximum: Number
    description: str


class NodeHandle(abc.ABC):
    """Everything that one namespace offers.

    Attributes
    ----------
    namespace : str
        Full name, without a slash at its end.
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
    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> Subscription:
        """Call `callback` in another thread for each message of class `kind` on `topic`."""

    @abc.abstractmethod
    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> Publisher:
        """Return a publisher of messages of class `kind` on `topic`."""

    @abc.abstractmethod
    def advertise_service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> None:
        """Answer requests of the service class `kind` by what `handler` returns.

        The handler runs in another thread, and raises `ServiceError` when it has no answer.
        """

    @abc.abstractmethod
    def serve_action(self, name: str, kind: Any, on_goal: Callable[[ActionGoal], None]) -> None:
        """Offer an action of class `kind`; `on_goal` runs in another thread for each new goal."""

    @abc.abstractmethod
    def serve_reconfiguration(
        self,
        name: str,
        parameters: Sequence[ReconfigurableParameter],
        values: Dict[str, Number],
        on_change: Callable[[Dict[str, Any]], None],
    ) -> None:
        """Let `parameters` in the namespace `name` be changed at run time.

        Parameters
        ----------
        name : str
            Where they stand; empty for this namespace itself.
        values : dict
            What they are now.
        on_change
            Called in another thread with all values, each within its range and of its type. It
            raises a ValueError to refuse them.
        """

    @abc.abstractmethod
    def shutdown(self) -> None:
        """End everything that was made through this handle."""

    def resolve(self, name: str) -> str:
        """Full name of `name`, which is relative to this namespace unless it begins with /."""
        if not name:
            return self.namespace
        return name if name.startswith("/") else f"{self.namespace}/{name}"

    def param(self, name: str, kind: Any, default: Any = _REQUIRED) -> Any:
        """Return parameter `name`, checked to be a `kind`.

        Parameters
        ----------
        kind : type
            What the value must be; see `telex_control.common.params.read_value`.

        Raises
        ------
        ConfigError
            Missing without a default, or of another kind.
        """
        value = self.find_param(name, None)
        full_name = self.resolve(name)
        if value is None:
            if default is _REQUIRED:
                raise ConfigError(
                    f"parameter {full_name} is missing; was the controller configuration loaded "
                    "on the parameter server in this namespace?"
                )
            return default
        return read_value(kind, value, f"parameter {full_name}")

    def positive_param(self, name: str, default: Any = _REQUIRED, *, zero: bool = False) -> float:
        """Return the number `name`, checked to be above 0 (or, with `zero`, at least 0).

        Raises
        ------
        ConfigError
        """
        value = self.param(name, float, default)
        if value < 0.0 or (value == 0.0 and not zero):
            raise ConfigError(
                f"parameter {self.resolve(name)} is {value}; it must be "
                f"{'0 or more' if zero else 'above 0'}"
            )
        return value

    def names_param(self, name: str) -> list:
        """Return the list `name`, checked to hold distinct names, at least one.

        Raises
        ------
        ConfigError
        """
        names = self.param(name, list)
        usable = names and all(isinstance(each, str) and each for each in names)
        if not usable or len(set(names)) != len(names):
            raise ConfigError(
                f"parameter {self.resolve(name)} is {names!r}; a list of distinct names is needed"
            )
        return names
