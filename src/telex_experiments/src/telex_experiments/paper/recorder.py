"""Records a run as a bag: what the robot did, was told, and saw.

The recorder has a process of its own (``python -m telex_experiments.paper.recorder``): rospy cannot
listen to a topic with and without its type in one process.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Dict, Optional, Sequence, Tuple

import roslib.message
import rospy
from rosbag import Bag, Compression

from telex_control.common.child_processes import DIES_WITH_US
from telex_control.common.scheduling import add_niceness
from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import end_tree

TOPICS: Tuple[str, ...] = (
    "joint_states",
    "sim/base_pose",
    "sim/status",
    "sim/stability",
    "sim/gripper_contact",
    "sim/proximity",
    "imu",
    "track_controller/cmd_vel",
    "track_controller/odom",
    "track_teleop/cmd_vel",
    "arm_teleop/delta_joint_cmds",
    "arm_teleop/delta_twist_cmds",
    "arm_teleop/pose_cmds",
    "arm_teleop/named_pose_cmds",
    "arm_teleop/cartesian_status",
    "gripper_teleop/delta_joint_cmds",
    "flipper_teleop/delta_joint_cmds",
    "flipper_teleop/preset_cmds",
    "arm_teleop/status",
    "gripper_teleop/status",
    "flipper_teleop/status",
    "track_teleop/status",
    "gripper_controller/gripper_cmd/goal",
    "gripper_controller/gripper_cmd/feedback",
    "gripper_controller/gripper_cmd/result",
    "e_stop",
)
"""In the robot's namespace: states, ground truth, and every command of an operator."""

ARM_COMMANDS: Tuple[str, ...] = tuple(
    f"{joint}_position_controller/command"
    for joint in (
        *("turret", "shoulder", "telescope", "elbow"),
        *("forearm_roll", "wrist_pitch", "gripper_roll"),
    )
)
"""What tools command that lead the arm's joints by themselves."""

FRAMES: Tuple[str, ...] = ("/tf", "/tf_static")

RATES: Dict[str, float] = {
    "/tf": 25.0,
    "joint_states": 50.0,
    "imu": 25.0,
    "sim/base_pose": 25.0,
    "sim/proximity": 10.0,
    "track_controller/odom": 25.0,
}
"""Messages a second of sim time at most; of other topics all are kept."""

PICTURES = 5.0
"""Of each camera a second of sim time."""

FEW_PICTURES = 2.0
"""Where what is recorded needs the processor, or has been seen in another run."""

READY = "recording"
"""What the process says once it listens."""

_NICENESS = 10

_CLOCK_TIMEOUT = 10.0
"""How long (s) it waits for the first clock; without one, it records all the same."""

_PERIOD_SHARE = 0.9
"""A message that comes this share of a period after the last one is kept: stamps jitter."""


class Throttle:
    """Thins a stream out.

    Parameters
    ----------
    rate : float, optional
        Of what is kept at most (Hz); without one, all is kept.
    """

    def __init__(self, rate: Optional[float]) -> None:
        self._period = 0.0 if rate is None else _PERIOD_SHARE / rate
        self._last: Dict[str, float] = {}

    def keeps(self, now: float, key: str = "") -> bool:
        """Tell whether a message is kept, that comes at `now` (s) in one of several streams."""
        last = self._last.get(key)
        # A clock that was set back begins anew.
        if last is not None and 0.0 <= now - last < self._period:
            return False
        self._last[key] = now
        return True


class RecorderError(RuntimeError):
    """The recorder did not start."""


