"""The cameras' node of a replay, as a child process: it runs while somebody looks."""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Dict, Mapping, Optional

import rospy

from telex_control.common.child_processes import DIES_WITH_US

_ENDING = 5.0
_AGAIN = 2.0
"""Time (s) before it is started again, once it has ended by itself."""


class CamerasProcess:
    """Starts, restarts and ends the node ``cameras`` in a namespace.

    Parameters
    ----------
    namespace : str
        Full name.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._config: Optional[Mapping[str, Any]] = None
        self._process: Optional[subprocess.Popen[bytes]] = None
        self._started = -_AGAIN
        self._starter = ThreadPoolExecutor(1, "cameras process")

    @property
    def runs(self) -> bool:
        """Whether it runs."""
        return self._process is not None and self._process.poll() is None

    def require(self, config: Mapping[str, Any]) -> bool:
        """Have it run with these parameters; returns whether it had to be started.

        It is read by the node when it starts: other parameters need another process.
        """
        if self.runs and config == self._config:
            return False
        ended_by_itself = self._process is not None and not self.runs
        self.end()
        if ended_by_itself:
            time.sleep(max(0.0, self._started + _AGAIN - time.monotonic()))
        parameters = f"{self._namespace}/cameras"
        with contextlib.suppress(KeyError):
            rospy.delete_param(parameters)
        rospy.set_param(parameters, dict(config))
        environment: Dict[str, str] = {**os.environ, "ROS_NAMESPACE": self._namespace}
        # It would be ended with the thread that starts it, and that of a service's call is short.
        self._process = self._starter.submit(
            subprocess.Popen,
            [*DIES_WITH_US, "rosrun", "telex_sim", "cameras", "__name:=cameras"],
            env=environment,
            stdin=subprocess.DEVNULL,
        ).result()
        self._config, self._started = config, time.monotonic()
        return True

    def end(self) -> None:
        """End it, if it runs."""
        process, self._process = self._process, None
        if process is None:
            return
        process.terminate()
        try:
            process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
