"""The cameras in a running simulator: pictures per second, CPU time, age, from command to picture.

The cameras node is bound to one core, the simulator to another; whoever watches shares both.
A picture's age is counted from when the simulator read its poses to when a subscriber has its JPEG.
"""

from __future__ import annotations

import contextlib
import math
import os
import statistics
import tempfile
import threading
import time
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np
import rospy
import yaml
from control_msgs.msg import JointControllerState, JointJog
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Float64
from telex_msgs.msg import ScenePoses, SimStatus
from telex_msgs.srv import ConfigureCamera

from telex_control.common.file_catalog import package_path
from telex_experiments.cameras.renderer import LARGE, NAMES, WORLD, bare_picture, told
from telex_experiments.rigs.private_simulator import (
    PrivateSimulator,
    SimulatorStartError,
    cpu_seconds,
)
from telex_experiments.rigs.report import PATIENCE, Figure, MeasurementError, quantile, wait_until
from telex_experiments.rigs.stream_reader import open_stream, pictures

HEADLIGHTS = ("front_left", "front_right")
# Pictures of each camera that go before a measurement.
WARM_UP = 5
# Of a measurement, one a second at most; before each, the bare getCameraImage is measured.
STRETCHES = 4
# After that, until pictures count (s).
CATCH_UP = 0.3
# Ratios to a bare getCameraImage before it was improved: of one quiet run at edd3d52, with what the
# bare picture cost then by that of other pictures of getCameraImage.
BEFORE = {
    "six 640x480, none first: slowest x bare getCameraImage": 1.99,
    "six 640x480: bare getCameraImage / age": 8.25,
    "front 640x480, five previews 320x240: front x bare getCameraImage": 5.94,
    "front 640x480, five previews 320x240: slowest other x bare getCameraImage": 2.41,
    "front 640x480, five previews 320x240: bare getCameraImage / age": 10.5,
    "night, headlights: front 640x480 x bare getCameraImage": 4.73,
    "night, headlights: slowest preview x bare getCameraImage": 1.78,
}
# Shares of these that are required, and wanted.
FLOOR, GOAL = 0.9, 1.25
# Speed of the turret (rad/s) where it rocks, and the period (s).
ROCKING, ROCKING_PERIOD = 0.1, 2.0
# The robot stands still so long after a command (s).
STILL_AFTER = 0.8
# A picture has changed when it differs from the one before the command by so many times as much as
# pictures of a robot that stands still do, and by as many grey levels.
CHANGED, LEAST_CHANGE = 2.0, 0.3


class Watched(NamedTuple):
    """What a measurement of some cameras has found.

    Attributes
    ----------
    rates : dict
        Pictures per second of each camera.
    use : float
        CPU time of the node per wall time.
    age : float
        Median time from poses to JPEG (s); NaN if no picture came.
    bare : float
        CPU time of a bare getCameraImage meanwhile (s).
    """

    rates: Dict[str, float]
    use: float
    age: float
    bare: float

    @property
    def slowest(self) -> float:
        """Least of the rates."""
        return min(self.rates.values())

    @property
    def others(self) -> float:
        """Least of the rates beside the front camera's."""
        return min(rate for name, rate in self.rates.items() if name != "front")

    @property
    def cpu(self) -> float:
        """CPU time of the node per picture (s)."""
        rate = sum(self.rates.values())
        return self.use / rate if rate else math.nan

    def beside(self, name: str, rate: float, wanted: float) -> Figure:
        """Compare a rate (1/s) with the bare getCameraImage; the wanted rate is enough."""
        return self._beside(f"{name} x bare getCameraImage", rate * self.bare, wanted * self.bare)

    def age_beside(self, name: str, wanted: float) -> Figure:
        """Compare the age with the bare getCameraImage; the wanted age (s) is enough."""
        text = f"{name}: bare getCameraImage / age"
        return self._beside(text, self.bare / self.age, self.bare / wanted)

    @staticmethod
    def _beside(text: str, value: float, enough: float) -> Figure:
        before = BEFORE[text]
        least = min(FLOOR * before, enough)
        return Figure(text, value, "times", at_least=least, goal=GOAL * before)


