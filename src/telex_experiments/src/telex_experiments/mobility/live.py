"""A live simulator under a script: paused, and stepped from one look to the next."""

from __future__ import annotations

import time
from typing import Any

import rospy
from std_srvs.srv import Empty
from telex_msgs.srv import Step

from telex_control.ros.ros_node_handle import RosNodeHandle
from telex_training.operators.scripted_operator import TICK, DirectOperator
from telex_training.ros.controllers import ControllerTopics

_PATIENCE = 20.0
"""Wall time within which what was asked for has to come (s)."""
_ARRIVAL = 0.01
"""Wall time that commands get to arrive before the next step (s)."""


class LiveError(RuntimeError):
    """The simulator does not do its part; the message says which."""


class LockStep:
    """Advances a live simulator, in the present namespace, by ``sim/step``.

    Parameters
    ----------
    step_size : float
        Of its physics (s).

    Attributes
    ----------
    operator : DirectOperator
        Of the robot in this namespace.
    """

    def __init__(self, step_size: float) -> None:
        self._step_size = step_size
        self._pause = rospy.ServiceProxy("sim/pause", Empty)
        self._step = rospy.ServiceProxy("sim/step", Step, persistent=True)
        port = ControllerTopics(RosNodeHandle(), self._advance)
        self._observer = port.observer
        self.operator = DirectOperator(port)

    def begin(self) -> None:
        """Pause, once the robot's messages come, and look at it."""
        self._await("joint states and base pose", lambda: self._observer.time >= 0.0)
        self._pause.wait_for_service(_PATIENCE)
        self._pause()
        self._advance(TICK)
        self.operator.look()

    def _await(self, what: str, condition: Any) -> None:
        with self._observer.arrived:
            if not self._observer.arrived.wait_for(condition, _PATIENCE):
                raise LiveError(f"no {what} within {_PATIENCE:g} s")

    def _advance(self, seconds: float) -> None:
        time.sleep(_ARRIVAL)
        before = self._observer.stamps
        answer = self._step(steps=round(seconds / self._step_size))
        if not answer.success:
            raise LiveError(f"sim/step: {answer.message}")
        self._await(
            "joint states and base pose after a step",
            lambda: all(stamp > before[topic] for topic, stamp in self._observer.stamps.items()),
        )
