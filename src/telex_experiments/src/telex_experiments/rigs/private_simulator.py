"""A simulator of one's own: its own ROS master, free ports, gone when it is closed.

For benchmarks and scripted runs that must not meet whatever else runs on the machine.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Tuple

import rosgraph

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.bringup import BRINGUP, Bringup, SimulatorStartError
from telex_experiments.rigs.private_master import free_port

__all__ = ["PrivateSimulator", "SimulatorStartError", "cpu_seconds"]


class PrivateSimulator(Bringup):
    """Runs ``telex_teleop bringup.launch`` on a master of its own.

    Parameters
    ----------
    *arguments : str
        roslaunch arguments, e.g. ``"pose:=drive"``; without others the operator's speed is full.
    launch : tuple of str
        See `Bringup`.
    environment : mapping of str to str, optional
        That of another checkout's shell; else this process's own.

    Attributes
    ----------
    began : float
        When it was started (monotonic time, s).

    Use it as a context manager; `master_uri` belongs into ``ROS_MASTER_URI`` before
    ``rospy.init_node``.
    """

    def __init__(
        self,
        *arguments: str,
        launch: Tuple[str, str] = BRINGUP,
        environment: Optional[Mapping[str, str]] = None,
    ) -> None:
        self._environment = os.environ if environment is None else environment
        miss_nothing()
        self.began = time.monotonic()
        port = free_port()
        self.master_uri = f"http://127.0.0.1:{port}"
        self._logs = tempfile.TemporaryDirectory(prefix="telex-")
        log = Path(self._logs.name) / "roslaunch.txt"
        super().__init__(arguments, self.environment(), log, (f"--port={port}",), launch)

    def environment(self) -> Dict[str, str]:
        """The environment for programs that are to talk to this simulator."""
        return {
            **self._environment,
            "ROS_MASTER_URI": self.master_uri,
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": self._logs.name,
        }

    def __enter__(self) -> PrivateSimulator:
        return self

    def __exit__(self, *exception: object) -> None:
        """End every process that was started; what one has measured is at hand by then."""
        self.end(timeout=0.0)
        self._logs.cleanup()

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


def cpu_seconds(pid: int) -> float:
    """CPU time, user and system, that process `pid` has used (s)."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
