"""ROS edge of the flippers' node: what the joint nodes have, and presets by key and by action."""

from __future__ import annotations

import threading
import time
from typing import Any, Dict, List, Tuple

import rospy
from actionlib import ActionServer
from telex_msgs.msg import (
    FlipperPresetAction,
    FlipperPresetFeedback,
    FlipperPresetHold,
    FlipperPresetResult,
    FlipperPresets,
)

from telex_control.ros.node_start import end_quietly
from telex_control.ros.rospy_fixes.connections import sender_of
from telex_teleop.flippers.flipper_teleop import FlipperTeleop
from telex_teleop.flippers.presets import EndedGoal, GoalEnd
from telex_teleop.motion.joint_jog import InvalidCommand
from telex_teleop.ros.common import warn_dropped
from telex_teleop.ros.joint_teleop_node import JointTeleopNode

FEEDBACK_PERIOD = 0.1  # s of wall time


class FlipperTeleopNode(JointTeleopNode):
    """Adds ``~preset_cmds``, ``~presets`` (latched) and the action ``~preset``."""

    def __init__(self, core: FlipperTeleop, status_rate: float) -> None:
        self._flippers = core
        # Goals of actionlib by the core's number for them. The action server's own lock is taken
        # first, always: its callbacks come with it held.
        self._goals: Dict[int, Any] = {}
        self._goals_lock = threading.Lock()
        self._goal_count = 0
        self._fed_back = 0.0
        super().__init__(core, status_rate)
        self._presets = rospy.Publisher("~presets", FlipperPresets, queue_size=1, latch=True)
        self._presets.publish(
            FlipperPresets(
                names=list(core.presets),
                descriptions=[preset.description for preset in core.presets.values()],
            )
        )
        self._server = ActionServer(
            rospy.resolve_name("~preset"),
            FlipperPresetAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()
        end_quietly(self._server)

    def _listen(self) -> None:
        super()._listen()
        rospy.Subscriber(
            "~preset_cmds", FlipperPresetHold, self._on_preset, queue_size=10, tcp_nodelay=True
        )

    def publish_status(self) -> None:
        """Publish the present state on ``~status``; tell clients how their goals stand."""
        super().publish_status()
        # an emergency stop and a pause end goals while no joint state comes
        self._report_goals()

    def _after_update(self) -> None:
        self._report_goals()

    def _on_preset(self, message: Any) -> None:
        arrival = time.monotonic()
        try:
            with self._lock:
                self._flippers.hold_preset(
                    message.preset,
                    message.joint_names,
                    arrival,
                    f"{sender_of(message)} {message.client}",
                )
            self._rest.wake()
        except InvalidCommand as error:
            warn_dropped("~preset_cmds", str(error))

    def _on_goal(self, goal: Any) -> None:
        wanted = goal.get_goal()
        with self._goals_lock:
            self._goal_count += 1
            number = self._goal_count
            self._goals[number] = goal
        try:
            with self._lock:
                self._flippers.begin_goal(
                    number, wanted.preset, wanted.joint_names, time.monotonic()
                )
        except InvalidCommand as error:
            with self._goals_lock:
                del self._goals[number]
            text = str(error)
            rospy.logwarn(f"goal of {rospy.resolve_name('~preset')} rejected: {text}")
            goal.set_rejected(FlipperPresetResult(message=text), text)
            return
        self._rest.wake()
        goal.set_accepted()

    def _on_cancel(self, goal: Any) -> None:
        with self._goals_lock:
            numbers = [number for number, other in self._goals.items() if other == goal]
        with self._lock:
            for number in numbers:
                self._flippers.requests.goals.cancel(number)

    def _report_goals(self) -> None:
        """Tell clients what has become of their goals; never under a lock of ours."""
        with self._lock:
            self._flippers.end_goal_in_pause(time.monotonic())
            goals = self._flippers.requests.goals
            ended = goals.take_ended()
            progress = goals.progress()
        for goal, news in self._take(ended):
            _finish(goal, news)
        now = time.monotonic()
        if progress is None or now - self._fed_back < FEEDBACK_PERIOD:
            return
        number, remaining = progress
        with self._goals_lock:
            active = self._goals.get(number)
        if active is not None:
            self._fed_back = now
            active.publish_feedback(
                FlipperPresetFeedback(
                    joint_names=list(remaining), remaining=list(remaining.values())
                )
            )

    def _take(self, ended: List[EndedGoal]) -> List[Tuple[Any, EndedGoal]]:
        with self._goals_lock:
            return [(self._goals.pop(news.number), news) for news in ended]


def _finish(goal: Any, news: EndedGoal) -> None:
    result = FlipperPresetResult(
        joint_names=list(news.remaining),
        error=list(news.remaining.values()),
        message=news.message,
    )
    if news.end is GoalEnd.REACHED:
        goal.set_succeeded(result)
    elif news.end is GoalEnd.CANCELLED:
        goal.set_canceled(result, news.message)
    else:
        goal.set_aborted(result, news.message)
