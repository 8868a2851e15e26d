"""ROS edge of the keyboard: the robot's teleoperation nodes as the operator's side sees them."""

from __future__ import annotations

import threading
import time
from typing import Any, Dict, Optional, Tuple

import rospy
from control_msgs.msg import JointJog
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import SetBool
from telex_msgs.msg import (
    CartesianTeleopStatus,
    FlipperPresetHold,
    FlipperPresets,
    JointTeleopStatus,
    SimStatus,
    TrackTeleopStatus,
)
from telex_msgs.srv import SetMode

from telex_teleop.e_stop_state import EStopState
from telex_teleop.keyboard.commands import NO_NAME, Commands
from telex_teleop.keyboard.map import NODES
from telex_teleop.keyboard.screen import JointView, NodeView, ToolView, roll_pitch_yaw
from telex_teleop.track_drive import STANDSTILL, Velocity

__all__ = ["Robot"]

SERVICE_TIMEOUT = 2.0  # s
# Our own wish for the speed counts this long (s) before a status must have confirmed it.
SPEED_PENDING = 0.5


class Robot:
    """Publishes commands to one robot and remembers what its nodes say.

    Parameters
    ----------
    namespace
        Absolute name of the robot's namespace, ``/telex``.
    """

    def __init__(self, namespace: str) -> None:
        self.namespace = namespace
        self.notice = ""
        self._e_stop = EStopState()
        self._statuses: Dict[str, Tuple[float, Any]] = {}
        self._speed_wish: Tuple[float, float] = (-SPEED_PENDING, 1.0)
        self._request: Optional[threading.Thread] = None
        self._frame = ""
        self._cartesian: Optional[Any] = None
        self._jogs = {
            node: self._publisher(f"{node}_teleop/delta_joint_cmds", JointJog) for node in NODES
        }
        self._twist = self._publisher("track_teleop/cmd_vel", Twist)
        self._preset = self._publisher("flipper_teleop/preset_cmds", FlipperPresetHold)
        self._presets: Optional[Tuple[str, ...]] = None
        self._tool = self._publisher("arm_teleop/delta_twist_cmds", TwistStamped)
        self._pose = self._publisher("arm_teleop/named_pose_cmds", String)
        # Made now, for a press must reach the robot even when the master is gone by then. Latched,
        # but an idle keyboard holds no message of its own.
        self._e_stop_publisher = self._publisher("e_stop", Bool, latch=True)
        self._speeds = [self._publisher(f"{node}_teleop/speed_scale", Float64) for node in NODES]
        self._speeds.append(self._publisher("track_teleop/speed_scale", Float64))
        for node in NODES:
            self._listen(f"{node}_teleop/status", JointTeleopStatus, self._on_status, node)
        self._listen("track_teleop/status", TrackTeleopStatus, self._on_status, "tracks")
        self._listen("flipper_teleop/presets", FlipperPresets, self._on_presets)
        self._listen("arm_teleop/cartesian_status", CartesianTeleopStatus, self._on_cartesian)
        self._listen("e_stop", Bool, self._on_e_stop)
        self._listen("sim/status", SimStatus, self._on_sim_status)

    @property
    def e_stop(self) -> bool:
        """Whether the emergency stop is set."""
        return self._e_stop.active

    def send(self, commands: Commands) -> None:
        """Publish commands."""
        stamp = rospy.Time.now()
        for node, rates in commands.jogs.items():
            jog = JointJog(joint_names=list(rates), velocities=list(rates.values()))
            jog.header.stamp = stamp
            self._jogs[node].publish(jog)
        for velocity in commands.drive:
            twist = Twist()
            twist.linear.x = velocity.linear
            twist.angular.z = velocity.angular
            self._twist.publish(twist)
        for name in commands.preset:
            self._send_preset(name, stamp)
        for tool in commands.tool:
            self._send_twist(tool, stamp)
        for name in commands.pose:
            self._pose.publish(String(name))

    def _send_preset(self, name: str, stamp: Any) -> None:
        there = self._presets
        if name != NO_NAME and there is not None and name not in there:
            self.notice = f"preset {name}: the robot has {', '.join(there) or 'no presets'}"
            return
        message = FlipperPresetHold(preset=name)
        message.header.stamp = stamp
        self._preset.publish(message)

    def _send_twist(self, rates: Tuple[float, ...], stamp: Any) -> None:
        message = TwistStamped()
        message.header.stamp = stamp
        message.header.frame_id = self.frame
        linear, angular = message.twist.linear, message.twist.angular
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = rates
        self._tool.publish(message)

    def change_speed(self, factor: float) -> None:
        """Multiply the speed scale of all nodes, within their bounds."""
        present = self.speed_scale
        if present is None:
            self.notice = "speed: no answer from the robot"
            return
        status = self._latest_status()
        wish = max(status.min_speed_scale, min(status.max_speed_scale, present * factor))
        self._speed_wish = (time.monotonic(), wish)
        for publisher in self._speeds:
            publisher.publish(Float64(wish))

    def set_e_stop(self, active: bool) -> None:
        """Set or release the emergency stop."""
        self._e_stop_publisher.publish(Bool(active))

    def toggle_mode(self) -> None:
        """Ask the arm for its other mode; the answer comes as a notice."""
        wanted = "JOINT" if self.mode == "CARTESIAN" else "CARTESIAN"
        self._ask("mode", "arm_teleop/set_mode", SetMode, wanted)

    def toggle_hold(self) -> None:
        """Let the tool keep its place in the world while the base moves, or no longer."""
        held = self._cartesian is not None and self._cartesian.holds_tool
        self._ask("hold tool", "arm_teleop/hold_tool", SetBool, not held)

    def next_frame(self) -> None:
        """Move the tool along the axes of the next frame from now on."""
        if self._cartesian is None:
            self.notice = "frame: no answer from the arm"
            return
        frames = list(self._cartesian.frames)
        self._frame = frames[(frames.index(self.frame) + 1) % len(frames)]

    @property
    def frame(self) -> str:
        """Frame along whose axes the tool moves, empty before the arm has named any."""
        if self._cartesian is None:
            return ""
        if self._frame in self._cartesian.frames:
            return self._frame
        return str(self._cartesian.default_frame)

    @property
    def tool(self) -> Optional[ToolView]:
        """Where the tool is, None before the arm's first status."""
        if self._cartesian is None:
            return None
        pose = self._cartesian.tool
        turned = pose.orientation
        position = (pose.position.x, pose.position.y, pose.position.z)
        return ToolView(
            self.frame, position, roll_pitch_yaw(turned.x, turned.y, turned.z, turned.w)
        )

    @property
    def arm_notice(self) -> str:
        """What there is to know of the arm's motion, empty where nothing."""
        status = self._statuses.get("arm")
        return "" if status is None else str(status[1].notice)

    @property
    def mode(self) -> Optional[str]:
        """Mode of the arm, None before its first status."""
        status = self._statuses.get("arm")
        return None if status is None else str(status[1].mode)

    @property
    def speed_scale(self) -> Optional[float]:
        """The operator's speed, None before the first status."""
        asked, wish = self._speed_wish
        if time.monotonic() - asked < SPEED_PENDING:
            return wish
        status = self._latest_status()
        return None if status is None else float(status.speed_scale)

    @property
    def drive(self) -> Velocity:
        """What goes to the tracks now."""
        status = self._statuses.get("tracks")
        if status is None:
            return STANDSTILL
        return Velocity(status[1].command.linear.x, status[1].command.angular.z)

    def node_views(self) -> Dict[str, NodeView]:
        """Return what the nodes say, by name."""
        now = time.monotonic()
        return {
            node: NodeView(now - received, bool(status.active), str(status.message))
            for node, (received, status) in list(self._statuses.items())
        }

    def joint_views(self) -> Dict[str, JointView]:
        """Return all joints that the nodes report."""
        return {
            name: JointView(position, name in status.limited)
            for node, (_, status) in list(self._statuses.items())
            if node != "tracks"
            for name, position in zip(status.joint_names, status.position)
        }

    def _latest_status(self) -> Any:
        statuses = sorted(self._statuses.values(), key=lambda entry: entry[0])
        return statuses[-1][1] if statuses else None

    def _publisher(self, name: str, kind: Any, latch: bool = False) -> rospy.Publisher:
        return rospy.Publisher(
            f"{self.namespace}/{name}", kind, queue_size=10, latch=latch, tcp_nodelay=True
        )

    def _listen(self, name: str, kind: Any, callback: Any, argument: Optional[str] = None) -> None:
        rospy.Subscriber(
            f"{self.namespace}/{name}",
            kind,
            callback,
            callback_args=argument,
            queue_size=1,
            tcp_nodelay=True,
        )

    def _on_status(self, message: Any, node: str) -> None:
        self._statuses[node] = (time.monotonic(), message)

    def _on_presets(self, message: Any) -> None:
        self._presets = tuple(message.names)

    def _on_e_stop(self, message: Any) -> None:
        self._e_stop.take_request(bool(message.data))

    def _on_sim_status(self, message: Any) -> None:
        self._e_stop.take_status(bool(message.e_stop))

    def _on_cartesian(self, message: Any, _argument: Any = None) -> None:
        self._cartesian = message

    def _ask(self, what: str, service: str, kind: Any, wanted: Any) -> None:
        """Call a service beside everything else; the answer comes as a notice."""
        if self._request is not None and self._request.is_alive():
            return
        name = f"{self.namespace}/{service}"
        self._request = threading.Thread(
            target=self._call, args=(what, name, kind, wanted), daemon=True
        )
        self._request.start()

    def _call(self, what: str, name: str, kind: Any, wanted: Any) -> None:
        try:
            rospy.wait_for_service(name, SERVICE_TIMEOUT)
            answer = rospy.ServiceProxy(name, kind)(wanted)
        except rospy.ROSException:
            self.notice = f"{what}: no answer from {name}"
            return
        except rospy.ServiceException as error:
            self.notice = f"{what}: {error}"
            return
        self.notice = "" if answer.success else str(answer.message)
