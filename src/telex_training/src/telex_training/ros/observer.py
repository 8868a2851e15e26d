"""Observations of an operator, from the topics of a robot."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState
from telex_msgs.msg import GripperContact, JointTeleopStatus, TrackTeleopStatus

from telex_control.ros.node_handle import NodeHandle

from ..operators.port import Grip, Notice, Observation, Placement

_NODES = {
    "arm_teleop": JointTeleopStatus,
    "flipper_teleop": JointTeleopStatus,
    "gripper_teleop": JointTeleopStatus,
    "track_teleop": TrackTeleopStatus,
}


class Observer:
    """Listens to a robot: its joints and base, its teleoperation nodes, the gripper's contacts.

    Attributes
    ----------
    arrived : threading.Condition
        Notified of each joint state and base pose.
    """

    def __init__(self, node: NodeHandle) -> None:
        self.arrived = threading.Condition()
        self._stamps = {"joint_states": -1.0, "sim/base_pose": -1.0}
        self._news: Dict[str, Any] = {}
        self._notices: Dict[str, Notice] = {}
        node.subscribe("joint_states", JointState, self._on_joint_states)
        node.subscribe("sim/base_pose", PoseStamped, self._on_base_pose)
        node.subscribe("sim/gripper_contact", GripperContact, self._on_contact)
        for name, kind in _NODES.items():
            node.subscribe(f"{name}/status", kind, self._hearer(name))

    @property
    def stamps(self) -> Dict[str, float]:
        """Sim time (s) of the newest joint state and base pose, by topic; -1 before the first."""
        with self.arrived:
            return dict(self._stamps)

    @property
    def time(self) -> float:
        """Sim time of the older of both (s); -1 before the first of each."""
        return min(self.stamps.values())

    def observation(self) -> Observation:
        """Return what is known now."""
        with self.arrived:
            return Observation(
                time=min(self._stamps.values()), notices=dict(self._notices), **self._news
            )

    def _take(self, topic: str, stamp: float, **news: Any) -> None:
        with self.arrived:
            self._stamps[topic] = stamp
            self._news.update(news)
            self.arrived.notify_all()

    def _on_joint_states(self, message: Any) -> None:
        self._take(
            "joint_states",
            message.header.stamp.to_sec(),
            positions=dict(zip(message.name, message.position)),
            velocities=dict(zip(message.name, message.velocity)),
        )

    def _on_base_pose(self, message: Any) -> None:
        at, turned = message.pose.position, message.pose.orientation
        base = Placement((at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w))
        self._take("sim/base_pose", message.header.stamp.to_sec(), base=base)

    def _on_contact(self, message: Any) -> None:
        with self.arrived:
            self._news["grip"] = Grip(str(message.object), float(message.force))

    def _hearer(self, node: str) -> Callable[[Any], None]:
        def hear(message: Any) -> None:
            # Tracks have no notice beside the message.
            text = message.message or getattr(message, "notice", "")
            with self.arrived:
                last = self._notices.get(node)
                self._notices[node] = Notice(1 if last is None else last.number + 1, text)

        return hear
