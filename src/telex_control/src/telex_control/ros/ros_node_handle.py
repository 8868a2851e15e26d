"""`NodeHandle` on rospy, actionlib and dynamic_reconfigure."""

from __future__ import annotations

import logging
import math
import queue
import threading
from typing import Any, Callable, Dict, List, Optional, Sequence

import actionlib
import rospy
from dynamic_reconfigure.server import Server as ReconfigureServer

from .node_handle import (
    ActionGoal,
    NodeHandle,
    Number,
    ReconfigurableParameter,
    ServiceError,
    Subscription,
)
from .node_start import end_quietly
from .publisher import RosPublisher
from .rospy_fixes.connections import is_connected, sender_of


class RosSubscription(Subscription):
    """A rospy subscriber; the newest message wins when the callback is slow."""

    def __init__(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        self._subscriber = rospy.Subscriber(topic, kind, callback, queue_size=1, tcp_nodelay=True)

    def publisher_count(self) -> int:
        """How many publishers are connected."""
        return self._subscriber.get_num_connections()

    def is_connected(self, message: Any) -> bool:
        """Whether the node that sent `message` is still connected."""
        return is_connected(self._subscriber, sender_of(message))

    def close(self) -> None:
        """End the subscription."""
        self._subscriber.unregister()


class RosGoal(ActionGoal):
    """A goal handle of actionlib, behind the queue of its server."""

    def __init__(self, handle: Any, submit: Callable[[Callable[[], None]], None]) -> None:
        super().__init__(handle.get_goal())
        self._handle = handle
        self._submit = submit

    def is_done(self) -> bool:
        """Whether it has ended, one way or another."""
        status = self._handle.get_goal_status()
        pending = (status.PENDING, status.ACTIVE, status.PREEMPTING, status.RECALLING)
        return status.status not in pending

    def accept(self) -> None:
        """Make the goal active."""
        self._submit(self._handle.set_accepted)

    def reject(self, result: Any, text: str) -> None:
        """Refuse the goal."""
        self._submit(lambda: self._handle.set_rejected(result, text))

    def succeed(self, result: Any, text: str = "") -> None:
        """End the goal: it was reached."""
        self._submit(lambda: self._handle.set_succeeded(result, text))

    def abort(self, result: Any, text: str) -> None:
        """End the goal: it cannot be reached."""
        self._submit(lambda: self._handle.set_aborted(result, text))

    def cancel(self, result: Any, text: str = "") -> None:
        """End the goal: it is no longer wanted."""
        self._submit(lambda: self._handle.set_canceled(result, text))

    def publish_feedback(self, feedback: Any) -> None:
        """Tell clients how far it is."""
        self._submit(lambda: self._handle.publish_feedback(feedback))


class RosActionServer:
    """An actionlib server whose goals may be ended from the control loop.

    actionlib takes locks, serializes and publishes on every change of a goal. That is done here
    in a thread of its own, in the order of the calls.

    Parameters
    ----------
    name : str
        Full name of the action.
    kind : class
        E.g. control_msgs.msg.FollowJointTrajectoryAction.
    """

    def __init__(self, name: str, kind: Any, on_goal: Callable[[ActionGoal], None]) -> None:
        self._name = name
        self._on_goal = on_goal
        self._goals: Dict[str, RosGoal] = {}
        self._work: queue.SimpleQueue[Optional[Callable[[], None]]] = queue.SimpleQueue()
        self._server = actionlib.ActionServer(
            name, kind, self._receive_goal, self._receive_cancel, auto_start=False
        )
        self._thread = threading.Thread(target=self._run, name=f"{name} server", daemon=True)
        self._thread.start()
        self._server.start()
        end_quietly(self._server)

    def _receive_goal(self, handle: Any) -> None:
        # Under actionlib's lock, as is every cancel request.
        done = [name for name, goal in self._goals.items() if goal.is_done()]
        for name in done:
            del self._goals[name]
        goal = RosGoal(handle, self._work.put)
        self._goals[handle.get_goal_id().id] = goal
        self._on_goal(goal)

    def _receive_cancel(self, handle: Any) -> None:
        goal = self._goals.get(handle.get_goal_id().id)
        if goal is not None:
            goal.cancel_requested = True

    def _run(self) -> None:
        while True:
            action = self._work.get()
            if action is None:
                return
            try:
                action()
            except rospy.ROSException:
                if not rospy.is_shutdown():
                    rospy.logdebug("a message of a closed action was dropped")
            except Exception as error:  # of a result that a user's controller filled wrongly
                rospy.logerr("action %s: a message is dropped: %r", self._name, error)

    def close(self) -> None:
        """Send what is queued and take the action back."""
        self._work.put(None)
        self._thread.join()
        self._server.stop()


class RosReconfiguration:
    """A dynamic_reconfigure server for a list of parameters.

    dynamic_reconfigure wants a module that is generated at build time from a ``.cfg`` file; the
    description that it takes from there is made here of the list.
    """

    def __init__(
        self,
        name: str,
        parameters: Sequence[ReconfigurableParameter],
        values: Dict[str, Number],
        on_change: Callable[[Dict[str, Any]], None],
    ) -> None:
        self._name = name
        self._kinds = {each.name: type(each.default) for each in parameters}
        self._values: Dict[str, Any] = dict(values)
        self._on_change = on_change
        self._begun = False
        self._groups: Any = {}
        self._server = ReconfigureServer(_ConfigType(parameters), self._change, name)

    def _change(self, config: Any, level: int) -> Any:
        if not self._begun:
            # What the parameters have now was read, and checked, by the controller.
            self._begun = True
            self._groups = config["groups"]
            config.update(self._values)
            return config
        try:
            wanted = {key: kind(config[key]) for key, kind in self._kinds.items()}
            wrong = [key for key, value in wanted.items() if not math.isfinite(value)]
            if wrong:
                raise ValueError(f"{wrong[0]} is {wanted[wrong[0]]}; it must be finite")
            self._on_change(wanted)
        except (TypeError, ValueError) as error:
            rospy.logwarn("%s: %s; nothing is changed", self._name, error)
            wanted = self._values
        self._values = wanted
        # Whatever else a client has named would be kept, and told to everybody, for ever.
        config.clear()
        config.update(wanted, groups=self._groups)
        return config

    def close(self) -> None:
        """Take service and topics back."""
        self._server.set_service.shutdown()
        self._server.descr_topic.unregister()
        self._server.update_topic.unregister()


class _ConfigType:
    """What a module generated from a ``.cfg`` file offers."""

    _NAMES = {bool: "bool", int: "int", float: "double"}

    def __init__(self, parameters: Sequence[ReconfigurableParameter]) -> None:
        self.defaults = {each.name: each.default for each in parameters}
        self.min = {each.name: each.minimum for each in parameters}
        self.max = {each.name: each.maximum for each in parameters}
        self.config_description = {
            "name": "Default",
            "id": 0,
            "parent": 0,
            "type": "",
            "state": True,
            "groups": [],
            "parameters": [
                {
                    "name": each.name,
                    "type": self._NAMES[type(each.default)],
                    "level": 0,
                    "description": each.description,
                    "edit_method": "",
                }
                for each in parameters
            ],
        }


class RosNodeHandle(NodeHandle):
    """What the ROS graph has under `namespace` (by default the node's own)."""

    def __init__(self, namespace: str = "") -> None:
        self.namespace = rospy.resolve_name(namespace or rospy.get_namespace()).rstrip("/")
        self.logger = logging.getLogger("rosout")
        self._close: List[Callable[[], Any]] = []

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

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> RosSubscription:
        """Subscribe; the newest message wins when the callback is slow."""
        subscription = RosSubscription(self.resolve(topic), kind, callback)
        self._close.append(subscription.close)
        return subscription

    def advertise(self, topic: str, kind: Any, queue_size: int = 4) -> RosPublisher:
        """Advertise; sending happens in a thread of its own."""
        publisher = RosPublisher(self.resolve(topic), kind, queue_size)
        self._close.append(publisher.close)
        return publisher

    def advertise_service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> None:
        """Offer a service."""

        def answer(request: Any) -> Any:
            try:
                return handler(request)
            except ServiceError as error:
                raise rospy.ServiceException(str(error)) from error

        service = rospy.Service(self.resolve(name), kind, answer)
        self._close.append(service.shutdown)

    def serve_action(self, name: str, kind: Any, on_goal: Callable[[ActionGoal], None]) -> None:
        """Offer an action."""
        self._close.append(RosActionServer(self.resolve(name), kind, on_goal).close)

    def serve_reconfiguration(
        self,
        name: str,
        parameters: Sequence[ReconfigurableParameter],
        values: Dict[str, Number],
        on_change: Callable[[Dict[str, Any]], None],
    ) -> None:
        """Offer a dynamic_reconfigure server."""
        server = RosReconfiguration(self.resolve(name), parameters, values, on_change)
        self._close.append(server.close)

    def shutdown(self) -> None:
        """Take back everything that this handle offers."""
        for close in self._close:
            close()
        self._close = []