class StreamViewer:
    """Subscribes to a camera's JPEG pictures, e.g. of "front/preview", and counts them."""

    def __init__(self, topic: str, poses_read: Dict[int, float]) -> None:
        self.pictures = 0
        self.ages: List[float] = []
        self.newest = b""
        self._poses_read = poses_read
        self._subscriber = rospy.Subscriber(
            f"/telex/cameras/{topic}/compressed",
            CompressedImage,
            self._take,
            queue_size=1,
            buff_size=2**24,
            tcp_nodelay=True,
        )

    def _take(self, message: CompressedImage) -> None:
        now = time.time()
        self.pictures += 1
        self.newest = message.data
        read = self._poses_read.get(message.header.stamp.to_nsec())
        if read is not None:
            self.ages.append(now - read)

    @property
    def brightness(self) -> float:
        """Mean grey level of the newest picture."""
        picture = cv2.imdecode(np.frombuffer(self.newest, np.uint8), cv2.IMREAD_GRAYSCALE)
        return float(picture.mean())

    def close(self) -> None:
        """End the subscription."""
        self._subscriber.unregister()


class Live:
    """A running simulator, watched.

    Attributes
    ----------
    factors : list of float
        Sim time per wall time in each measurement.
    """

    def __init__(self, simulator: PrivateSimulator) -> None:
        self._simulator = simulator
        self.factors: List[float] = []
        self._poses_read: Dict[int, float] = {}
        self._news = threading.Condition()
        # When the newest status came (monotonic, s), and the sim time that had been stepped then.
        self._status: Tuple[float, float] = (0.0, 0.0)
        self._subscribers = [
            rospy.Subscriber("/telex/sim/status", SimStatus, self._take_status, tcp_nodelay=True),
            rospy.Subscriber("/telex/sim/poses", ScenePoses, self._take_poses, queue_size=1),
        ]
        self._cameras = simulator.wait_for(
            "cameras node", lambda: simulator.processes().get("cameras"), PATIENCE
        )
        cores = os.sched_getaffinity(0)
        bind_to_core(self._cameras, max(cores))
        # Before ordinary processes, it would take from the cameras where it met them.
        bind_to_core(simulator.processes()["simulator"], min(cores))
        topic = "/telex/cameras/front/camera_info"
        simulator.wait_for("cameras", lambda: topic in dict(rospy.get_published_topics()), PATIENCE)
        rospy.wait_for_service("/telex/cameras/configure", PATIENCE)
        self._configure = rospy.ServiceProxy("/telex/cameras/configure", ConfigureCamera)

    def _take_status(self, message: SimStatus) -> None:
        with self._news:
            self._status = time.monotonic(), message.steps * message.step_size
            self._news.notify_all()

    def _take_poses(self, message: ScenePoses) -> None:
        self._poses_read[message.header.stamp.to_nsec()] = message.wall_time

    def _next_status(self) -> Tuple[float, float]:
        with self._news:
            seen = self._status
            if not self._news.wait_for(lambda: self._status != seen, PATIENCE):
                raise MeasurementError(f"no sim/status within {PATIENCE:.0f} s")
            return self._status

    def configure(self, camera: str, **parameters: object) -> None:
        """Change parameters of a camera."""
        answer = self._configure(camera, yaml.safe_dump(parameters))
        if not answer.success:
            raise MeasurementError(f"cameras/configure: {answer.message}")

    def light_headlights(self) -> None:
        """Switch them on, and wait until the front camera sees by them."""
        viewer = self._viewer("front")
        self._wait("a dark picture", lambda: viewer.pictures > WARM_UP)
        dark = viewer.brightness
        for name in HEADLIGHTS:
            publisher = rospy.Publisher(
                f"/telex/lamps/{name}/command", Float64, queue_size=1, latch=True
            )
            publisher.publish(1.0)
        self._wait("light of the headlights", lambda: viewer.brightness > 1.5 * dark)
        print(f"  mean grey level {dark:.0f}, with headlights {viewer.brightness:.0f}", flush=True)
        viewer.close()

    def _viewer(self, name: str, preview: bool = False) -> StreamViewer:
        return StreamViewer(f"{name}/{'preview' if preview else 'image_raw'}", self._poses_read)

    def _wait(self, what: str, condition: Callable[[], object]) -> None:
        self._simulator.wait_for(what, condition, PATIENCE)

    @contextlib.contextmanager
    def real_time(self) -> Iterator[None]:
        """Note the real-time factor of what is done inside, as sim/status tells it."""
        began, first = self._next_status()
        yield
        ended, last = self._next_status()
        self.factors.append((last - first) / (ended - began))
        print(f"  real-time factor {self.factors[-1]:.3f}", flush=True)

    @contextlib.contextmanager
    def rocking(self) -> Iterator[None]:
        """Let the turret rock: what does not move is not drawn again."""
        commands = rospy.Publisher("/telex/arm_teleop/delta_joint_cmds", JointJog, queue_size=1)
        ended = threading.Event()

        def rock() -> None:
            while not ended.wait(0.02):
                speed = ROCKING * math.cos(2.0 * math.pi * time.monotonic() / ROCKING_PERIOD)
                commands.publish(JointJog(joint_names=["turret_joint"], velocities=[speed]))

        sender = threading.Thread(target=rock)
        sender.start()
        try:
            yield
        finally:
            ended.set()
            sender.join()
            commands.unregister()

    def watch(
        self,
        asked: Dict[str, float],
        seconds: float,
        previews: Sequence[str] = (),
        moves: bool = True,
    ) -> Watched:
        """Watch cameras for a time, each asked for a rate (1/s), some by their previews."""
        for name, rate in asked.items():
            setting: Dict[str, object] = {"rate": rate}
            self.configure(name, **({"preview": setting} if name in previews else setting))
        viewers = {name: self._viewer(name, name in previews) for name in asked}

        def counts() -> str:
            return ", ".join(f"{name} {viewer.pictures}" for name, viewer in viewers.items())

        try:
            self._wait(
                "pictures of all cameras",
                lambda: all(viewer.pictures >= WARM_UP for viewer in viewers.values()),
            )
        except SimulatorStartError as error:
            raise MeasurementError(f"pictures so far: {counts()}\n{error}") from error
        bare, ages, elapsed, used = [], [], 0.0, 0.0
        seen = dict.fromkeys(viewers, 0)
        with self.rocking() if moves else contextlib.nullcontext(), self.real_time():
            stretches = min(STRETCHES, math.ceil(seconds))
            for _ in range(stretches):
                bare.append(bare_picture().cost())
                # Nothing else of this process went on meanwhile: what has piled up does not count.
                time.sleep(CATCH_UP)
                for viewer in viewers.values():
                    viewer.pictures, viewer.ages = 0, []
                began, before = time.monotonic(), cpu_seconds(self._cameras)
                time.sleep(seconds / stretches)
                elapsed += time.monotonic() - began
                used += cpu_seconds(self._cameras) - before
                print(f"  {elapsed:.1f} s: {counts()}", flush=True)
                for name, viewer in viewers.items():
                    seen[name] += viewer.pictures
                    ages += viewer.ages
        for viewer in viewers.values():
            viewer.close()
        rates = {name: count / elapsed for name, count in seen.items()}
        return Watched(rates, used / elapsed, quantile(ages, 0.5), statistics.median(bare))

    def idle(self, seconds: float) -> float:
        """Use of a core by the node while nobody watches, once it has seen that."""
        master = rospy.get_master()

        def followed() -> bool:
            _, _, (_, subscribers, _) = master.getSystemState()
            return "/telex/cameras" in dict(subscribers).get("/telex/sim/poses", [])

        self._wait("end of the cameras' interest in poses", lambda: not followed())
        with self.real_time():
            began, used = time.monotonic(), cpu_seconds(self._cameras)
            time.sleep(seconds)
            return (cpu_seconds(self._cameras) - used) / (time.monotonic() - began)


