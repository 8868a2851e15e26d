"""Common parts of the teleoperation nodes at their ROS edge."""

from __future__ import annotations

import threading
import time
from typing import Any, Callable, Dict, Optional, Type, TypeVar

import rospy
from std_msgs.msg import Bool, Float64
from telex_msgs.msg import SimStatus

from telex_control.common.params import ConfigError, read_config
from telex_control.ros.node_start import init_node
from telex_control.urdf.joints import UrdfError
from telex_teleop.motion.e_stop_state import EStopState
from telex_teleop.motion.teleop_core import TeleopCore

Settings = TypeVar("Settings")

WARNING_PERIOD = 2.0  # s between two warnings of one kind
# rospy's own throttle goes by the line of code, which is one for all topics
_warned: Dict[str, float] = {}


def private_settings(kind: Type[Settings]) -> Settings:
    """Return the node's private parameters.

    Parameters
    ----------
    kind
        Dataclass to read them into.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is missing, unknown or wrong.
    """
    return read_config(kind, rospy.get_param("~", {}), rospy.get_name())


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
    """Subscriptions of every teleoperation node: ``~speed_scale``, ``e_stop`` and ``sim/status``.

    Parameters
    ----------
    core
        What is told of them.
    lock
        Held meanwhile.
    """

    def __init__(self, core: TeleopCore, lock: threading.Lock) -> None:
        self._core = core
        self._lock = lock
        self._e_stop = EStopState()
        self._resets: Optional[int] = None
        rospy.Subscriber(
            "~speed_scale", Float64, self._on_speed_scale, queue_size=10, tcp_nodelay=True
        )
        rospy.Subscriber("e_stop", Bool, self._on_e_stop, queue_size=10, tcp_nodelay=True)
        rospy.Subscriber(
            "sim/status", SimStatus, self._on_sim_status, queue_size=10, tcp_nodelay=True
        )

    def _on_speed_scale(self, message: Any) -> None:
        try:
            with self._lock:
                self._core.speed.set(message.data)
        except ValueError as error:
            warn_dropped("~speed_scale", str(error))

    def _on_e_stop(self, message: Any) -> None:
        with self._lock:
            self._e_stop.take_request(bool(message.data))
            self._core.set_e_stop(self._e_stop.active)

    def _on_sim_status(self, message: Any) -> None:
        with self._lock:
            self._e_stop.take_status(bool(message.e_stop))
            self._core.set_e_stop(self._e_stop.active)
            if self._resets is not None and message.resets != self._resets:
                self._core.restart(message.header.stamp.to_sec())
            self._resets = message.resets


def warn_dropped(topic: str, problem: str) -> None:
    """Warn that a message was not obeyed, and why; throttled by topic."""
    _warn(topic, f"message on {rospy.resolve_name(topic)} dropped: {problem}")


def command(publisher: rospy.Publisher, message: Any) -> None:
    """Publish a command; warn, throttled by topic, where nobody listens to it."""
    publisher.publish(message)
    if publisher.get_num_connections() == 0:
        topic = publisher.resolved_name
        _warn(topic, f"nobody listens to {topic}, so nothing moves: is its controller loaded?")


def _warn(topic: str, words: str) -> None:
    now = time.monotonic()
    if now - _warned.get(topic, -WARNING_PERIOD) >= WARNING_PERIOD:
        _warned[topic] = now
        rospy.logwarn(words)


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
    init_node(name, coarse_clock=True, prompt=True)
    try:
        node = start()
    except (ConfigError, UrdfError) as error:
        rospy.logfatal(f"{rospy.get_name()} cannot start: {error}")
        return 1
    except rospy.ROSInterruptException:
        return 0
    rospy.spin()
    del node
    return 0
