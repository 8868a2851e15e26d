"""What the test nodes share: a view of the robot through its topics."""

from __future__ import annotations

import threading
import time
import urllib.request
from typing import Any, Callable, Dict, List, Optional, Tuple
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from control_msgs.msg import JointJog
from controller_manager_msgs.srv import ListControllers
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import JointState
from telex_msgs.msg import JointTeleopStatus, SimStatus, TrackTeleopStatus
from waiting import wait_until

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS

miss_nothing()

TELEOP_NODES = {
    "arm_teleop": JointTeleopStatus,
    "gripper_teleop": JointTeleopStatus,
    "flipper_teleop": JointTeleopStatus,
    "track_teleop": TrackTeleopStatus,
}
LET_GO = 0.5
"""Time (s) for which a key is let go that is to be pressed anew: a node takes 0.28 s for that."""
LONGEST_GAP = 0.2
"""Time (s) without a command, or a status, from which on a held key may count as let go."""
ATTEMPTS = 5


def pid_of(name: str) -> Optional[int]:
    """Process id of a node that answers, else None."""
    caller = rospy.get_name()
    try:
        address = rosgraph.Master(caller).lookupNode(rospy.resolve_name(name))
        return int(ServerProxy(address).getPid(caller)[2])
    except (OSError, rosgraph.MasterError):
        return None


def is_streamed(server: str, topic: str) -> bool:
    """Whether the video server at an address offers a topic (its global name)."""
    with urllib.request.urlopen(f"{server}/streams", timeout=20.0) as answer:
        return topic in answer.read().decode()


