"""ROS edge of the joint teleoperation nodes: topics to core, core to topics."""

from __future__ import annotations

import math
import threading
import time
from typing import Any, Dict, List, Optional

import rospy
from control_msgs.msg import JointJog
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from telex_msgs.msg import JointTeleopStatus

from telex_control.ros.rospy_fixes.connections import sender_of
from telex_control.urdf.joints import short_name
from telex_teleop.joints.joint_teleop import JOINT_MODE, JointTeleop
from telex_teleop.motion.idle_rest import IdleRest
from telex_teleop.motion.joint_jog import InvalidCommand, parse_joint_jog
from telex_teleop.ros.common import OperatorInputs, StatusTimer, command, warn_dropped


class JointTeleopNode:
    """Passes inputs to a core and publishes its outputs.

    One update per message on ``joint_states``; publishes on ``<joint without
    _joint>_position_controller/command``.

    Parameters
    ----------
    core
        What decides; used from rospy's threads under a lock.
    status_rate
        Messages on ``~status`` per second.
    """

    def __init__(self, core: JointTeleop, status_rate: float) -> None:
        self._core = core
        self._lock = threading.Lock()
        self._rest = IdleRest()
        self._names: List[str] = []
        self._indices: Optional[Dict[str, int]] = None
        self._controllers = {
            joint: rospy.Publisher(command_topic(joint), Float64, queue_size=1, tcp_nodelay=True)
            for joint in core.output_joints
        }
        self._status = rospy.Publisher("~status", JointTeleopStatus, queue_size=1)
        self._inputs = OperatorInputs(core, self._lock)
        self._listen()
        # last, for the first joint state begins the time in which running streams are looked for
        rospy.Subscriber(
            "joint_states", JointState, self._on_joint_states, queue_size=1, tcp_nodelay=True
        )
        self._timer = StatusTimer(status_rate, self.publish_status)

    def _listen(self) -> None:
        """Listen to commands."""
        rospy.Subscriber(
            "~delta_joint_cmds", JointJog, self._on_jog, queue_size=10, tcp_nodelay=True
        )

    @property
    def _mode(self) -> str:
        return JOINT_MODE

    def publish_status(self) -> None:
        """Publish the present state on ``~status``."""
        with self._lock:
            state = self._core.state(time.monotonic())
            speed = self._core.speed
            scale, minimum, maximum = speed.value, speed.minimum, speed.maximum
        message = JointTeleopStatus(
            mode=self._mode,
            active=state.active,
            # without what tells apart the clients of one node
            commanders=sorted({name.partition(" ")[0] for name in state.commanders}),
            speed_scale=scale,
            min_speed_scale=minimum,
            max_speed_scale=maximum,
            joint_names=[axis.name for axis in state.axes],
            reference=[axis.reference for axis in state.axes],
            position=[axis.position for axis in state.axes],
            max_velocity=[axis.max_velocity for axis in state.axes],
            limited=[axis.name for axis in state.axes if axis.limited],
            message=state.message,
            notice=state.notice,
        )
        message.header.stamp = rospy.Time.now()
        self._status.publish(message)

    def _on_jog(self, message: Any) -> None:
        arrival = time.monotonic()
        try:
            jog = parse_joint_jog(
                message.joint_names,
                message.displacements,
                message.velocities,
                message.duration,
                self._core.commanded_names,
            )
            with self._lock:
                self._core.receive(jog, arrival, sender_of(message))
            self._rest.wake()
        except InvalidCommand as error:
            warn_dropped("~delta_joint_cmds", str(error))

    def _on_joint_states(self, message: Any) -> None:
        arrival = time.monotonic()
        commands = self._rest.commands
        positions = self._positions(message)
        if positions is None:
            return
        stamp = message.header.stamp.to_sec()
        with self._lock:
            references = self._core.update(stamp, arrival, positions)
            idle = self._core.idle
        for joint, reference in references.items():
            command(self._controllers[joint], Float64(reference))
        self._after_update()
        self._rest.settle(idle, commands, stamp, arrival)

    def _after_update(self) -> None:
        """Do what is due after each joint state."""

    def _positions(self, message: Any) -> Optional[Dict[str, float]]:
        """Return the measured positions; None for a message that lacks one or holds NaN."""
        if message.name != self._names:
            self._names = message.name
            self._indices = self._find_joints(message.name)
        if self._indices is None:
            return None
        try:
            positions = {joint: message.position[index] for joint, index in self._indices.items()}
        except IndexError:
            self._warn(f"{len(message.position)} positions for {len(message.name)} names")
            return None
        for joint, position in positions.items():
            if not math.isfinite(position):
                self._warn(f"position of {joint} is {position!r}; must be a finite number")
                return None
        return positions

    def _find_joints(self, names: List[str]) -> Optional[Dict[str, int]]:
        """Return where our joints stand; None, with a warning, when some of them are missing."""
        joints = self._core.measured_joints
        missing = [joint for joint in joints if joint not in names]
        # other publishers may share the topic with joints that are none of ours
        if missing and len(missing) < len(joints):
            self._warn(
                f"{', '.join(missing)} missing; all joints of this node must be in one message"
            )
        return None if missing else {joint: names.index(joint) for joint in joints}

    @staticmethod
    def _warn(problem: str) -> None:
        warn_dropped("joint_states", problem)


def command_topic(joint: str) -> str:
    """Return the topic of a joint's position controller, named after it without ``_joint``."""
    return f"{short_name(joint)}_position_controller/command"
