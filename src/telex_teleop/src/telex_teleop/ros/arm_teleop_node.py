"""ROS edge of arm_teleop: what it has beside the topics of every joint node."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from typing import Any, Callable, Collection, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse
from telex_msgs.msg import CartesianTeleopStatus, Proximity
from telex_msgs.msg import ProximityPair as ProximityPairMessage
from telex_msgs.srv import SetMode, SetModeResponse

from telex_control.kinematics import Chain
from telex_control.ros.pose_messages import fill_pose, pose_in, vector_in
from telex_control.ros.rospy_fixes.connections import sender_of
from telex_teleop.arm.arm_settings import ArmTeleopSettings
from telex_teleop.arm.arm_teleop import ArmTeleop, ModeError
from telex_teleop.arm.proximity import ProximityPair, ProximityState
from telex_teleop.arm.tool_command import pose_matrix
from telex_teleop.cores import tool_motion
from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.ros.common import warn_dropped
from telex_teleop.ros.joint_teleop_node import JointTeleopNode
from telex_teleop.web.exam.exam_list import BRIDGE_TOPIC, EQUIPMENT

WARMING_UP = "warming up: the kinematics are being compiled"


class ArmTeleopNode(JointTeleopNode):
    """Feeds the arm's core with twists, poses, names of poses and what is near.

    The kinematics are compiled in a thread of their own: the joints obey meanwhile.

    Parameters
    ----------
    chain
        From base to tool; None where the robot has no such arm.
    links
        Names of the robot's links.
    """

    def __init__(
        self,
        core: ArmTeleop,
        settings: ArmTeleopSettings,
        chain: Optional[Chain],
        links: Collection[str],
    ) -> None:
        self._arm = core
        self._links = frozenset(links)
        self._settings = settings
        self._chain = chain
        self._frames = settings.frames.names()
        self._proximity: Optional[rospy.Subscriber] = None
        self._switching = threading.Lock()
        self._feels_itself_alone = False
        self._cartesian_status = rospy.Publisher(
            "~cartesian_status", CartesianTeleopStatus, queue_size=1
        )
        super().__init__(core, settings.status_rate)
        self._services = [
            rospy.Service("~set_mode", SetMode, self._set_mode),
            rospy.Service("~hold_tool", SetBool, self._hold_tool),
            rospy.Service("~set_proximity_guard", SetBool, self._set_guard),
        ]
        if chain is not None:
            core.prepare(WARMING_UP)
            self._warming = threading.Thread(
                target=self._warm_up, args=(chain,), name="kinematics", daemon=True
            )
            self._warming.start()

    @property
    def frames(self) -> Any:
        """Names of frames that commands may have."""
        return self._frames

    def base_pose(self) -> Optional[np.ndarray]:
        """Return where the base is in the world (4x4), None where that is not known."""
        with self._lock:
            return self._arm.base_now()

    def positions(self) -> Optional[np.ndarray]:
        """Return where the joints that carry the tool were measured last, None before that."""
        with self._lock:
            return self._arm.carrier_positions()

    def publish_status(self) -> None:
        """Publish the present state on ``~status`` and ``~cartesian_status``."""
        super().publish_status()
        settings = self._settings
        with self._lock:
            arm = self._arm
            tool, positions = arm.tool, arm.carrier_positions()
            message = CartesianTeleopStatus(
                ready=tool is not None,
                frames=list(self._frames.names),
                default_frame=self._frames.default,
                max_linear=settings.cartesian.max_linear,
                max_angular=settings.cartesian.max_angular,
                share=arm.share,
                slowdown=arm.slowdown,
                holds_tool=tool is not None and tool.holding,
                guard=arm.guard.enabled,
                poses=list(arm.carrier.poses),
            )
            goal = None if tool is None else tool.goal
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = settings.frames.base
        if self._chain is not None and positions is not None:
            present = self._chain.forward(positions.tolist())
            fill_pose(message.tool, present)
            fill_pose(message.desired, present if goal is None else goal)
        else:
            message.tool.orientation.w = message.desired.orientation.w = 1.0
        self._cartesian_status.publish(message)

    @property
    def _mode(self) -> str:
        return self._arm.mode

    def _listen(self) -> None:
        super()._listen()
        listened: Tuple[Tuple[str, Any, Callable[[Any], None]], ...] = (
            ("~delta_twist_cmds", TwistStamped, self._on_twist),
            ("~pose_cmds", PoseStamped, self._on_pose),
            ("~named_pose_cmds", String, self._on_pose_name),
        )
        for name, kind, heard in listened:
            rospy.Subscriber(name, kind, heard, queue_size=10, tcp_nodelay=True)
        if self._settings.frames.base_pose == "sim":
            rospy.Subscriber(
                "sim/base_pose", PoseStamped, self._on_base_pose, queue_size=1, tcp_nodelay=True
            )
        else:
            rospy.Subscriber(
                "track_controller/odom", Odometry, self._on_odometry, queue_size=1, tcp_nodelay=True
            )
        rospy.Subscriber(BRIDGE_TOPIC, String, self._on_exam, queue_size=1)
        self._listen_to_proximity(self._arm.guard.enabled)

    def _on_exam(self, message: Any) -> None:
        """In an exam, restrict the guard to what the robot can know.

        Its joints tell where its own links are; only sensors could tell of what surrounds it.
        """
        blind = bool(message.data) and not _feels_surroundings()
        if blind != self._feels_itself_alone:
            rospy.loginfo(
                "proximity guard: "
                + (
                    "an exam runs, and of what is near only the robot's own links count"
                    if blind
                    else "all that is near counts"
                )
            )
        self._feels_itself_alone = blind

    def _listen_to_proximity(self, wanted: bool) -> None:
        # The simulator computes what is near only while somebody subscribes.
        if wanted and self._proximity is None:
            self._proximity = rospy.Subscriber(
                "sim/proximity", Proximity, self._on_proximity, queue_size=1, tcp_nodelay=True
            )
        elif not wanted and self._proximity is not None:
            self._proximity.unregister()
            self._proximity = None

    def _warm_up(self, chain: Chain) -> None:
        tool = tool_motion(self._arm, chain, self._settings.cartesian)
        with self._lock:
            self._arm.attach(tool)

    # ------------------------------------------------------------ commands

    def _on_twist(self, message: Any) -> None:
        twist = message.twist
        linear, angular = vector_in(twist.linear), vector_in(twist.angular)
        self._obey(
            "~delta_twist_cmds",
            lambda wall: self._arm.receive_tool(
                self._frames.twist(message.header.frame_id, linear, angular),
                wall,
                sender_of(message),
            ),
        )

    def _on_pose(self, message: Any) -> None:
        pose = message.pose
        position, orientation = pose_in(pose)
        self._obey(
            "~pose_cmds",
            lambda wall: self._arm.receive_tool(
                self._frames.pose(message.header.frame_id, position, orientation),
                wall,
                sender_of(message),
            ),
        )

    def _on_pose_name(self, message: Any) -> None:
        self._obey(
            "~named_pose_cmds",
            lambda wall: self._arm.receive_pose_name(message.data, wall, sender_of(message)),
        )

    def _obey(self, topic: str, act: Callable[[float], object]) -> None:
        arrival = time.monotonic()
        try:
            with self._lock:
                act(arrival)
            self._rest.wake()
        except InvalidCommand as error:
            with self._lock:
                self._arm.refuse(arrival, f"{topic[1:]}: {error}")
            warn_dropped(topic, str(error))

    # ------------------------------------------------------------ what surrounds the arm

    def _on_base_pose(self, message: Any) -> None:
        self._take_base(message.header.stamp.to_sec(), message.pose)

    def _on_odometry(self, message: Any) -> None:
        self._take_base(message.header.stamp.to_sec(), message.pose.pose)

    def _take_base(self, stamp: float, pose: Any) -> None:
        try:
            matrix = pose_matrix(*pose_in(pose))
        except InvalidCommand as error:
            warn_dropped("pose of the base", str(error))
            return
        with self._lock:
            self._arm.base.take(stamp, matrix)
        self._rest.follow()

    def _on_proximity(self, message: Any) -> None:
        try:
            state = proximity_state(message, self._links)
        except InvalidCommand as error:
            warn_dropped("sim/proximity", str(error))
            return
        if self._feels_itself_alone:
            state = own_links(state, self._links)
        with self._lock:
            self._arm.guard.take(state)

    # ------------------------------------------------------------ services

    def _set_mode(self, request: Any) -> SetModeResponse:
        problem = self._try(lambda: self._arm.set_mode(request.mode))
        return SetModeResponse(success=not problem, message=problem)

    def _hold_tool(self, request: Any) -> SetBoolResponse:
        problem = self._try(lambda: self._arm.hold_tool(bool(request.data)))
        return SetBoolResponse(success=not problem, message=problem)

    def _set_guard(self, request: Any) -> SetBoolResponse:
        wanted = bool(request.data)
        with self._switching:
            with self._lock:
                self._arm.guard.enabled = wanted
                self._arm.guard.forget()
            self._listen_to_proximity(wanted)
        rospy.loginfo(f"proximity guard {'on' if wanted else 'OFF: nothing keeps the arm off'}")
        return SetBoolResponse(success=True, message="")

    def _try(self, act: Callable[[], None]) -> str:
        try:
            with self._lock:
                act()
            self._rest.wake()
        except ModeError as error:
            return str(error)
        return ""


def _feels_surroundings() -> bool:
    """Whether the robot's equipment has what feels what is near."""
    try:
        equipment = rospy.get_param(EQUIPMENT, {})
    except (rospy.ROSException, OSError):
        return False
    return isinstance(equipment, dict) and "proximity" in equipment


