"""tf for web clients as a ROS node: the action TFSubscription and the service RepublishTFs."""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import Any, Callable, Dict, List, Optional

import actionlib
import rospy
import tf2_ros
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import Transform, TransformStamped
from tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionFeedback
from tf2_web_republisher.srv import RepublishTFs, RepublishTFsResponse

from telex_control.common.params import ConfigError, read_config
from telex_control.ros.node_start import end_quietly, init_node

from .watch import Audience, TransformsConfig, TransformWatch, WishError

MIN_TIMEOUT, MAX_TIMEOUT = 0.1, 60.0
"""Shortest and longest time (s) after which a topic without a subscriber ends."""

GOAL_TIMEOUT = 10.0
"""Time (s) without a subscriber of the feedback after which goals end."""

NICENESS = 10
"""How far this node steps back behind others."""

LOOK_PERIOD = 1.0
"""Time (s) between two looks whether another node still serves, or somebody still hears."""


class _Frames:
    """The tree of transforms, heard only while somebody watches."""

    def __init__(self) -> None:
        self._users = 0
        self._lock = threading.Lock()
        self._buffer: Optional[tf2_ros.BufferCore] = None
        self._listener: Optional[tf2_ros.TransformListener] = None

    def join(self) -> None:
        """Begin to hear, for the first one who watches."""
        with self._lock:
            self._users += 1
            if self._users == 1:
                self._buffer = tf2_ros.Buffer(debug=False)
                self._listener = tf2_ros.TransformListener(self._buffer)

    def leave(self) -> None:
        """Stop, after the last one."""
        with self._lock:
            self._users -= 1
            if self._users == 0 and self._listener is not None:
                self._listener.unregister()
                self._listener = self._buffer = None

    def lookup(self, target: str, source: str) -> Optional[Transform]:
        """Return the newest transform from a frame into another, None while there is none."""
        buffer = self._buffer
        if buffer is None:
            return None
        try:
            return buffer.lookup_transform_core(target, source, rospy.Time()).transform
        except tf2_ros.TransformException:
            return None


class _Watcher:
    """Tells one client of its transforms, in a thread of its own."""

    def __init__(
        self,
        watch: TransformWatch,
        frames: _Frames,
        tell: Callable[[List[TransformStamped]], None],
        goes_on: Callable[[], bool],
        ended: Callable[[], None],
    ) -> None:
        self._watch = watch
        self._frames = frames
        self._tell = tell
        self._goes_on = goes_on
        self._ended = ended
        self._stop = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def stop(self) -> None:
        """End it soon."""
        self._stop.set()

    def _run(self) -> None:
        self._frames.join()
        try:
            # By the wall's clock: a display goes on while the simulation is paused.
            step, waited = min(self._watch.period, LOOK_PERIOD), 0.0
            while not self._stop.wait(step) and self._goes_on():
                waited += step
                if waited < self._watch.period:
                    continue
                waited = 0.0
                changed = self._watch.news(self._frames.lookup, rospy.Time.now())
                if changed:
                    self._tell(changed)
        except rospy.ROSException:  # the node ends
            pass
        finally:
            self._frames.leave()
            self._ended()


class Server(actionlib.ActionServer):
    """An action server that cancels single goals only, for several clients share it."""

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Cancel the goal of an id; without one, or by its time, it would be those of others."""
        if goal_id.id:
            super().internal_cancel_callback(GoalID(id=goal_id.id))


class TransformsNode:
    """Serves the action and the service until the node ends."""

    def __init__(self, config: TransformsConfig) -> None:
        self._config = config
        self._frames = _Frames()
        self._lock = threading.Lock()
        self._goals: Dict[str, _Watcher] = {}
        self._topics: Dict[str, _Watcher] = {}
        self._count = 0
        self._server = Server(
            config.action, TFSubscriptionAction, self._take_goal, self._cancel, auto_start=False
        )
        self._server.start()
        end_quietly(self._server)
        rospy.Service(config.service, RepublishTFs, self._republish)

    def _require_room(self) -> None:
        """Raise WishError if one more watch were too many; hold the lock until it has begun."""
        if len(self._goals) + len(self._topics) >= self._config.max_watches:
            raise WishError(f"{self._config.max_watches} clients are served already")

    def _take_goal(self, goal: Any) -> None:
        name = goal.get_goal_id().id
        audience = Audience(self._server.feedback_pub.get_num_connections, GOAL_TIMEOUT)

        def tell(transforms: List[TransformStamped]) -> None:
            goal.publish_feedback(TFSubscriptionFeedback(transforms))

        def goes_on() -> bool:
            if not audience.is_there():
                goal.set_aborted(text="nobody hears its feedback any more")
                return False
            return True

        try:
            watch = TransformWatch(goal.get_goal())
            with self._lock:
                self._require_room()
                goal.set_accepted()
                self._goals[name] = _Watcher(
                    watch, self._frames, tell, goes_on, lambda: self._forget(self._goals, name)
                )
        except WishError as error:
            goal.set_rejected(text=str(error))

    def _cancel(self, goal: Any) -> None:
        with self._lock:
            watcher = self._goals.get(goal.get_goal_id().id)
        if watcher is not None:
            watcher.stop()
        goal.set_canceled()

    def _republish(self, request: Any) -> RepublishTFsResponse:
        timeout = request.timeout.to_sec()
        try:
            watch = TransformWatch(request)
            if not MIN_TIMEOUT <= timeout <= MAX_TIMEOUT:
                raise WishError(
                    f"timeout is {timeout:g} s; it must be from {MIN_TIMEOUT:g} to {MAX_TIMEOUT:g}"
                )
            with self._lock:
                self._require_room()
                return RepublishTFsResponse(topic_name=self._begin_topic(watch, timeout))
        except WishError as error:
            raise rospy.ServiceException(str(error)) from None

    def _begin_topic(self, watch: TransformWatch, timeout: float) -> str:
        """Begin to publish transforms on a topic of their own and return its name."""
        topic = rospy.resolve_name(f"~tf_repub_{self._count}")
        self._count += 1
        publisher = rospy.Publisher(topic, TFArray, latch=True, queue_size=10)

        def ended() -> None:
            publisher.unregister()
            self._forget(self._topics, topic)

        self._topics[topic] = _Watcher(
            watch,
            self._frames,
            lambda transforms: publisher.publish(TFArray(transforms)),
            Audience(publisher.get_num_connections, timeout).is_there,
            ended,
        )
        return topic

    def _forget(self, watchers: Dict[str, _Watcher], name: str) -> None:
        with self._lock:
            watchers.pop(name, None)


def _is_offered(service: str) -> bool:
    """Tell whether another node that can be reached offers a service."""
    try:
        rospy.wait_for_service(service, LOOK_PERIOD / 2)
    except rospy.ROSException:
        return False
    return True


def main() -> int:
    """Run the node and return its exit status."""
    init_node("transforms", coarse_clock=True)
    try:
        config = read_config(TransformsConfig, rospy.get_param("~", {}), rospy.get_name())
    except ConfigError as error:
        print(f"{rospy.get_name()}: {error}", file=sys.stderr)
        return 1
    os.nice(NICENESS)  # whatever clients ask for, the robot comes first
    # Of several robots on a master one node serves all, or clients would be told everything twice.
    while not rospy.is_shutdown() and _is_offered(config.service):
        time.sleep(LOOK_PERIOD)
    if not rospy.is_shutdown():
        TransformsNode(config)
        rospy.spin()
    return 0
