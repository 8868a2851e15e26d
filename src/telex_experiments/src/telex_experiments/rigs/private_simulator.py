"""A simulator of one's own: its own ROS master, free ports, gone when it is closed.

For benchmarks and scripted runs that must not meet whatever else runs on the machine.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
import time
from typing import Any, Callable, Dict, List, TypeVar

import rosgraph

from telex_control.ros.private_master import DIES_WITH_US, descendants, end_tree, free_port
from telex_control.ros.rospy_fixes.connecting import miss_nothing

Value = TypeVar("Value")


class SimulatorStartError(RuntimeError):
    """The simulator did not come up; the message holds the end of its output."""


class PrivateSimulator:
    """Runs ``telex_teleop bringup.launch`` on a master of its own.

    Parameters
    ----------
    *arguments : str
        roslaunch arguments, e.g. ``"pose:=drive"``; without others the operator's speed is full.

    Attributes
    ----------
    began : float
        When it was started (monotonic time, s).

    Use it as a context manager; `master_uri` belongs into ``ROS_MASTER_URI`` before
    ``rospy.init_node``.
    """

    def __init__(self, *arguments: str) -> None:
        miss_nothing()
        self.began = time.monotonic()
        port = free_port()
        self.master_uri = f"http://127.0.0.1:{port}"
        self._logs = tempfile.TemporaryDirectory(prefix="telex-")
        self._output = open(os.path.join(self._logs.name, "roslaunch.txt"), "w+")  # noqa: SIM115
        self._process = subprocess.Popen(
            [
                *DIES_WITH_US,
                "roslaunch",
                f"--port={port}",
                "--sigint-timeout=1.5",
                "--sigterm-timeout=1.0",
                "telex_teleop",
                "bringup.launch",
                "video_port:=0",
                "bridge_port:=0",
                "speed:=1",
                *arguments,
            ],
            env=self.environment(),
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    @property
    def pid(self) -> int:
        """Process of roslaunch."""
        return self._process.pid

    def environment(self) -> Dict[str, str]:
        """The environment for programs that are to talk to this simulator."""
        return {
            **os.environ,
            "ROS_MASTER_URI": self.master_uri,
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": self._logs.name,
        }

    def __enter__(self) -> PrivateSimulator:
        return self

    def __exit__(self, *exception: object) -> None:
        """End every process that was started."""
        end_tree(self._process)
        self._output.close()
        self._logs.cleanup()

    def wait_for(self, what: str, condition: Callable[[], Value], timeout: float = 120.0) -> Value:
        """Return the first true value of `condition`.

        Raises
        ------
        SimulatorStartError
            It did not come within `timeout` s, or the simulator ended.
        """
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if self._process.poll() is not None:
                raise SimulatorStartError(f"the simulator ended:\n{self.output_tail()}")
            value = condition()
            if value:
                return value
            time.sleep(0.1)
        raise SimulatorStartError(f"no {what} within {timeout} s:\n{self.output_tail()}")

    def wait_for_master(self) -> None:
        """Wait until the master answers."""
        self.wait_for("ROS master", lambda: rosgraph.is_master_online(self.master_uri))

    def wait_for_param(self, name: str) -> Any:
        """Wait until a parameter is set, and return it."""
        master = rosgraph.Master("/private_simulator", master_uri=self.master_uri)

        def get() -> Any:
            try:
                return master.getParam(name)
            except (OSError, rosgraph.MasterError):
                return None

        return self.wait_for(f"parameter {name}", get)

    def processes(self) -> Dict[str, int]:
        """Process ids of all nodes by node name, as their command lines tell."""
        found = {}
        for pid in descendants(self._process.pid):
            words: List[str] = []
            # It may have ended since it was listed.
            with contextlib.suppress(OSError), open(f"/proc/{pid}/cmdline", "rb") as file:
                words = file.read().decode(errors="replace").split("\0")
            for word in words:
                if word.startswith("__name:="):
                    found[word[len("__name:=") :]] = pid
        return found

    def output_tail(self, lines: int = 30) -> str:
        """The last lines that roslaunch and its nodes have printed."""
        self._output.flush()
        with open(self._output.name, errors="replace") as file:
            return "".join(file.readlines()[-lines:])


def cpu_seconds(pid: int) -> float:
    """CPU time, user and system, that process `pid` has used (s)."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
