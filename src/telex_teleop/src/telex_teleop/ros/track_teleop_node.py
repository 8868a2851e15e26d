"""ROS edge of the track teleoperation node."""

from __future__ import annotations

import threading
import time
from typing import Any

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from telex_msgs.msg import TrackTeleopStatus

from telex_control.ros.rospy_fixes.connections import open_publishers, sender_of
from telex_teleop.motion.idle_rest import IdleRest
from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.ros.common import (
    OperatorInputs,
    StatusTimer,
    command,
    private_settings,
    run_node,
    warn_dropped,
)
from telex_teleop.tracks.track_drive import (
    STANDSTILL,
    TrackDrive,
    TrackSettings,
    Velocity,
    parse_twist,
)


class TrackTeleopNode:
    """Passes inputs to the core and publishes its commands on ``<controller>/cmd_vel``.

    Parameters
    ----------
    core
        What decides; used from rospy's threads under a lock.
    """

    def __init__(self, core: TrackDrive) -> None:
        self._core = core
        self._lock = threading.Lock()
        self._rest = IdleRest()
        self._output = rospy.Publisher(
            f"{core.settings.controller}/cmd_vel", Twist, queue_size=1, tcp_nodelay=True
        )
        self._status = rospy.Publisher("~status", TrackTeleopStatus, queue_size=1)
        self._inputs = OperatorInputs(core, self._lock)
        self._commands = rospy.Subscriber(
            "~cmd_vel", Twist, self._on_twist, queue_size=10, tcp_nodelay=True
        )
        # Joint states set the pace: nothing is sent while the simulation stands still.
        rospy.Subscriber(
            "joint_states", JointState, self._on_joint_states, queue_size=1, tcp_nodelay=True
        )
        rospy.on_shutdown(self._stop_driving)
        self._timer = StatusTimer(core.settings.status_rate, self.publish_status)

    def publish_status(self) -> None:
        """Publish the present state on ``~status``."""
        with self._lock:
            state = self._core.state(time.monotonic())
            speed = self._core.speed
            scale, minimum, maximum = speed.value, speed.minimum, speed.maximum
        message = TrackTeleopStatus(
            active=bool(state.commanders),
            commanders=state.commanders,
            speed_scale=scale,
            min_speed_scale=minimum,
            max_speed_scale=maximum,
            max_linear=self._core.settings.max_linear,
            max_angular=self._core.settings.max_angular,
            command=_twist(state.command),
            message=state.message,
        )
        message.header.stamp = rospy.Time.now()
        self._status.publish(message)

    def _on_twist(self, message: Any) -> None:
        arrival = time.monotonic()
        components = {
            f"{part}.{axis}": getattr(getattr(message, part), axis)
            for part in ("linear", "angular")
            for axis in "xyz"
        }
        try:
            velocity, ignored = parse_twist(components)
        except InvalidCommand as error:
            warn_dropped("~cmd_vel", str(error))
            return
        if ignored:
            rospy.logwarn_once(
                f"{rospy.resolve_name('~cmd_vel')}: {', '.join(ignored)} ignored; "
                "tracks follow linear.x and angular.z only"
            )
        with self._lock:
            self._core.receive(velocity, arrival, sender_of(message))
        self._rest.wake()

    def _on_joint_states(self, message: Any) -> None:
        arrival = time.monotonic()
        commands = self._rest.commands
        # other publishers may share the topic, each with stamps of its own
        if self._core.settings.pulse_joint not in message.name:
            return
        stamp = message.header.stamp.to_sec()
        with self._lock:
            self._core.keep(open_publishers(self._commands))
            velocity = self._core.update(stamp, arrival)
            idle = self._core.idle
        if velocity is not None:
            command(self._output, _twist(velocity))
        self._rest.settle(idle, commands, stamp, arrival)

    def _stop_driving(self) -> None:
        with self._lock:
            driving = self._core.state(time.monotonic()).command != STANDSTILL
        if driving:
            self._output.publish(_twist(STANDSTILL))


def _twist(velocity: Velocity) -> Twist:
    twist = Twist()
    twist.linear.x = velocity.linear
    twist.angular.z = velocity.angular
    return twist


def _start() -> TrackTeleopNode:
    settings = private_settings(TrackSettings)
    return TrackTeleopNode(TrackDrive(settings, settings.speed_scale()))


def track_main() -> int:
    """Run the node that drives the tracks."""
    return run_node("track_teleop", _start)
