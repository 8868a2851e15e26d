"""A port to a live robot that runs by itself."""

from __future__ import annotations

import contextlib
import time
from typing import Any, Callable, Optional

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool, Float64
from telex_msgs.msg import SimStatus
from telex_msgs.srv import AnswerQuestion, SetMode

from telex_control.ros.ros_node_handle import RosNodeHandle

from ..operators.port import CameraView, Command, NotManagedError, Observation, TeleopPort
from .camera import CameraTopics
from .commands import TopicPublishers, message_of
from .object_poses import ObjectPoses
from .observer import Observer

_PATIENCE = 30.0
"""Wall time within which what is expected has to come (s)."""

_REPETITION = 0.08
"""Wall time after which keys that are held are repeated (s)."""


class LiveRobot(TeleopPort):
    """A robot by the topics that console and joystick use; close it when done.

    Parameters
    ----------
    namespace : str
        Of the robot.

    Attributes
    ----------
    node : RosNodeHandle
        Of the robot's namespace.

    Raises
    ------
    NotManagedError
        No message of the robot comes.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__()
        self.node = RosNodeHandle(namespace)
        self.urdf = self.node.param("robot_description", str)
        self._observer = Observer(self.node)
        self._publishers = TopicPublishers(self.node)
        # Made now, so that they are connected by the first command.
        self._publishers.publisher("track_teleop/cmd_vel", Twist)
        self._publishers.publisher("e_stop", Bool)
        self._stopped: Optional[bool] = None
        self.node.subscribe("sim/status", SimStatus, self._on_status)
        self._objects: Optional[ObjectPoses] = None
        self._await(lambda: self._observer.time >= 0.0, "joint states and base pose")

    def _await(self, condition: Callable[[], bool], what: str) -> None:
        end, arrived = time.monotonic() + _PATIENCE, self._observer.arrived
        while True:
            with arrived:
                if arrived.wait_for(condition, _REPETITION):
                    return
            if time.monotonic() > end:
                raise NotManagedError(f"no {what} for {_PATIENCE:g} s of wall time")
            self.repeat()

    def observe(self) -> Observation:
        """See `Port.observe`."""
        return self._observer.observation()

    def advance(self, seconds: float) -> None:
        """See `Port.advance`."""
        end = self._observer.time + seconds
        # Half a period of the messages less, for a stamp may lie a rounding error before its time.
        self._await(lambda: self._observer.time >= end - 0.005, "joint states and base pose")

    def send(self, command: Command) -> None:
        """See `Port.send`."""
        self._publishers.publish(*message_of(command))

    def set_mode(self, name: str) -> None:
        """See `TeleopPort.set_mode`."""
        answer = self.call("arm_teleop/set_mode", SetMode, mode=name)
        if not answer.success:
            raise NotManagedError(f"arm_teleop/set_mode {name}: {answer.message}")

    def e_stop(self, active: bool) -> None:
        """See `TeleopPort.e_stop`; returns once the robot's status confirms it.

        Raises
        ------
        NotManagedError
            It does not.
        """

        def confirmed() -> bool:
            if self._stopped is not active:
                self._publishers.publish("e_stop", Bool(active))
            return self._stopped is active

        wanted = "emergency stop" if active else "release of the emergency stop"
        self._await(confirmed, f"{wanted} in sim/status")

    def _on_status(self, message: Any) -> None:
        self._stopped = bool(message.e_stop)

    def zoom(self, camera: str, factor: float) -> None:
        """See `TeleopPort.zoom`."""
        self._tell(f"cameras/{camera}/zoom", Float64(factor))

    def _tell(self, topic: str, message: Any) -> None:
        """Publish what is said once, once somebody hears it."""
        publisher = self._publishers.publisher(topic, type(message))
        self._await(publisher.has_subscribers, f"node that hears {topic}")
        publisher.publish(message)

    def camera(self, name: str) -> CameraView:
        """See `TeleopPort.camera`."""
        # A handle of its own: nothing is drawn for a view that is closed.
        return CameraTopics(self.node.child(f"cameras/{name}"))

    def object_pose(self, name: str) -> Optional[np.ndarray]:
        """See `TeleopPort.object_pose`; the first call waits for the scene.

        Raises
        ------
        NotManagedError
            The simulator tells nothing of the scene.
        """
        if self._objects is None:
            self._objects = ObjectPoses(self.node)
        objects = self._objects
        if not objects.known:
            self._await(lambda: objects.known, "poses of the scene")
        return objects.find(name)

    def answer(self, question: str, answer: str) -> None:
        """See `TeleopPort.answer`."""
        said = self.call("training/answer", AnswerQuestion, question=question, answer=answer)
        if not said.success:
            raise NotManagedError(f"training/answer {question}: {said.message}")

    def call(self, service: str, kind: Any, **request: Any) -> Any:
        """Call a service in the robot's namespace.

        Raises
        ------
        NotManagedError
            It refuses, or is not there.
        """
        name = self.node.resolve(service)
        try:
            rospy.wait_for_service(name, _PATIENCE)
            return rospy.ServiceProxy(name, kind)(**request)
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise NotManagedError(f"{name}: {error}") from error

    def close(self) -> None:
        """End all subscriptions and publications."""
        with contextlib.suppress(rospy.ROSException):
            self.node.shutdown()