def bind_to_core(pid: int, core: int) -> None:
    """Let all threads of a process run on one core alone."""
    for thread in os.listdir(f"/proc/{pid}/task"):
        with contextlib.suppress(ProcessLookupError):
            os.sched_setaffinity(int(thread), {core})


class PictureClient:
    """An operator's browser: reads an MJPEG stream, and keeps the newest picture."""

    def __init__(self, url: str, topic: str) -> None:
        self._answer = open_stream(url, topic)
        self._lock = threading.Condition()
        self._newest: Tuple[float, Optional[np.ndarray]] = (0.0, None)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for _, data in pictures(self._answer):
            arrived = time.monotonic()
            picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_REDUCED_GRAYSCALE_2)
            with self._lock:
                self._newest = arrived, picture.astype(np.float32)
                self._lock.notify_all()

    def next(self) -> Tuple[float, np.ndarray]:
        """When the next picture came (monotonic, s), and the picture."""
        with self._lock:
            seen = self._newest[0]
            self._lock.wait_for(lambda: self._newest[0] != seen, PATIENCE)
            arrived, picture = self._newest
        if picture is None or arrived == seen:
            raise MeasurementError("the stream of pictures has ended")
        return arrived, picture

    def unrest(self) -> Tuple[float, np.ndarray]:
        """How much the next few pictures differ (grey levels), and the last of them.

        Those of several sizes, of which load chooses one, are not at rest.
        """
        *earlier, last = [self.next()[1] for _ in range(4)]
        if any(each.shape != last.shape for each in earlier):
            return math.inf, last
        return max(difference(each, last) for each in earlier), last


