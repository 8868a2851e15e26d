"""The robot as the keyboard's screen shows it."""

from __future__ import annotations

import time
from typing import Any, Dict, Optional

from telex_msgs.msg import GripperContact

from telex_control.common.geometry.quaternions import rpy_from_quaternion
from telex_control.ros.pose_messages import pose_in
from telex_teleop.keyboard.screen import JointView, NodeView, ToolView
from telex_teleop.operating.operated_robot import OperatedRobot
from telex_teleop.tracks.track_drive import STANDSTILL, Velocity


class ShownRobot(OperatedRobot):
    """A `OperatedRobot` that also says what a screen shows."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._slipping = ""
        self._listen("sim/gripper_contact", GripperContact, self._on_gripper_contact)

    def _on_gripper_contact(self, message: Any) -> None:
        self._slipping = (
            f"{message.object} slips in the gripper, {1e3 * message.slip_speed:.0f} mm/s"
            if message.slipping
            else ""
        )

    @property
    def tool(self) -> Optional[ToolView]:
        """Where the tool is, None before the arm's first status."""
        if self._cartesian is None:
            return None
        position, orientation = pose_in(self._cartesian.tool)
        return ToolView(self.frame, position, rpy_from_quaternion(orientation))

    @property
    def arm_notice(self) -> str:
        """What there is to know of the arm's motion and of its grip, empty where nothing."""
        status: Any = self._statuses.get("arm")
        moving = "" if status is None else str(status[1].notice)
        return "; ".join(filter(None, (self._slipping, moving)))

    @property
    def driven(self) -> Velocity:
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
