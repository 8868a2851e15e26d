"""A station's link to a live simulator that runs by itself."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Any, Callable

import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState

from telex_control.ros.ros_node_handle import RosNodeHandle
from telex_experiments.mobility.scripted_operator import NotManagedError

from .station import Link

_PATIENCE = 30.0
"""Wall time within which what is expected has to come (s)."""


_REPETITION = 0.08
"""Wall time after which keys that are held are repeated (s)."""


def _nothing() -> None:
    pass


class RosLink(Link):
    """Looks at the clock of the robot's own messages; close it when done.

    Parameters
    ----------
    namespace : str
        Of the robot.

    Raises
    ------
    NotManagedError
        No message of the robot comes.
    """

    def __init__(self, namespace: str) -> None:
        self.repeat = _nothing
        self.node = RosNodeHandle(namespace)
        self.urdf = self.node.param("robot_description", str)
        self._arrived = threading.Condition()
        self._stamps = {"joint_states": -1.0, "sim/base_pose": -1.0}
        for topic, kind in (("joint_states", JointState), ("sim/base_pose", PoseStamped)):
            self.node.subscribe(topic, kind, self._hearer(topic))
        self._await(lambda: min(self._stamps.values()) >= 0.0, "joint states and base pose")

    def _hearer(self, topic: str) -> Callable[[Any], None]:
        def hear(message: Any) -> None:
            with self._arrived:
                self._stamps[topic] = message.header.stamp.to_sec()
                self._arrived.notify_all()

        return hear

    def _await(self, condition: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + _PATIENCE
        while True:
            with self._arrived:
                if self._arrived.wait_for(condition, _REPETITION):
                    return
            if time.monotonic() > end:
                raise NotManagedError(f"no {what} for {_PATIENCE:g} s of wall time")
            self.repeat()

    def now(self) -> float:
        """Sim time of the newest messages (s)."""
        return min(self._stamps.values())

    def advance(self, seconds: float) -> None:
        """Let so much sim time (s) pass; see `Link.advance`."""
        end = self.now() + seconds
        # Half a period of the messages less, for a stamp may lie a rounding error before its time.
        self._await(lambda: self.now() >= end - 0.005, "joint states and base pose")

    def call(self, service: str, kind: Any, **request: Any) -> Any:
        """Call a service; see `Link.call`."""
        name = self.node.resolve(service)
        try:
            rospy.wait_for_service(name, _PATIENCE)
            return rospy.ServiceProxy(name, kind)(**request)
        except rospy.ROSException as error:
            raise NotManagedError(f"{name}: {error}") from error

    def close(self) -> None:
        """End all subscriptions and publications."""
        with contextlib.suppress(rospy.ROSException):
            self.node.shutdown()
