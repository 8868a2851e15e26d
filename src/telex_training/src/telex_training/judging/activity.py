"""Record of the operator in a repetition: commands, switches, stops; and the pictures he saw."""

from __future__ import annotations

from collections import Counter
from typing import Any, Dict, List, Optional

from .entries import BadEntryError, Entry, decode, json_of, number_field, text_field, text_of
from .records.aids import AidRecord
from .stats import median, percentile

_HOLDS = 0.3
"""A command counts for so long (s): the watchdogs' 0.28 s and a sample."""
_LARGEST_AGE = 3600.0
COMMANDS = {
    "track_teleop/cmd_vel": "geometry_msgs/Twist",
    "arm_teleop/delta_joint_cmds": "control_msgs/JointJog",
    "gripper_teleop/delta_joint_cmds": "control_msgs/JointJog",
    "flipper_teleop/delta_joint_cmds": "control_msgs/JointJog",
    "arm_teleop/delta_twist_cmds": "geometry_msgs/TwistStamped",
    "arm_teleop/pose_cmds": "geometry_msgs/PoseStamped",
    "arm_teleop/named_pose_cmds": "std_msgs/String",
    "flipper_teleop/preset_cmds": "telex_msgs/FlipperPresetHold",
}
"""Channels of the operators' commands, and their types."""
STATUSES = {
    "arm_teleop/status": "telex_msgs/JointTeleopStatus",
    "gripper_teleop/status": "telex_msgs/JointTeleopStatus",
    "flipper_teleop/status": "telex_msgs/JointTeleopStatus",
    "track_teleop/status": "telex_msgs/TrackTeleopStatus",
}
"""Channels of the teleoperation nodes' states, and their types."""


def asks_for_motion(entry: Entry) -> bool:
    """Whether a command asks for motion: one of zeros asks for none.

    Raises
    ------
    BadEntryError
    """
    kind = COMMANDS[entry.channel]
    if kind == "std_msgs/String":
        return bool(text_of(entry))
    message = decode(entry, kind)
    if kind == "control_msgs/JointJog":
        return any(message.velocities) or any(message.displacements)
    if kind == "geometry_msgs/PoseStamped":
        return True
    if kind == "telex_msgs/FlipperPresetHold":
        return bool(message.preset)
    twist = message.twist if kind == "geometry_msgs/TwistStamped" else message
    return any(
        (
            twist.linear.x,
            twist.linear.y,
            twist.linear.z,
            twist.angular.x,
            twist.angular.y,
            twist.angular.z,
        )
    )


class ActivityRecord:
    """Counts of the present repetition, of states that last beyond it.

    Attributes
    ----------
    aids : AidRecord
        Of the whole trial.
    """

    def __init__(self) -> None:
        self.aids = AidRecord()
        self._command: Optional[float] = None
        self._active: Dict[str, bool] = {}
        self._mode = self._view = ""
        self._e_stop = self._stuck = False
        self._dropped: Dict[str, int] = {}
        self.begin()

    def begin(self) -> None:
        """Begin a repetition."""
        self._counts: Counter[str] = Counter()
        self._idle = 0.0
        self._ages: List[float] = []
        self._seen = False
        self._released: Counter[str] = Counter()

    def command(self, entry: Entry) -> Optional[str]:
        """Hear a command; returns the event "command" where it asks for motion."""
        if not asks_for_motion(entry):
            return None
        self._command = entry.time
        return "command"

    def teleop_status(self, entry: Entry) -> Optional[str]:
        """Hear a teleoperation node's state; returns the event "mode" when the arm's changed."""
        message = decode(entry, STATUSES[entry.channel])
        was, self._active[entry.channel] = self._active.get(entry.channel), bool(message.active)
        # A stream that falls silent ends without a reason: that is how a key is released. Flippers
        # say one when a preset is reached.
        flippers = entry.channel == "flipper_teleop/status"
        if was and not message.active and message.message and not flippers:
            self._release(str(message.message))
        mode = str(getattr(message, "mode", ""))
        if not mode or entry.channel != "arm_teleop/status":
            return None
        before, self._mode = self._mode, mode
        return self._counted("mode_switches", "mode") if before not in ("", mode) else None

    def sim_status(self, message: Any) -> List[str]:
        """Hear a telex_msgs/SimStatus; returns the events of "e_stop" and "stuck"."""
        events = []
        if message.e_stop and not self._e_stop:
            events.append(self._counted("e_stops", "e_stop"))
        if message.stuck and not self._stuck:
            events.append(self._counted("stuck", "stuck"))
        self._e_stop, self._stuck = bool(message.e_stop), bool(message.stuck)
        return events

    def clients(self, entry: Entry) -> None:
        """Hear who is connected to the bridge, and how many of their commands were refused."""
        message = decode(entry, "telex_msgs/BridgeClients")
        before, self._dropped = self._dropped, {}
        for client in message.clients:
            self._dropped[client.id] = client.dropped_commands
            if client.id in before:
                self._counts["refused"] += max(0, client.dropped_commands - before[client.id])

    def telemetry(self, entry: Entry) -> Optional[str]:
        """Hear what the console shows; returns the event "camera" when the main view changed.

        JSON: ``view`` (name of the camera of the main view), ``picture_age`` (s), ``released`` (why
        the console let go of the keys since its last message), ``aids`` (see `AidRecord`); further
        keys are for others.
        """
        content = json_of(entry)
        self.aids.hear(content)
        view = text_field(content, "view", self._view)
        if "picture_age" in content:
            age = number_field(content, "picture_age")
            if not 0.0 <= age <= _LARGEST_AGE:
                raise BadEntryError(f"picture_age is {age}; 0 to {_LARGEST_AGE:g} s is possible")
            self._ages.append(age)
        released = text_field(content, "released")
        if released:
            self._release(released)
        self._seen = True
        before, self._view = self._view, view
        return self._counted("camera_switches", "camera") if before not in ("", view) else None

    def sample(self, time: float, span: float) -> None:
        """Let time pass (s)."""
        if self._command is None or time - self._command > _HOLDS:
            self._idle += span

    def figure(self, kind: str) -> Optional[float]:
        """Return a figure; None where it could not be measured."""
        if kind == "idle":
            return self._idle
        if kind.startswith("picture_age"):
            if not self._ages:
                return None
            return percentile(self._ages, 0.95) if kind.endswith("p95") else median(self._ages)
        if kind == "camera_switches" and not self._seen:
            return None
        return float(self._counts[kind])

    def releases(self) -> Dict[str, int]:
        """Motions that the dead-man's watchdog ended, by the node's reason."""
        return dict(self._released)

    def _release(self, reason: str) -> None:
        self._counts["dead_man"] += 1
        self._released[reason[:200]] += 1

    def _counted(self, kind: str, event: str) -> str:
        self._counts[kind] += 1
        return event
