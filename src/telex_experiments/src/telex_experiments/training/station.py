"""A whole station in a trial: CPU time of the node that records, and the way back to the start."""

from __future__ import annotations

import os
import statistics
import tempfile
import threading
import time
from typing import Any, Callable, List, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import CompressedImage
from std_srvs.srv import Trigger
from telex_msgs.msg import TrainingState
from telex_msgs.srv import OpenExercise

from telex_experiments.rigs.bringup import STATION, SimulatorStartError
from telex_experiments.rigs.private_simulator import PrivateSimulator, cpu_seconds
from telex_experiments.rigs.report import Figure
from telex_training.judging.trial_record import ENDED, RUNNING, WAITING

MOST_ABOVE_IDLE = 4.0
"""CPU of the recording node above that of an idle one (% of a core)."""
MOST_AGAIN = 2.0
"""From "again" to a picture of the start and the next repetition (s)."""
NAMESPACE = "/telex"
PICTURES = "cameras/front/image_raw/compressed"
RECORDER, IDLE = "training", "replay"
"""The node that records, and one of the same package that nobody asks for anything."""
_AHEAD, _ROUND = (0.4, 0.0), (0.0, 0.5)
"""Speeds (m/s, rad/s) with which it leaves its start, and with which it then turns on the spot."""
_COMMAND_PERIOD = 0.02
_PATIENCE = 120.0
_TRY, _LET_GO = 3.0, 0.5
"""Wall time for which it is driven off at a time, and between two of them (s)."""
_SETTLING = 3.0
"""Wall time before CPU time is counted (s)."""


class TrainingStation:
    """A station of its own with cameras and training, in which trials are begun.

    Parameters
    ----------
    Use it as a context manager, once in a process.
    """

    def __init__(self, exercise: str, setting: str) -> None:
        self._exercise, self._setting = exercise, setting
        self._folder = tempfile.TemporaryDirectory(prefix="telex-training-")
        self._simulator = PrivateSimulator(f"recordings:={self._folder.name}", launch=STATION)
        self._arrived = threading.Condition()
        self._state: Optional[TrainingState] = None
        self._waiting_since = self._picture = rospy.Time(0)

    def __enter__(self) -> TrainingStation:
        try:
            self._connect()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        rospy.signal_shutdown("the benchmark ends")
        try:
            self._simulator.__exit__()
        finally:
            self._folder.cleanup()

    def _connect(self) -> None:
        simulator = self._simulator
        simulator.wait_for_master()
        os.environ.update(simulator.environment(), ROS_NAMESPACE=NAMESPACE.strip("/"))
        simulator.wait_for_param(f"{NAMESPACE}/video_server/mounts/training")
        simulator.wait_for_param(f"{NAMESPACE}/video_server/mounts/replay")
        rospy.init_node("benchmark_training", anonymous=True, disable_signals=True)
        self._commands = rospy.Publisher(
            f"{NAMESPACE}/track_teleop/cmd_vel", Twist, queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber(f"{NAMESPACE}/training/state", TrainingState, self._hear_state)
        rospy.Subscriber(
            f"{NAMESPACE}/{PICTURES}", CompressedImage, self._see, queue_size=1, buff_size=2**22
        )
        simulator.wait_for("a picture", lambda: self._picture.to_nsec())

    def _hear_state(self, message: TrainingState) -> None:
        with self._arrived:
            if message.phase == WAITING and self._phase != WAITING:
                self._waiting_since = message.header.stamp
            self._state = message
            self._arrived.notify_all()

    def _see(self, message: CompressedImage) -> None:
        with self._arrived:
            self._picture = message.header.stamp
            self._arrived.notify_all()

    @property
    def _phase(self) -> str:
        return "" if self._state is None else str(self._state.phase)

    def _await(self, what: str, condition: Callable[[], bool]) -> None:
        with self._arrived:
            if not self._arrived.wait_for(condition, _PATIENCE):
                raise SimulatorStartError(f"no {what} within {_PATIENCE:g} s: {self._state}")

    def _ask(self, name: str, kind: Any = Trigger, **request: Any) -> None:
        service = f"{NAMESPACE}/training/{name}"
        rospy.wait_for_service(service, _PATIENCE)
        answer = rospy.ServiceProxy(service, kind)(**request)
        if not answer.success:
            raise SimulatorStartError(f"{service}: {answer.message}")

    def begin(self) -> None:
        """Open the exercise and start a trial, until the robot stands at its start."""
        self._ask("open", OpenExercise, exercise=self._exercise, setting=self._setting)
        self._ask("start")
        self._await("start of a trial", lambda: self._phase == WAITING)

    def _leave(self) -> None:
        """Drive off until the clock starts, and where nothing comes of it let go and begin anew.

        What was commanded before a node listened, or before it heard of a reset, is ignored until
        it pauses.
        """
        end = time.monotonic() + _PATIENCE
        while self._phase != RUNNING:
            if time.monotonic() > end:
                raise SimulatorStartError(f"the robot does not leave its start: {self._state}")
            self._drive_off()

    def _drive_off(self) -> None:
        until = time.monotonic() + _TRY
        self._drive(_AHEAD, lambda: self._phase == RUNNING or time.monotonic() > until)
        if self._phase != RUNNING:
            time.sleep(_LET_GO)

    def _drive(self, speeds: Tuple[float, float], enough: Callable[[], bool]) -> None:
        """Command speeds (m/s, rad/s) at the console's rate until it is enough."""
        message = Twist()
        message.linear.x, message.angular.z = speeds
        next_at = time.monotonic()
        while not enough():
            self._commands.publish(message)
            next_at += _COMMAND_PERIOD
            time.sleep(max(0.0, next_at - time.monotonic()))

    def recorder(self, seconds: float) -> List[Figure]:
        """CPU time of the recording node in a trial without pause, for so long (s)."""
        self.begin()
        self._leave()
        processes = self._simulator.processes()
        pids = [processes[name] for name in (RECORDER, IDLE)]
        settled = time.monotonic() + _SETTLING
        self._drive(_ROUND, lambda: time.monotonic() > settled)
        began, before = time.monotonic(), [cpu_seconds(pid) for pid in pids]
        self._drive(_ROUND, lambda: time.monotonic() > began + seconds)
        passed = time.monotonic() - began
        recorder, idle = (
            100.0 * (cpu_seconds(pid) - used) / passed for pid, used in zip(pids, before)
        )
        if self._phase != RUNNING:
            raise SimulatorStartError(f"the trial did not go on: {self._state}")
        self._ask("abort")
        self._await("end of the trial", lambda: self._phase == ENDED)
        return [
            Figure("recorder: node in a trial", recorder, "% of a core"),
            Figure("recorder: idle node", idle, "% of a core"),
            Figure(
                "recorder: above the idle node",
                recorder - idle,
                "% of a core",
                at_most=MOST_ABOVE_IDLE,
            ),
        ]

    def again(self, count: int) -> List[Figure]:
        """Wall time from "again" until the next repetition waits and a picture shows its start."""
        took = []
        self.begin()
        for _ in range(count):
            if self._phase == ENDED:
                self.begin()
            self._leave()
            pressed = time.monotonic()
            self._ask("again")
            self._await("next repetition", lambda: self._phase in (WAITING, ENDED))
            if self._phase == ENDED:
                continue
            self._await("picture", lambda: self._picture >= self._waiting_since)
            took.append(time.monotonic() - pressed)
        return [
            Figure("again: picture and ready, median", statistics.median(took), "s"),
            Figure("again: picture and ready, most", max(took), "s", at_most=MOST_AGAIN),
        ]
