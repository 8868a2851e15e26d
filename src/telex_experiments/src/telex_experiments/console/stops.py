"""Stops: whoever drives, or whatever stands between, is killed or stopped at full speed.

Times are sim time. They count from the last command that the robot's side received; where a
connection closes, from then; and from the first step of a simulator that was woken.
"""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple
from urllib.parse import urlsplit

import rospy
from geometry_msgs.msg import PoseStamped, Twist
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from telex_msgs.msg import TrackTeleopStatus

from telex_control.common.child_processes import KILLED_WITH_US
from telex_control.common.file_catalog import package_yaml
from telex_experiments.rigs.private_master import end_tree
from telex_experiments.rigs.report import Figure, MeasurementError, wait_until

SPEED = 1.0
"""m/s."""
STANDS = 0.02
"""Speed (m/s) below which the base is at rest."""
ZERO_WITHIN, SILENCE, CLOSED = 0.30, (0.55, 0.45), (0.30, 0.15)
"""Limits: of the belts' command (s); of standing and of the way (s, m), by what ended."""
ASLEEP = 1.0
"""Wall time (s) for which processes are stopped."""
POSES = ("drive", "ready")
DRIVE, TRACKS = "/telex/track_teleop/cmd_vel", "/telex/track_controller/cmd_vel"
DRIVER = Path(__file__).resolve().with_name("driver.py")
PATIENCE = 60.0
WATCHED = 1.5
"""Sim time (s) in which the robot has to come to rest, and to stay there."""


class StopDrill(NamedTuple):
    """What happens in a drill.

    Attributes
    ----------
    broken : str
        A node, or the process that drives: ``client`` or ``rostopic``.
    """

    broken: str
    by: signal.Signals

    @property
    def driver(self) -> str:
        """What drives."""
        return "rostopic" if self.broken == "rostopic" else "client"

    @property
    def closes(self) -> bool:
        """Whether a connection closes."""
        return self.by is signal.SIGKILL

    @property
    def heard_on(self) -> str:
        """Topic on which the robot's side receives the last command."""
        return TRACKS if self.broken == "track_teleop" else DRIVE


STOP_DRILLS: Dict[str, StopDrill] = {
    "client killed": StopDrill("client", signal.SIGKILL),
    "client stopped": StopDrill("client", signal.SIGSTOP),
    "bridge killed": StopDrill("rosbridge", signal.SIGKILL),
    "bridge stopped": StopDrill("rosbridge", signal.SIGSTOP),
    "track node killed": StopDrill("track_teleop", signal.SIGKILL),
    "track node stopped": StopDrill("track_teleop", signal.SIGSTOP),
    "rostopic killed": StopDrill("rostopic", signal.SIGKILL),
    "rostopic stopped": StopDrill("rostopic", signal.SIGSTOP),
    "simulator stopped and woken": StopDrill("simulator", signal.SIGSTOP),
}


class StopOutcome(NamedTuple):
    """How a stop went.

    Attributes
    ----------
    zero : float or None
        Until the command for the belts was zero (s); None where the track node that sends it is
        what was broken: then the controller's own watchdog acts.
    stood, way : float
        Until the base stood (s), and how far it came meanwhile (m).
    """

    zero: Optional[float]
    stood: float
    way: float


