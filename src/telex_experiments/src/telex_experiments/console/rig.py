"""The whole simulator with a console before it, and everything that is said on the way between."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import time
from typing import (
    Any,
    Callable,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
)

import aiohttp
import rosgraph
import rospy
from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import Empty
from telex_msgs.msg import TrackTeleopStatus

from telex_experiments.rigs.chromium import Chromium
from telex_experiments.rigs.private_simulator import PrivateSimulator
from telex_experiments.rigs.report import PATIENCE, MeasurementError, wait_until
from telex_teleop.web.token_files import read_token

WORLD = "training_hall"
SPEED = 1.0
"""Speed (m/s) at which the robot drives."""

BELT, BELT_RADIUS = "front_left_track_joint", 0.110
REPEAT_PERIOD = 0.033
"""Period (s) at which a keyboard repeats a key that is held."""

LIVE = """
document.getElementById("link").dataset.state === "up"
  && document.getElementById("view").dataset.state === "live"
  && document.querySelectorAll(".thumbnail[data-state=live]").length === 5
  && document.getElementById("speed").textContent.includes("%")
"""

DRIVE, TRACKS = "track_teleop/cmd_vel", "track_controller/cmd_vel"
JOG, TURRET = "arm_teleop/delta_joint_cmds", "turret_position_controller/command"


class Heard(NamedTuple):
    """A message: its arrival (monotonic time, s), and the one number that matters of it."""

    at: float
    value: float


class Wire:
    """What arrives on some topics, each with a subscriber as the robot's own nodes have them."""

    def __init__(self) -> None:
        self._heard: Dict[str, List[Heard]] = {}
        self.belt_speed = 0.0
        self.place = (0.0, 0.0, 0.0)
        self.speed_scale: Optional[float] = None
        self.max_linear = 0.0
        self._subscribers = [
            self._note(DRIVE, Twist, lambda message: message.linear.x),
            self._note(TRACKS, Twist, lambda message: message.linear.x),
            self._note(JOG, JointJog, lambda message: sum(message.velocities)),
            self._note(TURRET, Float64, lambda message: message.data),
            self._subscribe("joint_states", JointState, self._on_joint_states),
            self._subscribe("sim/base_pose", PoseStamped, self._on_base_pose),
            self._subscribe("track_teleop/status", TrackTeleopStatus, self._on_status),
        ]
        self._scale = rospy.Publisher("/telex/track_teleop/speed_scale", Float64, queue_size=1)

    def _subscribe(self, topic: str, kind: type, receive: Callable[..., None]) -> rospy.Subscriber:
        return rospy.Subscriber(f"/telex/{topic}", kind, receive, queue_size=100, tcp_nodelay=True)

    def _note(self, topic: str, kind: type, number: Callable[..., float]) -> rospy.Subscriber:
        heard = self._heard[topic] = []

        def receive(message: object) -> None:
            heard.append(Heard(time.monotonic(), number(message)))

        return self._subscribe(topic, kind, receive)

    def _on_joint_states(self, message: JointState) -> None:
        if BELT in message.name:
            index = message.name.index(BELT)
            self.belt_speed = message.velocity[index] * BELT_RADIUS

    def _on_base_pose(self, message: PoseStamped) -> None:
        place = message.pose.position
        self.place = (place.x, place.y, place.z)

    def _on_status(self, message: TrackTeleopStatus) -> None:
        self.speed_scale, self.max_linear = message.speed_scale, message.max_linear

    def heard(self, topic: str, since: float = 0.0) -> List[Heard]:
        """All that came on a topic since a time."""
        return [each for each in tuple(self._heard[topic]) if each.at >= since]

    def last(self, topic: str) -> float:
        """The newest number on a topic, zero if there was none."""
        heard = self._heard[topic]
        return heard[-1].value if heard else 0.0

    def forget(self) -> None:
        """Forget what was heard, but the last of each topic."""
        for heard in self._heard.values():
            del heard[:-1]

    def set_speed(self) -> None:
        """Let a key that is held mean SPEED."""
        wait_until("the track node's status", lambda: self.max_linear > 0.0)
        scale = SPEED / self.max_linear

        def taken() -> bool:
            self._scale.publish(scale)
            time.sleep(0.1)
            return self.speed_scale is not None and abs(self.speed_scale - scale) < 1e-6

        wait_until("the track node to take the speed", taken)


