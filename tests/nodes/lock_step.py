"""A live simulator under a script: paused, and stepped from one look to the next."""

from __future__ import annotations

import time
from typing import Any

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64
from std_srvs.srv import Empty
from telex_msgs.srv import Step

from telex_control.ros.ros_node_handle import RosNodeHandle
from telex_training.operators.port import Command, Drive, JointTargets, Observation, Port
from telex_training.operators.scripted_operator import TICK, DirectOperator
from telex_training.ros.commands import TopicPublishers
from telex_training.ros.observer import Observer

_PATIENCE = 20.0
"""Wall time within which what was asked for has to come (s)."""
_ARRIVAL = 0.01
"""Wall time that commands get to arrive before the next step (s)."""
_TRACKS = "track_controller/cmd_vel"


class LockStep(Port):
    """Takes `Drive` and `JointTargets` for the controllers of the present namespace.

    Sim time advances by ``sim/step``; `operator` is that of the robot.
    """

    def __init__(self, step_size: float) -> None:
        self._step_size = step_size
        self._pause = rospy.ServiceProxy("sim/pause", Empty)
        self._step = rospy.ServiceProxy("sim/step", Step, persistent=True)
        node = RosNodeHandle()
        self._observer = Observer(node)
        self._publishers = TopicPublishers(node)
        # Made now, so that it is connected by the first command.
        self._publishers.publisher(_TRACKS, Twist)
        self.operator = DirectOperator(self)

    def begin(self) -> None:
        """Pause, once the robot's messages come, and look at it."""
        self._await("joint states and base pose", lambda: self._observer.time >= 0.0)
        self._pause.wait_for_service(_PATIENCE)
        self._pause()
        self.advance(TICK)
        self.operator.look()

    def observe(self) -> Observation:
        return self._observer.observation()

    def advance(self, seconds: float) -> None:
        time.sleep(_ARRIVAL)
        before = self._observer.stamps
        answer = self._step(steps=round(seconds / self._step_size))
        assert answer.success, f"sim/step: {answer.message}"
        self._await(
            "joint states and base pose after a step",
            lambda: all(stamp > before[topic] for topic, stamp in self._observer.stamps.items()),
        )

    def send(self, command: Command) -> None:
        if isinstance(command, Drive):
            message = Twist()
            message.linear.x, message.angular.z = command.linear, command.angular
            self._publishers.publish(_TRACKS, message)
        elif isinstance(command, JointTargets):
            for joint, position in command.positions.items():
                stem = joint[: -len("_joint")]
                self._publishers.publish(f"{stem}_position_controller/command", Float64(position))
        else:
            raise TypeError(f"the controllers take Drive and JointTargets, not {command!r}")

    def _await(self, what: str, condition: Any) -> None:
        with self._observer.arrived:
            arrived = self._observer.arrived.wait_for(condition, _PATIENCE)
        assert arrived, f"no {what} within {_PATIENCE:g} s"
