"""A running ``bringup.launch``: its processes, and what they print."""

from __future__ import annotations

import contextlib
import subprocess
import time
from pathlib import Path
from typing import Callable, Dict, List, Mapping, Sequence, Tuple, TypeVar

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import STOP_TIMEOUT, descendants, end_tree

Value = TypeVar("Value")

DEFAULTS = ("video_port:=0", "bridge_port:=0", "speed:=1")
"""Console and bridge take free ports, and the operator's speed is the full one."""

BRINGUP = ("telex_teleop", "bringup.launch")
STATION = ("telex_training", "station.launch")
"""Simulator, robot and console; the same with the training."""


class SimulatorStartError(RuntimeError):
    """The simulator did not come up; the message holds the end of its output."""


class Bringup:
    """Runs ``telex_teleop bringup.launch``, or a launch file that includes it; to be ended.

    Parameters
    ----------
    arguments : sequence of str
        Of the launch file, e.g. ``pose:=drive``; they go before `DEFAULTS`.
    environment : mapping of str to str
        With the master that it is to use.
    log : Path
        What roslaunch and its nodes print is appended to this file.
    options : sequence of str
        Of roslaunch.
    launch : tuple of str
        Package and launch file.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        log: Path,
        options: Sequence[str] = (),
        launch: Tuple[str, str] = BRINGUP,
    ) -> None:
        self._log = log
        command = [
            *DIES_WITH_US,
            *("roslaunch", *options, "--sigint-timeout=1.5", "--sigterm-timeout=1.0"),
            *(*launch, *DEFAULTS, *arguments),
        ]
        with open(log, "a") as output:
            print(f"==== {' '.join(command)}", file=output, flush=True)
            self._process = subprocess.Popen(
                command,
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        """Process of roslaunch."""
        return self._process.pid

    def end(self, timeout: float = STOP_TIMEOUT) -> None:
        """End every process that was started; after some time (s), those that are left are killed.

        An end in order takes seconds.
        """
        end_tree(self._process, timeout)

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
        return "".join(self._log.read_text(errors="replace").splitlines(True)[-lines:])