class Robot:
    """Joint states, base pose and commands, with relative names."""

    def __init__(self) -> None:
        self.state: Optional[JointState] = None
        self.base: Optional[PoseStamped] = None
        self.status: Optional[SimStatus] = None
        self.teleop: Dict[str, str] = {}
        self._told: Dict[str, Tuple[float, float]] = {}
        self._held_up = 0.0
        self._subscribers = [
            rospy.Subscriber(f"{node}/status", kind, self._on_teleop, node)
            for node, kind in TELEOP_NODES.items()
        ] + [
            rospy.Subscriber("joint_states", JointState, self._on_state, tcp_nodelay=True),
            rospy.Subscriber("sim/base_pose", PoseStamped, self._on_base),
            rospy.Subscriber("sim/status", SimStatus, self._on_status),
        ]

    def _on_state(self, message: JointState) -> None:
        self.state = message

    def _on_base(self, message: PoseStamped) -> None:
        self.base = message

    def _on_status(self, message: SimStatus) -> None:
        self.status = message

    def _on_teleop(self, message: Any, node: str) -> None:
        told = message.header.stamp.to_sec(), time.monotonic()
        gaps = [now - before for now, before in zip(told, self._told.get(node, told))]
        self._held_up = max(self._held_up, *gaps)
        self._told[node] = told
        self.teleop[node] = message.message

    def press_until(
        self, condition: Callable[[], Any], what: str, *keys: Stream, timeout: float = 20.0
    ) -> None:
        """Wait until held keys have done something, and press anew those whose node asks for it.

        To a node that got no processor for half a second, they are from before.
        """

        def done() -> bool:
            if condition():
                return True
            ignored = [key for key in keys if self.teleop.get(key.node) == NEEDS_NEW_PRESS]
            if ignored:
                for key in ignored:
                    key.held.clear()
                time.sleep(LET_GO)
                for key in ignored:
                    self.teleop.pop(key.node, None)
                    key.held.set()
            return False

        wait_until(done, what, timeout)

    def do_without_a_gap(self, part: Callable[[], None]) -> None:
        """Do a part of a test that holds keys, anew where they may have counted as let go.

        A node that hears nothing for 0.25 s obeys what comes then: be it that it got no processor,
        or this process did not.
        """
        for left in reversed(range(ATTEMPTS)):
            self._held_up = Stream.longest_gap = 0.0
            try:
                part()
                return
            except AssertionError as error:
                if left == 0 or max(self._held_up, Stream.longest_gap) < LONGEST_GAP:
                    raise
                rospy.logwarn(f"anew, for a gap of a held key: {error}")
            time.sleep(LET_GO)

    def wait_until_obedient(self, *nodes: str, timeout: float = 20.0) -> None:
        """Wait until teleoperation nodes (all, if none is named) say that they obey.

        A node that has just started is deaf for a moment.
        """
        wanted = nodes or tuple(TELEOP_NODES)
        for node in wanted:
            self.teleop.pop(node, None)
        wait_until(
            lambda: all(self.teleop.get(node) == "" for node in wanted),
            f"{', '.join(wanted)} to obey",
            timeout,
        )

    def wait_until_still(self, timeout: float = 10.0) -> None:
        """Wait until no joint moves by more than 0.1 mrad within a tenth of a second (sim time)."""

        def still() -> bool:
            before = self.positions()
            self.sleep(0.1)
            return all(abs(at - before[joint]) < 1e-4 for joint, at in self.positions().items())

        wait_until(still, "every joint at rest", timeout)

    def wait_until_controllable(self, timeout: float = 60.0) -> None:
        """Wait until the controllers that run from the start do, and the joint states come."""
        rospy.wait_for_service("controller_manager/list_controllers", timeout)
        listing = rospy.ServiceProxy("controller_manager/list_controllers", ListControllers)

        def running() -> bool:
            states = [controller.state for controller in listing().controller]
            return states.count("running") > 20

        wait_until(running, "21 controllers running", timeout)
        wait_until(lambda: self.state and self.base and self.status, "robot topics", timeout)

    def positions(self) -> Dict[str, float]:
        assert self.state is not None
        return dict(zip(self.state.name, self.state.position))

    def velocities(self) -> Dict[str, float]:
        assert self.state is not None
        return dict(zip(self.state.name, self.state.velocity))

    def place(self) -> List[float]:
        assert self.base is not None
        position = self.base.pose.position
        return [position.x, position.y, position.z]

    def sim_time(self) -> float:
        assert self.state is not None
        return self.state.header.stamp.to_sec()

    def sleep(self, seconds: float) -> None:
        """Let `seconds` of sim time pass, by the joint states' stamps."""
        end = self.sim_time() + seconds
        wait_until(lambda: self.sim_time() >= end, "sim time to pass", 10.0 * seconds + 10.0)


class Stream:
    """Sends one message at 50 Hz until it is stopped, as a held key does.

    Attributes
    ----------
    held : threading.Event
        Cleared, it is silent.
    node : str
        To whom it goes.
    longest_gap : float
        Longest time (s) between two messages, of all streams.
    """

    longest_gap = 0.0

    def __init__(self, topic: str, message: object) -> None:
        self.node = topic.partition("/")[0]
        self.held = threading.Event()
        self.held.set()
        self._publisher = rospy.Publisher(topic, type(message), queue_size=1, tcp_nodelay=True)
        self._message = message
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Stream:
        wait_until(
            lambda: self._publisher.get_num_connections() > 0,
            f"a subscriber of {self._publisher.name}",
            20.0,
        )
        self._thread.start()
        return self

    def _run(self) -> None:
        last = None
        while not self._ended.wait(0.02):
            if not self.held.is_set():
                last = None
                continue
            self._publisher.publish(self._message)
            now = time.monotonic()
            if last is not None:
                Stream.longest_gap = max(Stream.longest_gap, now - last)
            last = now

    def __exit__(self, *exception: object) -> None:
        """Fall silent at once; no zero is sent."""
        self._ended.set()
        self._thread.join()


def jog(velocities: Dict[str, float]) -> JointJog:
    """A jog of joints (rad/s, m/s)."""
    return JointJog(joint_names=list(velocities), velocities=list(velocities.values()))


def twist(linear: float, angular: float) -> Twist:
    """A planar velocity (m/s, rad/s)."""
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    return message