def difference(before: np.ndarray, after: np.ndarray) -> float:
    """Mean difference of two pictures (grey levels), whatever the noise of single pixels.

    Of two sizes, the smaller one's counts.
    """
    height, width = min(before.shape, after.shape)
    first, second = (
        cv2.blur(cv2.resize(each, (width, height), interpolation=cv2.INTER_AREA), (5, 5))
        for each in (before, after)
    )
    return float(np.abs(second - first).mean())


def command_to_picture(url: str, trials: int) -> List[float]:
    """Times (s) from the first message of a command to the first picture that shows it."""
    client = PictureClient(url, "/telex/cameras/turret/image_raw")
    commands = rospy.Publisher(
        "/telex/arm_teleop/delta_joint_cmds", JointJog, queue_size=1, tcp_nodelay=True
    )
    rospy.wait_for_message(
        "/telex/turret_position_controller/state", JointControllerState, PATIENCE
    )
    wait_until("somebody who listens to the arm", commands.get_num_connections)
    delays: List[float] = []
    quietest = min(client.unrest()[0] for _ in range(5))
    for trial in range(trials):
        time.sleep(STILL_AFTER)
        deadline = time.monotonic() + PATIENCE
        noise, still = client.unrest()
        while math.isinf(noise) or noise > CHANGED * max(quietest, LEAST_CHANGE):
            if time.monotonic() > deadline:
                raise MeasurementError(f"the picture does not come to rest after command {trial}")
            noise, still = client.unrest()
        jog = JointJog(joint_names=["turret_joint"], velocities=[0.3 * (-1.0) ** trial])
        moving = threading.Event()
        began = time.monotonic()
        sender = threading.Thread(target=_send, args=(commands, jog, moving))
        sender.start()
        try:
            arrived, picture = began, still
            least = max(CHANGED * noise, LEAST_CHANGE)
            while arrived <= began or difference(still, picture) < least:
                arrived, picture = client.next()
                if arrived > began + 30.0:
                    raise MeasurementError(
                        f"command {trial + 1} was not seen within 30 s: the picture differs by"
                        f" {difference(still, picture):.2f} grey levels, {least:.2f} would tell"
                    )
        finally:
            moving.set()
            sender.join()
        delays.append(arrived - began)
        if (trial + 1) % 10 == 0:
            print(f"  {trial + 1} of {trials}", flush=True)
    return delays


def _send(publisher: rospy.Publisher, jog: JointJog, until: threading.Event) -> None:
    """Send a command as a held key does."""
    while True:
        publisher.publish(jog)
        if until.wait(0.02):
            return


def by_day(seconds: float, trials: int, simulator: PrivateSimulator) -> List[Figure]:
    """Figures of the training hall by day."""
    live = Live(simulator)
    print("six cameras 640x480 ...", flush=True)
    for name in NAMES:
        live.configure(name, priority=0, **LARGE)
    seen = live.watch({name: 30.0 for name in NAMES}, seconds)
    figures = told(
        [
            Figure("six 640x480, none first: slowest", seen.slowest, "fps"),
            seen.beside("six 640x480, none first: slowest", seen.slowest, 10.0),
            Figure("six 640x480: all", sum(seen.rates.values()), "fps"),
            Figure("six 640x480: CPU per picture", seen.cpu * 1e3, "ms"),
            Figure("six 640x480: pose to JPEG, median", seen.age * 1e3, "ms"),
            seen.age_beside("six 640x480", 0.025),
            Figure("six 640x480: bare getCameraImage: CPU", seen.bare * 1e3, "ms"),
        ]
    )
    print("nobody watches any more ...", flush=True)
    idle = live.idle(seconds)
    figures += told(
        [Figure("nobody watches: cameras node", idle * 100.0, "% of a core", at_most=2.0)]
    )
    print("a full core, the front camera first ...", flush=True)
    live.configure("front", priority=1)
    seen = live.watch({name: 25.0 if name == "front" else 20.0 for name in NAMES}, seconds)
    label = "six 640x480, front asked 25, others 20"
    figures += told(
        [
            Figure(f"{label}: front", seen.rates["front"], "fps"),
            Figure(f"{label}: slowest other", seen.others, "fps"),
        ]
    )
    live.configure("front", priority=0)
    print("front 640x480, previews of the others ...", flush=True)
    asked = {name: 30.0 if name == "front" else 12.0 for name in NAMES}
    seen = live.watch(asked, seconds, previews=NAMES[1:])
    label = "front 640x480, five previews 320x240"
    figures += told(
        [
            Figure(f"{label}: front", seen.rates["front"], "fps"),
            seen.beside(f"{label}: front", seen.rates["front"], 25.0),
            Figure(f"{label}: slowest other", seen.others, "fps"),
            seen.beside(f"{label}: slowest other", seen.others, 10.0),
            Figure(f"{label}: cameras node", seen.use * 100.0, "% of a core"),
            Figure(f"{label}: pose to JPEG, median", seen.age * 1e3, "ms"),
            seen.age_beside(label, 0.025),
        ]
    )
    print("the same, while nothing moves ...", flush=True)
    seen = live.watch(asked, seconds, previews=NAMES[1:], moves=False)
    figures += told(
        [
            Figure(f"{label}, nothing moves: front", seen.rates["front"], "fps", at_least=25.0),
            Figure(f"{label}, nothing moves: slowest other", seen.others, "fps", at_least=10.0),
            Figure(f"{label}, nothing moves: cameras node", seen.use * 100.0, "% of a core"),
        ]
    )
    print(f"{trials} commands until they are seen ...", flush=True)
    live.configure("turret", rate=30.0, **LARGE)
    url = simulator.wait_for_param("/telex/video_server/url")
    with live.real_time():
        delays = command_to_picture(url, trials)
    label = "command in to changed picture out"
    figures += told(
        [
            Figure(f"{label}, median", quantile(delays, 0.5) * 1e3, "ms", at_most=120.0),
            Figure(f"{label}, longest", quantile(delays, 1.0) * 1e3, "ms"),
            Figure("real-time factor by day, worst", min(live.factors), "", at_least=0.99),
        ]
    )
    return figures


