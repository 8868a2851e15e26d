"""What the test nodes share: a view of the robot through its topics."""

from __future__ import annotations

import threading
import urllib.request
from typing import Any, Dict, List, Optional
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

miss_nothing()

TELEOP_NODES = {
    "arm_teleop": JointTeleopStatus,
    "gripper_teleop": JointTeleopStatus,
    "flipper_teleop": JointTeleopStatus,
    "track_teleop": TrackTeleopStatus,
}


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
        self.teleop[node] = message.message

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
    """Sends one message at 50 Hz until it is stopped, as a held key does."""

    def __init__(self, topic: str, message: object) -> None:
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
        while not self._ended.wait(0.02):
            self._publisher.publish(self._message)

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
