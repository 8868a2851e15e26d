"""An operator's station: commands to the teleoperation nodes, and their answers."""

from __future__ import annotations

import abc
import math
from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np
from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist
from std_msgs.msg import String
from telex_msgs.msg import FlipperPresetHold, JointTeleopStatus, TrackTeleopStatus
from telex_msgs.srv import SetMode

from telex_control.kinematics import Chain, make_pose
from telex_control.ros.node_handle import NodeHandle, Publisher
from telex_control.ros.pose_messages import fill_pose, pose_in
from telex_experiments.mobility.by_presets import PresetKeys
from telex_experiments.mobility.scripted_operator import NotManagedError, Operator, Pose

FLIPPERS = tuple(
    f"{end}_{side}_flipper_joint" for end in ("front", "rear") for side in ("left", "right")
)
Course = Tuple[float, float, float]
"""x, y (m) and heading (rad) in the world of a course that a script drives along its own x."""

_NODES = {
    "arm_teleop": JointTeleopStatus,
    "flipper_teleop": JointTeleopStatus,
    "gripper_teleop": JointTeleopStatus,
    "track_teleop": TrackTeleopStatus,
}
_PRESS_ANEW = "press it again"
"""What a node says that does not obey a command which outlived a stop."""
_LETTING_GO = 0.6
"""How long a key is let go of then (s)."""
_FLIPPER_RATE = 0.9  # rad/s
_FLIPPER_GAIN = 4.0  # 1/s
_FLIPPER_SETTLED = 0.02  # rad


class Link(abc.ABC):
    """How an operator's program reaches a robot.

    Attributes
    ----------
    node : NodeHandle
        Of the robot's namespace.
    urdf : str
        Its description.
    repeat : callable
        Sends again what is held: to be called while sim time passes slowly, for the robot's
        watchdogs look at the wall's clock as well. A station sets it.
    """

    node: NodeHandle
    urdf: str
    repeat: Callable[[], None]

    @abc.abstractmethod
    def advance(self, seconds: float) -> None:
        """Let so much sim time (s) pass, and return once its messages are there."""

    @abc.abstractmethod
    def now(self) -> float:
        """Sim time of the newest messages (s)."""

    @abc.abstractmethod
    def call(self, service: str, kind: Any, **request: Any) -> Any:
        """Call a service in the robot's namespace.

        Raises
        ------
        NotManagedError
            It refuses, or is not there.
        """


