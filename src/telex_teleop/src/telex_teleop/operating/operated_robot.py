"""ROS edge of the operator's devices: the robot's teleoperation nodes, cameras and lamps."""

from __future__ import annotations

import math
import time
from typing import Any, Dict, List, Optional, Sequence, Tuple

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
    LinkState,
    SimStatus,
    TrackTeleopStatus,
)
from telex_msgs.srv import Bookmark, Restore, SetMode

from telex_teleop.actions.grammar import NODES
from telex_teleop.motion.e_stop_state import EStopState
from telex_teleop.motion.speed import MAX_ZOOM, ZOOM_RATE, stepped
from telex_teleop.operating.commander import NO_NAME, Commands, PresetCommand
from telex_teleop.operating.requests import Requests
from telex_teleop.operating.zoom import ZoomFactor
from telex_teleop.tracks.track_drive import Velocity

# Time (s) for which a requested speed counts before a status has to confirm it.
SPEED_PENDING = 0.5
# The one camera that pans, tilts and zooms.
ZOOM_TOPIC = "cameras/turret/zoom"

_ECHO_WITHIN = 1.0
"""Time (s) in which the camera's factor may be one from before what was sent last."""


class OperatedRobot:
    """Publishes commands to one robot and remembers what its nodes say.

    Parameters
    ----------
    namespace
        Absolute name of the robot's namespace, ``/telex``.
    lamps
        Names of the lamps that can be switched.
    zoom_rate
        How fast a full demand zooms (1/s, of the factor's logarithm).
    """

    def __init__(
        self,
        namespace: str,
        lamps: Sequence[str] = (),
        zoom_rate: float = ZOOM_RATE,
        max_zoom: float = MAX_ZOOM,
    ) -> None:
        self.namespace = namespace
        self._notice = ""
        self._e_stop = EStopState()
        self._link: Optional[Any] = None
        self._moves = False
        self._statuses: Dict[str, Tuple[float, Any]] = {}
        self._speed_wish: Tuple[float, float] = (-SPEED_PENDING, 1.0)
        self._requests = Requests(self._tell)
        self._frame = ""
        self._cartesian: Optional[Any] = None
        self._zoom_rate = zoom_rate
        self._zoom = ZoomFactor(max_zoom)
        self._zoomed = -math.inf
        self._levels: Dict[str, float] = dict.fromkeys(lamps, 0.0)
        self._jogs = {
            node: self._publisher(f"{node}_teleop/delta_joint_cmds", JointJog) for node in NODES
        }
        self._twist = self._publisher("track_teleop/cmd_vel", Twist)
        self._preset = self._publisher("flipper_teleop/preset_cmds", FlipperPresetHold)
        self._presets: Optional[Tuple[str, ...]] = None
        self._tool = self._publisher("arm_teleop/delta_twist_cmds", TwistStamped)
        self._pose = self._publisher("arm_teleop/named_pose_cmds", String)
        # Made now, for a press must reach the robot even when the master is gone by then. Latched,
        # but an idle device holds no message of its own.
        self._e_stop_publisher = self._publisher("e_stop", Bool, latch=True)
        self._speeds = [self._publisher(f"{node}_teleop/speed_scale", Float64) for node in NODES]
        self._speeds.append(self._publisher("track_teleop/speed_scale", Float64))
        self._zoom_publisher = self._publisher(ZOOM_TOPIC, Float64)
        self._lamps = {lamp: self._publisher(f"lamps/{lamp}/command", Float64) for lamp in lamps}
        self._listen_to_robot()

    @property
    def notice(self) -> str:
        """Last message for the operator."""
        return self._notice

    @notice.setter
    def notice(self, text: str) -> None:
        self._tell(text)

    @property
    def e_stop(self) -> bool:
        """Whether the emergency stop is set."""
        return self._e_stop.active

    @property
    def frame(self) -> str:
        """Frame along whose axes the tool moves, empty before the arm has named any."""
        if self._cartesian is None:
            return ""
        if self._frame in self._cartesian.frames:
            return self._frame
        return str(self._cartesian.default_frame)

    @property
    def mode(self) -> Optional[str]:
        """Mode of the arm, None before its first status."""
        status = self._statuses.get("arm")
        return None if status is None else str(status[1].mode)

    @property
    def speed_scale(self) -> Optional[float]:
        """The operator's speed, None before the robot has told one."""
        asked, wish = self._speed_wish
        if time.monotonic() - asked < SPEED_PENDING:
            return wish
        status = self._latest_status()
        return None if status is None else _scale(status.speed_scale)

    @property
    def zoom(self) -> float:
        """Zoom factor of the camera; 1 until it has told one."""
        return self._zoom.value

    @property
    def lit(self) -> Tuple[str, ...]:
        """Lamps that are switched on; none until they have told it."""
        return tuple(lamp for lamp, level in self._levels.items() if level > 0.0)

    # ------------------------------------------------------------ full rates

    def joint(self, node: str, joint: str) -> Optional[float]:
        """Return the largest rate of a joint (rad/s or m/s), None before its node has told it."""
        status = self._statuses.get(node)
        if status is None:
            return None
        limits = dict(zip(status[1].joint_names, status[1].max_velocity))
        return _positive(limits.get(joint))

    def drive(self) -> Optional[Velocity]:
        """Return the largest velocity of the tracks, None before their node has told it."""
        status = self._statuses.get("tracks")
        if status is None:
            return None
        linear, angular = _positive(status[1].max_linear), _positive(status[1].max_angular)
        return None if linear is None or angular is None else Velocity(linear, angular)

    def tool_speed(self) -> Optional[Tuple[float, float]]:
        """Return the largest velocities of the tool (m/s, rad/s), None before the arm told them."""
        status = self._cartesian
        if status is None:
            return None
        linear, angular = _positive(status.max_linear), _positive(status.max_angular)
        return None if linear is None or angular is None else (linear, angular)

    # ------------------------------------------------------------ commands

    @property
    def refused(self) -> bool:
        """Whether the line is impaired, which this device stands before; tells the operator."""
        if self._link is None or self._link.perfect:
            return False
        self.notice = (
            f"refused: the line is set to {self._link.profile}, and what is on the robot's machine "
            "has none; drive from the console"
        )
        return True

    def send(self, commands: Commands) -> None:
        """Publish commands; while the line is impaired stops only."""
        if commands.moves and self.refused:
            if not self._moves:
                return
            commands = commands.stopped()
        self._moves = commands.moves
        stamp = rospy.Time.now()
        for node, demanded in commands.jogs.items():
            rates = self._known(node, demanded)
            if not rates:
                continue
            jog = JointJog(joint_names=list(rates), velocities=list(rates.values()))
            jog.header.stamp = stamp
            self._jogs[node].publish(jog)
        for velocity in commands.drive:
            twist = Twist()
            twist.linear.x = velocity.linear
            twist.angular.z = velocity.angular
            self._twist.publish(twist)
        for preset in commands.preset:
            self._send_preset(preset, stamp)
        for tool in commands.tool:
            self._send_twist(tool, stamp)
        for name in commands.pose:
            self._pose.publish(String(name))
        for share in commands.zoom:
            before = self._zoom.value
            factor = self._zoom.turn(share * self._zoom_rate, time.monotonic())
            if factor != before:
                self._zoomed = time.monotonic()
                self._zoom_publisher.publish(Float64(factor))

    def change_speed(self, direction: int, step: float) -> None:
        """Change the speed scale of all nodes by a step up (`direction` 1) or down (-1)."""
        if self.refused:
            return
        present = self.speed_scale
        status = self._latest_status()
        lowest = highest = None
        if status is not None:
            lowest, highest = _scale(status.min_speed_scale), _scale(status.max_speed_scale)
        if present is None or lowest is None or highest is None:
            self.notice = "speed: no answer from the robot"
            return
        wish = stepped(present, direction, step, lowest, highest)
        self._speed_wish = (time.monotonic(), wish)
        for publisher in self._speeds:
            publisher.publish(Float64(wish))

    def set_e_stop(self, active: bool) -> None:
        """Set or release the emergency stop; to set it is never refused."""
        if not active and self.refused:
            return
        self._e_stop_publisher.publish(Bool(active))

    def set_mode(self, mode: str) -> None:
        """Ask the arm for a mode; when it refuses, the answer comes as a notice."""
        self._ask("mode", "arm_teleop/set_mode", SetMode, mode=mode)

    def toggle_mode(self) -> None:
        """Ask the arm for its other mode."""
        self.set_mode("JOINT" if self.mode == "CARTESIAN" else "CARTESIAN")

    def toggle_hold(self) -> None:
        """Let the tool keep its place in the world while the base moves, or no longer."""
        held = self._cartesian is not None and self._cartesian.holds_tool
        self._ask("hold tool", "arm_teleop/hold_tool", SetBool, data=not held)

    def toggle_guard(self) -> None:
        """Let what is near slow and stop the arm, or no longer."""
        if self._cartesian is None:
            self.notice = "proximity guard: no answer from the arm"
            return
        wanted = not self._cartesian.guard
        self._ask("proximity guard", "arm_teleop/set_proximity_guard", SetBool, data=wanted)

    def set_bookmark(self) -> None:
        """Set a bookmark of the exercise, in practice; when it is refused, a notice says why."""
        self._ask("bookmark", "training/bookmark", Bookmark, name="")

    def go_back(self) -> None:
        """Go on from the newest bookmark of the exercise, in practice."""
        self._ask("go back", "training/back", Restore, name="")

    def next_frame(self) -> None:
        """Move the tool along the axes of the next frame from now on."""
        if self._cartesian is None or not self._cartesian.frames:
            self.notice = "frame: no answer from the arm"
            return
        frames = list(self._cartesian.frames)
        place = frames.index(self.frame) if self.frame in frames else -1
        self._frame = frames[(place + 1) % len(frames)]

    def switch_lamps(self, names: Sequence[str]) -> None:
        """Switch lamps on, or off when one of them is lit."""
        if self.refused:
            return
        level = 0.0 if any(self._levels[name] > 0.0 for name in names) else 1.0
        for name in names:
            self._levels[name] = level
            self._lamps[name].publish(Float64(level))

    def _known(self, node: str, rates: Dict[str, float]) -> Dict[str, float]:
        """Return rates without the stops of joints that this robot lacks.

        The node would refuse the whole message, and with it the stops of all others.
        """
        status = self._statuses.get(node)
        if status is None or not status[1].joint_names:
            return rates
        there = status[1].joint_names
        return {joint: rate for joint, rate in rates.items() if rate != 0.0 or joint in there}

    def _send_preset(self, preset: PresetCommand, stamp: Any) -> None:
        message = FlipperPresetHold(preset=preset.name)
        if preset.name != NO_NAME:
            there = self._presets
            if there is not None and preset.name not in there:
                known = ", ".join(there) or "no presets"
                self.notice = f"preset {preset.name}: the robot has {known}"
                return
            if preset.side:
                message.joint_names = self._flippers(preset.side)
                if not message.joint_names:
                    # an empty list would move all of them
                    self.notice = f"preset {preset.name}: no flippers known on the {preset.side}"
                    return
        message.header.stamp = stamp
        self._preset.publish(message)

    def _flippers(self, side: str) -> List[str]:
        status = self._statuses.get("flipper")
        names = () if status is None else status[1].joint_names
        return [name for name in names if side in name.split("_")]

    def _send_twist(self, rates: Tuple[float, ...], stamp: Any) -> None:
        message = TwistStamped()
        message.header.stamp = stamp
        message.header.frame_id = self.frame
        linear, angular = message.twist.linear, message.twist.angular
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = rates
        self._tool.publish(message)

    def _ask(self, what: str, service: str, kind: Any, **wanted: Any) -> None:
        if self.refused:
            return
        self._requests.ask(what, f"{self.namespace}/{service}", kind, wanted)

    def _tell(self, text: str) -> None:
        self._notice = text

    # ------------------------------------------------------------ what the robot says

    def _latest_status(self) -> Any:
        statuses = sorted(self._statuses.values(), key=lambda entry: entry[0])
        return statuses[-1][1] if statuses else None

    def _publisher(self, name: str, kind: Any, latch: bool = False) -> rospy.Publisher:
        return rospy.Publisher(
            f"{self.namespace}/{name}", kind, queue_size=10, latch=latch, tcp_nodelay=True
        )

    def _listen_to_robot(self) -> None:
        for node in NODES:
            self._listen(f"{node}_teleop/status", JointTeleopStatus, self._on_status, node)
        self._listen("track_teleop/status", TrackTeleopStatus, self._on_status, "tracks")
        self._listen("flipper_teleop/presets", FlipperPresets, self._on_presets)
        self._listen("arm_teleop/cartesian_status", CartesianTeleopStatus, self._on_cartesian)
        self._listen("e_stop", Bool, self._on_e_stop)
        self._listen("sim/status", SimStatus, self._on_sim_status)
        self._listen("link/state", LinkState, self._on_link)
        # Others zoom and switch lamps, too.
        self._listen(f"{ZOOM_TOPIC}_factor", Float64, self._on_zoom)
        for lamp in self._lamps:
            self._listen(f"lamps/{lamp}/level", Float64, self._on_lamp, lamp)

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

    def _on_link(self, message: Any) -> None:
        self._link = message

    def _on_cartesian(self, message: Any) -> None:
        self._cartesian = message

    def _on_zoom(self, message: Any) -> None:
        # What we have sent is told late, and would undo what we have sent since.
        if time.monotonic() - self._zoomed > _ECHO_WITHIN:
            self._zoom.take(message.data)

    def _on_lamp(self, message: Any, lamp: str) -> None:
        self._levels[lamp] = message.data


def _positive(rate: Optional[float]) -> Optional[float]:
    return rate if rate is not None and math.isfinite(rate) and rate > 0.0 else None


def _scale(value: float) -> Optional[float]:
    """Return a speed scale as a node has told it, None for what can be none."""
    return value if 0.0 < value <= 1.0 else None