class _Log:
    """What the robot does and is told, in sim time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._places: List[Tuple[float, Tuple[float, float, float]]] = []
        self._told: Dict[str, List[Tuple[float, float]]] = {DRIVE: [], TRACKS: []}
        self._ahead: List[Tuple[float, float]] = []
        self.newest = 0.0
        self.scale: Optional[float] = None
        self.max_linear = 0.0
        self._subscribers = [
            self._subscribe("/clock", Clock, self._on_clock),
            self._subscribe("/telex/sim/base_pose", PoseStamped, self._on_pose),
            self._subscribe(DRIVE, Twist, lambda message: self._on_command(DRIVE, message)),
            self._subscribe(TRACKS, Twist, lambda message: self._on_command(TRACKS, message)),
            self._subscribe("/telex/track_teleop/status", TrackTeleopStatus, self._on_status),
        ]

    @staticmethod
    def _subscribe(topic: str, kind: type, receive: Callable[..., None]) -> rospy.Subscriber:
        return rospy.Subscriber(topic, kind, receive, queue_size=100, tcp_nodelay=True)

    def _on_clock(self, message: Clock) -> None:
        now, self.newest = time.monotonic(), message.clock.to_sec()
        with self._lock:
            self._ahead.append((now, self.newest - now))
            del self._ahead[:-50]

    def _on_pose(self, message: PoseStamped) -> None:
        place = message.pose.position
        with self._lock:
            self._places.append((message.header.stamp.to_sec(), (place.x, place.y, place.z)))

    def _on_command(self, topic: str, message: Twist) -> None:
        now = self.now()
        with self._lock:
            self._told[topic].append((now, message.linear.x))

    def _on_status(self, message: TrackTeleopStatus) -> None:
        self.scale, self.max_linear = message.speed_scale, message.max_linear

    def now(self) -> float:
        """Sim time (s): messages of the clock are late, now and then; the earliest count."""
        wall = time.monotonic()
        with self._lock:
            recent = [ahead for at, ahead in self._ahead if wall - at < 0.3]
        return wall + max(recent) if recent else self.newest

    def forget(self) -> None:
        """Forget what was before."""
        with self._lock:
            del self._places[:]
            for told in self._told.values():
                del told[:-1]

    def told(self, topic: str) -> List[Tuple[float, float]]:
        """Sim time and speed of all commands on a topic."""
        with self._lock:
            return list(self._told[topic])

    def places(self) -> List[Tuple[float, Tuple[float, float, float]]]:
        """Sim time and place of the base."""
        with self._lock:
            return list(self._places)

    def speeds(self) -> List[Tuple[float, float]]:
        """Sim time and speed of the base (m/s), between one place and the next."""
        places = self.places()
        return [
            (0.5 * (before + after), math.dist(a, b) / (after - before))
            for (before, a), (after, b) in zip(places, places[1:])
            if after > before
        ]


class Stops:
    """Does the drills.

    Parameters
    ----------
    pid_of : callable
        Gives the process of a node of the robot, None while there is none.
    bridge_url : callable
        Gives the address of the bridge for a plain client.
    """

    def __init__(
        self, pid_of: Callable[[str], Optional[int]], bridge_url: Callable[[], str]
    ) -> None:
        self._pid_of = pid_of
        self._bridge_url = bridge_url
        self._log = _Log()
        self._scale = rospy.Publisher("/telex/track_teleop/speed_scale", Float64, queue_size=1)
        self._joints: Dict[str, rospy.Publisher] = {}

    def take_pose(self, name: str) -> None:
        """Bring arm and flippers into a named pose, and wait for it."""
        poses = package_yaml("telex_description", "config", "poses.yaml")
        for joint, position in poses["poses"][name].items():
            topic = f"/telex/{joint.replace('_joint', '_position_controller')}/command"
            if joint not in self._joints:
                self._joints[joint] = rospy.Publisher(topic, Float64, queue_size=1, latch=True)
            self._joints[joint].publish(position)
        end = self._log.now() + 12.0
        _wait("the pose", lambda: self._log.now() > end)

    def drill(self, way: StopDrill, backwards: bool) -> StopOutcome:
        """Drive at full speed, break something, see, and mend it."""
        log = self._log
        _wait("the robot to stand", lambda: log.speeds()[-1:] and log.speeds()[-1][1] < STANDS)
        self._set_speed()
        log.forget()
        driver = self._start(way.driver, -log.max_linear if backwards else log.max_linear)
        try:
            self._wait_for_speed()
            pid = driver.pid if way.broken == way.driver else self._pid_of(way.broken)
            if pid is None:
                raise MeasurementError(f"there is no process of {way.broken}")
            begin = self._break(way, pid)
            _wait("the robot to stand", lambda: self._log.newest > begin + WATCHED)
            stop = self._judge(way, begin)
        finally:
            # It may be stopped, and would not end when it is asked.
            end_tree(driver, timeout=0.0)
        if way.by is signal.SIGSTOP:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)
        _wait(f"{way.broken} to be back", lambda: self._is_whole(way))
        # For a stream that was broken off is to be forgotten.
        time.sleep(0.7)
        return stop

    def _start(self, driver: str, speed: float) -> subprocess.Popen:
        if driver == "client":
            command = [sys.executable, str(DRIVER), self._bridge_url(), repr(speed)]
        else:
            message = f"{{linear: {{x: {speed!r}}}}}"
            command = ["rostopic", "pub", "-r", "50", DRIVE, "geometry_msgs/Twist", message]
        return subprocess.Popen(
            [*KILLED_WITH_US, *command],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    def _set_speed(self) -> None:
        """Let the highest speed be that of the drills."""
        log = self._log

        def is_set() -> bool:
            if not log.max_linear:
                return False
            wanted = SPEED / log.max_linear
            self._scale.publish(wanted)
            time.sleep(0.1)
            return log.scale is not None and abs(log.scale - wanted) < 1e-6

        _wait("the track node to take the speed", is_set)

    def _wait_for_speed(self) -> None:
        def at_speed() -> bool:
            latest = self._log.speeds()[-10:]
            return len(latest) == 10 and all(abs(v - SPEED) < 0.05 * SPEED for _, v in latest)

        _wait("the robot to drive at full speed", at_speed)

    def _break(self, way: StopDrill, pid: int) -> float:
        """Break something, and return the sim time (s) from which the stop counts."""
        log = self._log
        broken = log.now()
        os.kill(pid, way.by)
        if way.closes:
            return broken
        time.sleep(ASLEEP)
        if way.broken == "simulator":
            # The last that was said before; nothing goes on until it is woken.
            broken = log.newest
            os.kill(pid, signal.SIGCONT)
            return broken
        return [at for at, speed in log.told(way.heard_on) if speed != 0.0][-1]

    def _judge(self, way: StopDrill, begin: float) -> StopOutcome:
        log = self._log
        zero: Optional[float] = None
        if way.broken != "track_teleop":
            zeros = [at for at, speed in log.told(TRACKS) if speed == 0.0 and at >= begin - 0.01]
            zero = max(0.0, zeros[0] - begin) if zeros else float("inf")
        speeds = [each for each in log.speeds() if each[0] >= begin - 0.02]
        moving = [index for index, (_, speed) in enumerate(speeds) if speed >= STANDS]
        if not moving:
            raise MeasurementError("the robot did not drive")
        last = moving[-1]
        if last + 1 == len(speeds):
            return StopOutcome(zero, float("inf"), float("inf"))
        (before, fast), (after, slow) = speeds[last : last + 2]
        stood = before + (after - before) * (fast - STANDS) / (fast - slow)
        places = log.places()
        return StopOutcome(zero, stood - begin, math.dist(_at(places, begin), places[-1][1]))

    def _is_whole(self, way: StopDrill) -> bool:
        if way.broken in ("client", "rostopic"):
            return True
        log = self._log
        if self._pid_of(way.broken) is None:
            return False
        if way.broken == "rosbridge" and way.closes:
            return _listens(self._bridge_url())
        if way.broken == "track_teleop" and way.closes:
            log.scale = None
            time.sleep(1.0)
            return log.scale is not None
        return True


def _listens(url: str) -> bool:
    """Whether a server accepts connections."""
    parts = urlsplit(url)
    try:
        socket.create_connection((parts.hostname, parts.port or 80), 1.0).close()
    except OSError:
        return False
    return True


def _at(places: List[Tuple[float, Tuple[float, float, float]]], time_: float) -> Tuple:
    """Place at a sim time (m), between those that were seen."""
    for (before, a), (after, b) in zip(places, places[1:]):
        if before <= time_ <= after:
            share = (time_ - before) / (after - before)
            return tuple(x + share * (y - x) for x, y in zip(a, b))
    return places[0][1] if time_ < places[0][0] else places[-1][1]


def _wait(what: str, condition: Callable[[], object]) -> None:
    wait_until(what, condition, PATIENCE)


def in_time(way: StopDrill, stop: StopOutcome) -> bool:
    """Whether a stop was as it has to be."""
    seconds, metres = CLOSED if way.closes else SILENCE
    zero = stop.zero is None or stop.zero <= ZERO_WITHIN
    return zero and stop.stood <= seconds and stop.way <= metres


def told(stop: StopOutcome) -> str:
    """A stop in words."""
    zero = "" if stop.zero is None else f"zero after {stop.zero:.3f} s, "
    return f"{zero}stands after {stop.stood:.3f} s and {stop.way:.3f} m"


def stop_figures(stops: Stops, times: int, names: Optional[List[str]] = None) -> List[Figure]:
    """Do all drills, each some times: half in each pose, forwards and backwards in turn."""
    found: Dict[str, List[StopOutcome]] = {name: [] for name in (names or STOP_DRILLS)}
    for number, pose in enumerate(POSES):
        stops.take_pose(pose)
        for name, done in found.items():
            for turn in range((times + 1 - number) // 2):
                stop = stops.drill(STOP_DRILLS[name], backwards=turn % 2 == 1)
                done.append(stop)
                print(f"  {name}, {pose}, {turn + 1}: {told(stop)}", flush=True)
    return [figure for name, done in found.items() for figure in _figures(name, done)]


def _figures(name: str, stops: List[StopOutcome]) -> List[Figure]:
    count, way = len(stops), STOP_DRILLS[name]
    seconds, metres = CLOSED if way.closes else SILENCE
    what = f"{name}: at rest within {seconds:g} s and {metres:g} m"
    good = sum(in_time(way, stop) for stop in stops)
    times, ways = [stop.stood for stop in stops], [stop.way for stop in stops]
    zeros = [stop.zero for stop in stops if stop.zero is not None]
    figures = [Figure(what, good, f"of {count}", at_least=count)]
    if zeros:
        figures.append(Figure(f"{name}: belts commanded to zero, longest", max(zeros), "s"))
    return [
        *figures,
        Figure(f"{name}: at rest after, median", statistics.median(times), "s"),
        Figure(f"{name}: at rest after, longest", max(times), "s"),
        Figure(f"{name}: way, longest", max(ways), "m"),
    ]