class Station(Operator):
    """Drives base, flippers, arm and gripper by the topics that console and joystick use.

    A command is held until it is released, as a key is; it is repeated at each look. What the base
    does is given in the frame of a course, so that a script for one along x serves anywhere.

    Parameters
    ----------
    link : Link
    """

    def __init__(self, link: Link) -> None:
        self.link = link
        self.notices: Dict[str, str] = {}
        self._base_message: Optional[Any] = None
        self._course: Course = (0.0, 0.0, 0.0)
        self._held: Dict[str, Any] = {}
        self._silent_until: Dict[str, float] = {}
        self._wanted: Dict[str, float] = {}
        self._publishers: Dict[str, Publisher] = {}
        self._chains: Dict[str, Chain] = {}
        super().__init__(link.node, link.advance, "track_teleop/cmd_vel")
        for name, kind in _NODES.items():
            link.node.subscribe(f"{name}/status", kind, self._hearer(name))
        self._began = link.now()
        link.repeat = self._repeat

    # --- what is seen ----------------------------------------------------------------------------

    def _on_base_pose(self, message: PoseStamped) -> None:
        self._base_message = message.pose
        self._place()

    def _place(self) -> None:
        if self._base_message is None:
            return
        seen = Pose.of(self._base_message.position, self._base_message.orientation)
        x, y, yaw = self._course
        ahead, aside = seen.x - x, seen.y - y
        self.pose = Pose(
            ahead * math.cos(yaw) + aside * math.sin(yaw),
            aside * math.cos(yaw) - ahead * math.sin(yaw),
            seen.z,
            seen.roll,
            seen.rise,
            math.remainder(seen.yaw - yaw, 2.0 * math.pi),
        )

    def enter(self, course: Course) -> None:
        """From now on, measure the base along a course."""
        self._course = course
        self._place()

    def _hearer(self, node: str) -> Callable[[Any], None]:
        def hear(message: Any) -> None:
            self.notices[node] = message.message or getattr(message, "notice", "")
            if _PRESS_ANEW in message.message:
                self.press_anew(node)

        return hear

    def base(self) -> np.ndarray:
        """Pose of base_link in the world, 4x4."""
        message = self._base_message
        if message is None:
            raise NotManagedError("nothing is known of where the base is")
        return make_pose(*pose_in(message))

    def place_of(self, frame: str) -> np.ndarray:
        """Pose of one of the robot's frames in base_link by the measured joints, 4x4."""
        chain = self._chains.get(frame)
        if chain is None:
            chain = self._chains[frame] = Chain.from_urdf(self.link.urdf, "base_link", frame)
        joints = self._joints
        return chain.forward([joints[name] for name in chain.joint_names])

    def measured(self, joint: str) -> float:
        """Position of a joint by its full name (rad, m)."""
        return self._joints[joint]

    # --- commands --------------------------------------------------------------------------------

    def hold(self, topic: str, message: Any) -> None:
        """Repeat a command at each look from now on."""
        if topic not in self._publishers:
            self._publishers[topic] = self.link.node.advertise(topic, type(message))
        self._held[topic] = message

    def release(self, *topics: str) -> None:
        """Fall silent on topics; on all where none is named."""
        for topic in topics or tuple(self._held):
            self._held.pop(topic, None)
        if not topics:
            self._wanted = {}

    def tick(self) -> None:
        """Repeat what is held, and let a moment pass; see `Operator.tick`."""
        if self._wanted:
            self._jog_flippers()
        self._send_held()
        super().tick()
        self.time = self.link.now() - self._began

    def _send_held(self) -> None:
        for topic, message in self._held.items():
            if not self._lets_go(topic.split("/")[0]):
                self._publishers[topic].publish(message)

    def _repeat(self) -> None:
        self._send_held()
        self._tracks.publish(self._speed())

    def press_anew(self, node: str) -> None:
        """Let go of what is held for a node, for a moment."""
        self._silent_until[node] = self.link.now() + _LETTING_GO

    def _lets_go(self, node: str) -> bool:
        return self.link.now() < self._silent_until.get(node, 0.0)

    def _speed(self) -> Twist:
        return Twist() if self._lets_go("track_teleop") else super()._speed()

    def rest(self) -> None:
        """Let go of everything, until all has come to rest."""
        self.release()
        self.stop()
        self.wait(0.5)

    def mode(self, name: str) -> None:
        """Set the arm's mode, JOINT or CARTESIAN."""
        answer = self.link.call("arm_teleop/set_mode", SetMode, mode=name)
        if not answer.success:
            raise NotManagedError(f"arm_teleop/set_mode {name}: {answer.message}")

    def hold_tool_pose(self, target: np.ndarray, frame: str = "base_link") -> None:
        """Lead the tool on a straight line to a pose (4x4) from now on."""
        message = PoseStamped()
        message.header.frame_id = frame
        fill_pose(message.pose, target)
        self._lead_arm("arm_teleop/pose_cmds", message)

    def hold_named_pose(self, name: str) -> None:
        """Move the arm's joints to a named pose from now on."""
        self._lead_arm("arm_teleop/named_pose_cmds", String(name))

    def _lead_arm(self, topic: str, message: Any) -> None:
        self.release_arm()
        self.hold(topic, message)

    def release_arm(self) -> None:
        """Let go of what leads the arm."""
        for name in ("pose_cmds", "delta_twist_cmds", "named_pose_cmds", "delta_joint_cmds"):
            self.release(f"arm_teleop/{name}")

    def jog(self, node: str, **rates: float) -> None:
        """Move joints, by their full names, at rates (rad/s, m/s) from now on."""
        names, velocities = list(rates), list(rates.values())
        self.hold(f"{node}/delta_joint_cmds", JointJog(joint_names=names, velocities=velocities))

    def hold_preset(self, preset: str) -> None:
        """Hold a flipper preset's key from now on; empty: let go of it."""
        topic = "flipper_teleop/preset_cmds"
        if preset:
            self._wanted = {}
            self.release("flipper_teleop/delta_joint_cmds")
            self.hold(topic, FlipperPresetHold(preset=preset))
        else:
            self.release(topic)

    def move(self, **positions: float) -> None:
        """Jog flippers, named without ``_joint``, to angles (rad) from now on, by eye.

        Raises
        ------
        NotManagedError
            A joint is no flipper: the arm has its own commands.
        """
        for name, angle in positions.items():
            joint = f"{name}_joint"
            if joint not in FLIPPERS:
                raise NotManagedError(f"{name} is none of the flippers")
            self._wanted[joint] = angle
        self.hold_preset("")

    def _jog_flippers(self) -> None:
        topic = "flipper_teleop/delta_joint_cmds"
        rates = {}
        for joint, angle in self._wanted.items():
            error = angle - self.measured(joint)
            if abs(error) > _FLIPPER_SETTLED:
                rates[joint] = max(-_FLIPPER_RATE, min(_FLIPPER_RATE, _FLIPPER_GAIN * error))
        if rates:
            self.jog("flipper_teleop", **rates)
        else:
            self.release(topic)


class Keys(PresetKeys):
    """The preset keys of a station; what is held is repeated by its looks.

    Parameters
    ----------
    station : Station
    """

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._station = station

    def hold(self, preset: str) -> None:
        """Hold a preset's key from now on; empty: let go of it."""
        self._station.hold_preset(preset)

    def look(self) -> None:
        """Do nothing: the station repeats the key."""
