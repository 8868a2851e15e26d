"""The real system, started as `run.sh` starts it, on the ROS master of the experiment."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path
from typing import List, Optional, Union

import rospy

from telex_experiments.rigs.bringup import Bringup, SimulatorStartError
from telex_experiments.rigs.private_master import PrivateMaster

from ..workspace import ROOT

Argument = Union[str, float, bool]

WAIT_READY = ROOT / "launch_scripts" / "wait_ready.py"
START_TIMEOUT = 240.0
"""Time (s), long enough for a machine that has other things to do."""


class Simulator:
    """Runs ``telex_teleop bringup.launch``; ready to be driven once it is entered.

    Parameters
    ----------
    log : Path
        What roslaunch and its nodes print is appended to this file.
    **arguments
        Of the launch file. Without others, console and bridge take free ports, and the operator's
        speed is the full one.

    Attributes
    ----------
    namespace : str
        Of the robot.
    video_url : str, optional
        Of the console, where one was asked for.
    """

    def __init__(self, master: PrivateMaster, log: Path, **arguments: Argument) -> None:
        self._master = master
        self._log = log
        self._arguments = arguments
        self._bringup: Optional[Bringup] = None
        self.namespace = f"/{self._arguments.get('ns', 'telex')}"
        self.video_url: Optional[str] = None

    def __enter__(self) -> Simulator:
        words = [f"{name}:={_word(value)}" for name, value in self._arguments.items()]
        environment = self._master.environment()
        self._bringup = Bringup(words, environment, self._log, ("--no-summary",))
        try:
            self._wait_until_ready(self._bringup)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        """End every process that was started."""
        if self._bringup is None:
            return
        self._bringup.end()
        self._bringup = None
        # The next one must not be taken for this: its address is one of the first things read.
        with contextlib.suppress(KeyError):
            rospy.delete_param(f"{self.namespace}/video_server/url")

    def _wait_until_ready(self, bringup: Bringup) -> None:
        leave_out: List[str] = []
        if self._arguments.get("console", True) is False:
            leave_out.append("--no-console")
        if self._arguments.get("cameras", True) is False:
            leave_out.append("--no-picture")
        waiting = subprocess.run(
            [
                *(sys.executable, str(WAIT_READY), "--namespace", self.namespace),
                *("--launch-pid", str(bringup.pid), "--timeout", str(START_TIMEOUT), *leave_out),
            ],
            env=self._master.environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        if waiting.returncode != 0:
            raise SimulatorStartError(f"{waiting.stdout.strip()}\n{bringup.output_tail(20)}")
        if "--no-console" not in leave_out:
            self.video_url = str(rospy.get_param(f"{self.namespace}/video_server/url"))


def _word(value: Argument) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
