"""What the teleoperation nodes share at their ROS edge."""

from __future__ import annotations

import threading
import time
from typing import Any, Callable

import rospy
from std_msgs.msg import Bool, Float64

from telex_teleop.limits import LimitsError
from telex_teleop.settings import Section, SettingsError
from telex_teleop.speed import SpeedScale

__all__ = [
    "OperatorInputs",
    "StatusTimer",
    "private_settings",
    "run_node",
    "wait_for_robot_description",
]

WARNING_PERIOD = 2.0  # s between two warnings of one kind


def private_settings() -> Section:
    """Return the node's private parameters."""
    return Section(rospy.get_param("~", {}), rospy.get_name())


def wait_for_robot_description() -> str:
    """Return the URDF of this namespace, as soon as it is there.

    Raises
    ------
    rospy.ROSInterruptException
        When the node is shut down meanwhile.
    """
    name = rospy.resolve_name("robot_description")
    reminded = -30.0
    while not rospy.is_shutdown():
        description = rospy.get_param(name, None)
        if description is not None:
            return str(description)
        # Not rospy's throttle and sleep: sim time need not run before there is a robot.
        if time.monotonic() - reminded >= 10.0:
            reminded = time.monotonic()
            rospy.logwarn(f"waiting for the parameter {name}; the simulator's launch file sets it")
        time.sleep(0.25)
    raise rospy.ROSInterruptException("shut down while waiting for robot_description")


class StatusTimer:
    """Calls a function at a rate of wall time, so that displays also hear from a paused simulation.

    Parameters
    ----------
    rate
        Calls per second.
    publish
        What to call.
    """

    def __init__(self, rate: float, publish: Callable[[], None]) -> None:
        self._period = 1.0 / rate
        self._publish = publish
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="status", daemon=True)
        rospy.on_shutdown(self._ended.set)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(self._period):
            try:
                self._publish()
            except rospy.ROSException:
                # the topics are closed before this thread learns of the shutdown
                return


class OperatorInputs:
    """The two inputs that every teleoperation node has: ``~speed_scale`` and ``e_stop``.

    Parameters
    ----------
    speed
        Set by ``~speed_scale``.
    set_e_stop
        Called with the state of the emergency stop.
    lock
        Held during both.
    """

    def __init__(
        self, speed: SpeedScale, set_e_stop: Callable[[bool], None], lock: threading.Lock
    ) -> None:
        self._speed = speed
        self._set_e_stop = set_e_stop
        self._lock = lock
        rospy.Subscriber(
            "~speed_scale", Float64, self._on_speed_scale, queue_size=10, tcp_nodelay=True
        )
        rospy.Subscriber("e_stop", Bool, self._on_e_stop, queue_size=10, tcp_nodelay=True)

    def _on_speed_scale(self, message: Any) -> None:
        try:
            with self._lock:
                self._speed.set(message.data)
        except ValueError as error:
            rospy.logwarn_throttle(WARNING_PERIOD, f"dropped: {error}")

    def _on_e_stop(self, message: Any) -> None:
        with self._lock:
            self._set_e_stop(bool(message.data))


def run_node(name: str, start: Callable[[], object]) -> int:
    """Run a node until it is shut down.

    Parameters
    ----------
    name
        Default name of the node.
    start
        Makes the node; what it returns is kept alive.

    Returns
    -------
    int
        Exit status: 1 when its parameters or the robot description are wrong.
    """
    rospy.init_node(name)
    try:
        node = start()
    except (SettingsError, LimitsError) as error:
        rospy.logfatal(f"{rospy.get_name()} cannot start: {error}")
        return 1
    except rospy.ROSInterruptException:
        return 0
    rospy.spin()
    del node
    return 0