class ConsoleRig:
    """A simulator of one's own, in the training hall, with its console.

    Parameters
    ----------
    everywhere
        Whether bridge and video server listen on all networks, with a token, or on 127.0.0.1 alone.
    one_browser
        Whether whoever asks for a browser gets the same one.
    environment
        Of the simulator: that of another checkout, to measure its page.

    Use it as a context manager; `connect` connects `rospy` to it.
    """

    def __init__(
        self,
        everywhere: bool,
        one_browser: bool = False,
        environment: Optional[Mapping[str, str]] = None,
    ) -> None:
        listen = ["address:=0.0.0.0"] if everywhere else []
        self._everywhere = everywhere
        self._query = ""
        self._instructor = "?role=instructor"
        self._is_connected = False
        self._one_browser = one_browser
        self._browser: Optional[Chromium] = None
        self.simulator = PrivateSimulator(f"world:={WORLD}", *listen, environment=environment)

    def __enter__(self) -> ConsoleRig:
        try:
            self._find()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _find(self) -> None:
        simulator = self.simulator
        simulator.wait_for_master()
        video = simulator.wait_for_param("/telex/video_server/url")
        self.video_port = int(str(video).rpartition(":")[2])
        simulator.wait_for_param("/telex/rosbridge/url")
        if self._everywhere:
            path = str(simulator.wait_for_param("/telex/rosbridge/token_file"))
            self._query = f"?token={read_token(path, 'token_file')}"
            path = str(simulator.wait_for_param("/telex/rosbridge/instructor_token_file"))
            token = read_token(path, "instructor_token_file")
            self._instructor = f"?role=instructor&token={token}"
        self.master = rosgraph.Master("/benchmark_console", simulator.master_uri)

    def connect(self) -> None:
        """Connect `rospy`, and hear what is said; costs a part of a core from then on."""
        if self._is_connected:
            return
        self._is_connected = True
        os.environ.update(ROS_MASTER_URI=self.simulator.master_uri, ROS_IP="127.0.0.1")
        rospy.init_node("benchmark_console", disable_signals=True)
        self.wire = Wire()
        self.wire.set_speed()

    def __exit__(self, *exception: object) -> None:
        rospy.signal_shutdown("the benchmark ends")
        try:
            if self._browser is not None:
                self._browser.__exit__()
        finally:
            self.simulator.__exit__()

    def page(self, host: str = "127.0.0.1") -> str:
        """Address of the console."""
        return f"http://{host}:{self.video_port}/{self._query}"

    @property
    def instructor_page(self) -> str:
        """Address of the instructor's page."""
        return f"http://127.0.0.1:{self.video_port}/instructor{self._instructor}"

    def ask(self, service: str, **arguments: Any) -> Any:
        """Call a service as an instructor, over the bridge."""
        url = f"{self.master.getParam('/telex/rosbridge/url')}/{self._instructor}"
        return asyncio.run(_call(url, service, arguments))

    def clock(self) -> Tuple[float, float]:
        """Wait for the simulator's next status: the wall's time, and the sim time (s) in it."""
        url = f"{self.master.getParam('/telex/rosbridge/url')}/{self._instructor}"
        return asyncio.run(_next_status(url))

    @property
    def bridge_url(self) -> str:
        """Address of the bridge for a plain client."""
        return f"{self.master.getParam('/telex/rosbridge/url')}/{self._query}"

    @property
    def video_socket_url(self) -> str:
        """Address of the WebSocket that sends pictures."""
        return f"ws://127.0.0.1:{self.video_port}/video{self._query}"

    @property
    def bridge_pid(self) -> int:
        """Process of the bridge."""
        return self.simulator.processes()["rosbridge"]

    @property
    def video_pid(self) -> int:
        """Process of the video server."""
        return self.simulator.processes()["video_server"]

    def wait_for_another_bridge(self, before: int) -> None:
        """Wait until roslaunch has started the bridge again, which was the process `before`."""

        def is_back() -> bool:
            return self.simulator.processes().get("rosbridge", before) != before

        wait_until("the bridge to be back", is_back)

    def reset(self) -> None:
        """Put the robot back to where it started."""
        rospy.ServiceProxy("/telex/sim/reset", Empty)()
        time.sleep(0.8)

    @contextlib.contextmanager
    def browser(self, before: Sequence[str] = (), host: str = "127.0.0.1") -> Iterator[Chromium]:
        """The console in a browser, once six views are live."""
        if not self._one_browser:
            with Chromium(self.page(host), before) as browser:
                settle(browser)
                yield browser
            return
        if self._browser is None:
            self._browser = Chromium(self.page(host), before)
        settle(self._browser)
        yield self._browser


async def _call(url: str, service: str, arguments: Dict[str, Any]) -> Any:
    call = {"op": "call_service", "id": "call", "service": service, "args": arguments}
    async with aiohttp.ClientSession() as http, http.ws_connect(url, max_msg_size=0) as bridge:
        await bridge.send_json(call)
        async for message in bridge:
            answer = json.loads(message.data)
            if answer.get("id") == "call":
                if not answer["result"]:
                    raise MeasurementError(f"{service}: {answer['values']}")
                return answer["values"]
    raise MeasurementError(f"{service}: the bridge has closed the connection")


async def _next_status(url: str) -> Tuple[float, float]:
    wish = {"op": "subscribe", "topic": "/telex/sim/status", "type": "telex_msgs/SimStatus"}
    async with aiohttp.ClientSession() as http, http.ws_connect(url, max_msg_size=0) as bridge:
        await bridge.send_json(wish)
        heard = 0
        async for message in bridge:
            answer = json.loads(message.data)
            if answer.get("op") == "publish":
                heard += 1
            if heard == 2:  # the first is the last one that was said, nobody knows when
                stamp = answer["msg"]["header"]["stamp"]
                return time.monotonic(), stamp["secs"] + 1e-9 * stamp["nsecs"]
    raise MeasurementError("sim/status: the bridge has closed the connection")


def settle(browser: Chromium) -> None:
    """Wait until an operator would begin: six live views, no tour, a page that runs evenly."""
    # A page behind another tab asks for no pictures.
    browser.call("Page.bringToFront")
    browser.wait_for("six live views on the console", LIVE, PATIENCE)
    browser.evaluate("document.getElementById('tour-skip').click()")


def have_large(browser: Chromium, camera: str, layout: str) -> None:
    """Go to a layout, in which keys are about its task, and have a camera in its first view."""
    browser.click(f'[data-layout="{layout}"]')
    browser.evaluate(f"document.querySelector('.thumbnail[data-camera={camera}]')?.click()")
