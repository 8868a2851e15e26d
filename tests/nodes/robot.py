"""What the test nodes share: a view of the robot through its topics."""

from __future__ import annotations

import contextlib
import threading
import time
import urllib.request
from typing import Any, Callable, ClassVar, Dict, Iterator, List, Optional, Tuple
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from control_msgs.msg import JointJog
from controller_manager_msgs.srv import ListControllers
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
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
ATTEMPTS = 3


class TimedOutError(AssertionError):
    """What a `Robot` or a `Stream` waited for did not come in time."""


def _wait_until(condition: Callable[[], Any], what: str, timeout: float = 10.0) -> None:
    """Wait as tests do, with an error that differs from that of what a test asserts."""
    try:
        wait_until(condition, what, timeout)
    except AssertionError as error:
        raise TimedOutError(str(error)) from None


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
        self._gaps: Dict[str, float] = {}
        self._e_stop = rospy.Publisher("e_stop", Bool, queue_size=1)
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
        longest = self._gaps
        longest[node] = max(longest.get(node, 0.0), *gaps)
        self._told[node] = told
        self.teleop[node] = message.message

    def press_until(
        self, condition: Callable[[], Any], what: str, *keys: Stream, timeout: float = 20.0
    ) -> None:
        """Wait until held keys have done something, and press anew those whose node asks for it.

        A node that got no processor for half a second takes a key that is held then for a press
        from before a stop, and ignores it until it is released.
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

        _wait_until(done, what, timeout)

    def do_without_a_gap(self, part: Callable[[], None]) -> None:
        """Do a part of a test that holds keys, anew where it failed and their holding had gaps.

        A node that hears nothing for 0.25 s obeys what comes then: be it that it got no processor,
        or this process did not. Only gaps of nodes to which the part holds keys count, and what did
        not come in time is waited for no longer.

        Parameters
        ----------
        part
            Leaves behind, also where it fails, what it can begin from.
        """
        for left in reversed(range(ATTEMPTS)):
            self._gaps = {}
            Stream.gaps.clear()
            try:
                part()
                return
            except TimedOutError:
                raise
            except AssertionError as error:
                gaps = {node: self._gap(node) for node in Stream.gaps}
                if left == 0 or max(gaps.values(), default=0.0) < LONGEST_GAP:
                    raise
                rospy.logwarn(f"anew, for gaps (s) of held keys: {gaps}: {error}")
            time.sleep(LET_GO)

    def _gap(self, node: str) -> float:
        """Longest time (s) without a command to a node or a status of it, up to now."""
        told = self._told.get(node)
        silent = 0.0 if told is None else time.monotonic() - told[1]
        return max(silent, self._gaps.get(node, 0.0), Stream.gaps[node])

    @contextlib.contextmanager
    def emergency_stop(self) -> Iterator[None]:
        """Press the emergency stop, and release it also where what is done meanwhile fails."""
        _wait_until(
            lambda: self._e_stop.get_num_connections() > len(TELEOP_NODES),
            "simulator and teleoperation nodes to listen to e_stop",
        )
        try:
            self._e_stop.publish(Bool(True))
            _wait_until(lambda: self.status and self.status.e_stop, "the status to say e-stop", 5.0)
            yield
        finally:
            self._e_stop.publish(Bool(False))
            _wait_until(
                lambda: self.status and not self.status.e_stop, "the status to say no e-stop", 5.0
            )

    @contextlib.contextmanager
    def states(self) -> Iterator[List[JointState]]:
        """Joint states that come meanwhile: at least one."""
        states: List[JointState] = []
        listener = rospy.Subscriber("joint_states", JointState, states.append, tcp_nodelay=True)
        try:
            _wait_until(lambda: states, "a joint state")
            yield states
        finally:
            listener.unregister()

    def wait_until_obedient(self, *nodes: str, timeout: float = 20.0) -> None:
        """Wait until teleoperation nodes (all, if none is named) say that they obey.

        A node that has just started is deaf for a moment.
        """
        wanted = nodes or tuple(TELEOP_NODES)
        for node in wanted:
            self.teleop.pop(node, None)
        _wait_until(
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

        _wait_until(still, "every joint at rest", timeout)

    def wait_until_controllable(self, timeout: float = 60.0) -> None:
        """Wait until the controllers that run from the start do, and the joint states come."""
        rospy.wait_for_service("controller_manager/list_controllers", timeout)
        listing = rospy.ServiceProxy("controller_manager/list_controllers", ListControllers)

        def running() -> bool:
            states = [controller.state for controller in listing().controller]
            return states.count("running") > 20

        _wait_until(running, "21 controllers running", timeout)
        _wait_until(lambda: self.state and self.base and self.status, "robot topics", timeout)

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
        _wait_until(lambda: self.sim_time() >= end, "sim time to pass", 10.0 * seconds + 10.0)


class Stream:
    """Sends one message at 50 Hz until it is stopped, as a held key does.

    Attributes
    ----------
    held : threading.Event
        Cleared, it is silent.
    node : str
        To whom it goes.
    gaps : dict
        Node to the longest time (s) between two messages of a stream to it, of all streams.
    """

    gaps: ClassVar[Dict[str, float]] = {}

    def __init__(self, topic: str, message: object) -> None:
        self.node = topic.partition("/")[0]
        self.held = threading.Event()
        self.held.set()
        self._publisher = rospy.Publisher(topic, type(message), queue_size=1, tcp_nodelay=True)
        self._message = message
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Stream:
        _wait_until(
            lambda: self._publisher.get_num_connections() > 0,
            f"a subscriber of {self._publisher.name}",
            20.0,
        )
        self.gaps.setdefault(self.node, 0.0)
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
            self._note_gap(last, now)
            last = now
        self._note_gap(last, time.monotonic())

    def _note_gap(self, last: Optional[float], now: float) -> None:
        if last is not None:
            self.gaps[self.node] = max(self.gaps.get(self.node, 0.0), now - last)

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