def by_night(seconds: float, simulator: PrivateSimulator) -> List[Figure]:
    """Figures of the same hall in the dark, with headlights."""
    live = Live(simulator)
    print("night, headlights, front 640x480, previews of the others ...", flush=True)
    for name in NAMES:
        live.configure(name, **LARGE)
    live.light_headlights()
    asked = {name: 25.0 if name == "front" else 10.0 for name in NAMES}
    seen = live.watch(asked, seconds, previews=NAMES[1:])
    return told(
        [
            Figure("night, headlights: front 640x480", seen.rates["front"], "fps"),
            seen.beside("night, headlights: front 640x480", seen.rates["front"], 20.0),
            Figure("night, headlights: slowest preview", seen.others, "fps"),
            seen.beside("night, headlights: slowest preview", seen.others, 8.0),
            Figure("night, headlights: cameras node", seen.use * 100.0, "% of a core"),
            Figure("night, headlights: CPU per picture", seen.cpu * 1e3, "ms"),
            Figure("night, headlights: pose to JPEG, median", seen.age * 1e3, "ms"),
            Figure("real-time factor by night, worst", min(live.factors), "", at_least=0.99),
        ]
    )


def night_scene(directory: str) -> str:
    """The training hall without any light, as a file."""
    source = f"{package_path('telex_sim')}/scenes/{WORLD}.yaml"
    with open(source) as file:
        scene = yaml.safe_load(file)
    scene["lights"] = {"sun": {"intensity": 0.0}, "ambient": 0.02}
    path = os.path.join(directory, "night.yaml")
    with open(path, "w") as file:
        yaml.safe_dump(scene, file)
    return path


def live(world: str, measure: Callable[[PrivateSimulator], List[Figure]]) -> List[Figure]:
    """Start a simulator, measure, and end it."""
    with PrivateSimulator(f"world:={world}", "pose:=ready") as simulator:
        simulator.wait_for_master()
        os.environ.update(simulator.environment())
        rospy.init_node("benchmark_cameras", anonymous=True, disable_signals=True)
        figures = measure(simulator)
        rospy.signal_shutdown("measured")
    return figures


def day(seconds: float, trials: int) -> List[Figure]:
    """Figures by day."""
    return live(WORLD, lambda simulator: by_day(seconds, trials, simulator))


def night(seconds: float) -> List[Figure]:
    """Figures by night."""
    with tempfile.TemporaryDirectory(prefix="telex-") as directory:
        return live(night_scene(directory), lambda simulator: by_night(seconds, simulator))


def smoke() -> List[Figure]:
    """One sample of all that is live, in one simulator, by night."""

    def measure(simulator: PrivateSimulator) -> List[Figure]:
        return by_night(0.4, simulator) + by_day(0.4, 1, simulator)

    with tempfile.TemporaryDirectory(prefix="telex-") as directory:
        return live(night_scene(directory), measure)