class Recorder:
    """Records a bag in a process of its own while it is entered.

    Parameters
    ----------
    namespace : str
        Of the robot.
    log : Path
        What it prints is appended to this file.
    topics : sequence of str
        Relative to the namespace, in addition to `TOPICS`.
    cameras : sequence of str
        Whose compressed pictures are recorded. Asking for them makes the simulator draw them.
    rate : float
        Of each camera's pictures (Hz of sim time).

    Raises
    ------
    RecorderError
        On entry.
    """

    def __init__(
        self,
        path: Path,
        namespace: str,
        log: Path,
        topics: Sequence[str] = (),
        cameras: Sequence[str] = (),
        rate: float = PICTURES,
    ) -> None:
        self._log = log
        self._command = [
            *(sys.executable, "-m", "telex_experiments.paper.recorder", str(path), namespace),
            *("--rate", str(rate), "--topics", *topics, "--cameras", *cameras),
        ]
        self._process: Optional[subprocess.Popen] = None

    def __enter__(self) -> Recorder:
        with open(self._log, "a") as log:
            self._process = subprocess.Popen(
                [*DIES_WITH_US, *self._command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                start_new_session=True,
            )
        if self._process.stdout is None or self._process.stdout.readline().strip() != READY:
            self.__exit__()
            raise RecorderError(f"the recorder did not start; {self._log} says why")
        return self

    def __exit__(self, *exception: object) -> None:
        """End it, and wait until the bag is whole."""
        if self._process is not None:
            end_tree(self._process)
            if self._process.stdout is not None:
                self._process.stdout.close()
            self._process = None


class Writer:
    """Writes messages to a bag, at the sim time when they come, until it is closed.

    Parameters
    ----------
    rates : dict of str to float or None
        Topics, and how many messages a second of sim time are kept at most.
    """

    def __init__(self, path: Path, rates: Dict[str, Optional[float]]) -> None:
        self._lock = threading.Lock()
        # Pictures are compressed already, and the rest is little beside them; LZ4 costs next to
        # nothing where a better compression would hold up the callbacks.
        self._bag: Optional[Bag] = Bag(str(path), "w", compression=Compression.LZ4)
        for topic, rate in rates.items():
            rospy.Subscriber(topic, rospy.AnyMsg, self._write, (topic, Throttle(rate)))

    def close(self) -> None:
        """Finish the bag."""
        with self._lock:
            if self._bag is not None:
                self._bag.close()
                self._bag = None

    def _write(self, message: Any, stream: Tuple[str, Throttle]) -> None:
        topic, throttle = stream
        header = message._connection_header
        now = rospy.get_rostime()
        # Bags know no time 0, which is what a clock shows that has not come yet.
        if not now:
            now = rospy.Time(nsecs=1)
        # The static frames of one publisher after the other are all needed.
        if not throttle.keeps(now.to_sec(), header.get("callerid", "")):
            return
        kind = roslib.message.get_message_class(header["type"])
        if kind is None:
            return
        raw = (header["type"], message._buff, header["md5sum"], kind)
        with self._lock:
            if self._bag is not None:
                self._bag.write(topic, raw, now, raw=True, connection_header=header)


def rates(
    namespace: str, topics: Sequence[str], cameras: Sequence[str], rate: float
) -> Dict[str, Optional[float]]:
    """Return what is recorded, and how much of it; see `Recorder`."""
    found: Dict[str, Optional[float]] = {name: RATES.get(name) for name in FRAMES}
    for name in (*TOPICS, *topics):
        found[f"{namespace}/{name}"] = RATES.get(name)
    for camera in cameras:
        found[f"{namespace}/cameras/{camera}/image_raw/compressed"] = rate
        found[f"{namespace}/cameras/{camera}/camera_info"] = rate
    return found


def _await_clock(ended: threading.Event) -> None:
    """Wait for the sim time: what came before it would begin the bag minutes before the rest."""
    until = time.monotonic() + _CLOCK_TIMEOUT
    while not rospy.get_rostime() and time.monotonic() < until:
        if ended.wait(0.01):
            return


def main() -> None:
    """Record until SIGINT or SIGTERM."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    parser.add_argument("namespace")
    parser.add_argument("--rate", type=float, default=PICTURES)
    parser.add_argument("--topics", nargs="*", default=[])
    parser.add_argument("--cameras", nargs="*", default=[])
    options = parser.parse_args()
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: ended.set())
    # Where the processor is short, what is recorded may come late; what drives the robot may not.
    add_niceness(_NICENESS)
    miss_nothing()
    rospy.init_node("recorder", anonymous=True, disable_signals=True)
    _await_clock(ended)
    writer = Writer(
        options.path, rates(options.namespace, options.topics, options.cameras, options.rate)
    )
    print(READY, flush=True)
    ended.wait()
    writer.close()
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