def own_links(state: ProximityState, links: Collection[str]) -> ProximityState:
    """Return of what is near that between the robot's own links."""
    pairs = (pair for pair in state.pairs if pair.link in links and pair.other in links)
    return replace(state, pairs=tuple(pairs))


def proximity_state(message: Any, links: Collection[str]) -> ProximityState:
    """Check a Proximity message.

    Parameters
    ----------
    links
        Of the robot: what is among them rides on its base.

    Raises
    ------
    InvalidCommand
        When a number is not finite, or not every joint has its position and gradient.
    """
    joints = message.joints
    lists = [("positions", message.positions)]
    lists += [("gradient", pair.gradient) for pair in message.pairs]
    for field, values in lists:
        if len(values) != len(joints):
            raise InvalidCommand(f"{field} has {len(values)} numbers for {len(joints)} joints")
    pairs = []
    for pair in message.pairs:
        point, normal = vector_in(pair.point), vector_in(pair.normal)
        by_base = (*normal, *np.cross(point, normal).tolist())
        for value in (pair.distance, *pair.gradient, *by_base):
            if not math.isfinite(value):
                raise InvalidCommand(f"a number of {pair.link} and {pair.other} is {value!r}")
        pairs.append(
            ProximityPair(
                link=pair.link,
                other=pair.other,
                touchable=pair.contact == ProximityPairMessage.TOUCHABLE,
                distance=pair.distance,
                gradient=dict(zip(joints, pair.gradient)),
                base_gradient=(0.0,) * 6 if pair.other in links else by_base,
            )
        )
    for joint, position in zip(joints, message.positions):
        if not math.isfinite(position):
            raise InvalidCommand(f"position of {joint} is {position!r}; must be a finite number")
    stamp = message.header.stamp.to_sec()
    return ProximityState(stamp, dict(zip(joints, message.positions)), tuple(pairs))
