"""A ROS master of one's own on a free port, for tests, benchmarks and scripted runs."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import signal
import socket
import subprocess
import tempfile
import time
from typing import Dict, List, Optional

import rosgraph

from telex_control.common.child_processes import DIES_WITH_US

START_TIMEOUT = 30.0
"""Time (s) within which roscore has to come up."""

STOP_TIMEOUT = 10.0
"""Time (s) that a process gets to end after SIGINT."""

_LEAST_PORT = 12000
"""Above the usual ports of ROS, and of other servers."""


class PrivateMasterError(RuntimeError):
    """The master did not come up; the message holds the end of its output."""


def free_port() -> int:
    """Return a TCP port that nobody has now, and that no outgoing connection is given."""
    for port in (*_unasked_ports(), 0):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("", port))
            return int(probe.getsockname()[1])
    raise OSError(errno.EADDRINUSE, "no TCP port is free")


def _unasked_ports() -> List[int]:
    """Some ports below those that the kernel chooses from; none where it chooses from all."""
    try:
        with open("/proc/sys/net/ipv4/ip_local_port_range") as file:
            below = int(file.read().split()[0])
    except (OSError, ValueError):
        return []
    if below <= _LEAST_PORT:
        return []
    # Not those that a seed gives two processes alike.
    return [random.SystemRandom().randrange(_LEAST_PORT, below) for _ in range(50)]


def end_tree(process: subprocess.Popen, timeout: float = STOP_TIMEOUT) -> None:
    """End a process and everything that it has started.

    Parameters
    ----------
    process
        Leader of its process group, which gets SIGINT to end its children itself. (roslaunch and
        rospy take it also where a shell has made this process ignore it.)
    timeout
        Time (s) after which it is killed; its descendants that are left then are killed in any
        case, also those that have a session of their own, as roslaunch's nodes have.
    """
    # A child whose parent has ended is nobody's descendant: remember them before.
    tree = {pid: start_time(pid) for pid in descendants(process.pid)}
    _signal_group(process.pid, signal.SIGINT)
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        tree.update({pid: start_time(pid) for pid in descendants(process.pid)})
    _signal_group(process.pid, signal.SIGKILL)
    for pid, started in tree.items():
        # The number may belong to somebody else by now.
        if started is not None and start_time(pid) == started:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
    process.wait()


def descendants(pid: int) -> List[int]:
    """Return the process ids of the children of a process, of their children, and so on."""
    children: List[int] = []
    gone = (FileNotFoundError, ProcessLookupError)
    with contextlib.suppress(*gone):
        for task in os.listdir(f"/proc/{pid}/task"):
            # A thread that ends meanwhile hides nothing of the others.
            with contextlib.suppress(*gone), open(f"/proc/{pid}/task/{task}/children") as file:
                children += [int(word) for word in file.read().split()]
    return children + [each for child in children for each in descendants(child)]


def _signal_group(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, number)


def start_time(pid: int) -> Optional[str]:
    """Return when a process began (clock ticks since boot), which tells it from later ones.

    None if there is none of that id.
    """
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[19]
    except (FileNotFoundError, ProcessLookupError):
        return None


class PrivateMaster:
    """A roscore on a free port, with a log folder of its own; gone when it is closed.

    Use it as a context manager.

    Attributes
    ----------
    uri : str
        What belongs into ``ROS_MASTER_URI``.

    Raises
    ------
    PrivateMasterError
        On entry: roscore did not come up.
    """

    def __init__(self) -> None:
        self.port = free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self._folder = tempfile.TemporaryDirectory(prefix="telex-master-")
        self._core: Optional[subprocess.Popen] = None

    def environment(self, **more: str) -> Dict[str, str]:
        """Return the environment for programs that are to use this master.

        Parameters
        ----------
        **more
            Further variables, such as ``ROS_NAMESPACE``; one that this process has stays out.
        """
        inherited = {key: value for key, value in os.environ.items() if key != "ROS_NAMESPACE"}
        return {
            **inherited,
            "ROS_MASTER_URI": self.uri,
            "ROS_HOSTNAME": "127.0.0.1",
            "ROS_HOME": self._folder.name,
            "ROS_LOG_DIR": os.path.join(self._folder.name, "log"),
            **more,
        }

    def __enter__(self) -> PrivateMaster:
        output = os.path.join(self._folder.name, "roscore.txt")
        with open(output, "w") as file:
            self._core = subprocess.Popen(
                [*DIES_WITH_US, "roscore", "-p", str(self.port)],
                env=self.environment(),
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            self._wait_until_up(self._core, output)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        """End every process that was started."""
        if self._core is not None:
            # Nobody needs what it would say in the seconds of an end in order.
            end_tree(self._core, timeout=0.0)
            self._core = None
        self._folder.cleanup()

    def _wait_until_up(self, core: subprocess.Popen, output: str) -> None:
        master = rosgraph.Master("/private_master", master_uri=self.uri)
        end = time.monotonic() + START_TIMEOUT
        while time.monotonic() < end and core.poll() is None:
            # Whatever else may answer there: another server may have taken the port.
            with contextlib.suppress(Exception):
                # roscore starts rosout last.
                master.lookupNode("/rosout")
                if master.getPid() in (core.pid, *descendants(core.pid)):
                    return
            time.sleep(0.05)
        with open(output, errors="replace") as file:
            raise PrivateMasterError(f"no ROS master at {self.uri}:\n{file.read()[-2000:]}")
