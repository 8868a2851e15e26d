"""This process as a node of a ROS master of its own: for tests that talk to real nodes.

rospy can be initialised once in a process. Master and node therefore last as long as the session;
a module that uses the fixture `master` finds no parameter of another one, and closes its `Topics`.
"""

from __future__ import annotations

import os
import signal
import subprocess
from typing import Any, Callable, Dict, Iterator, List, Sequence

import pytest
from waiting import wait_until

from telex_experiments.rigs.private_master import DIES_WITH_US, PrivateMaster

LONGEST_END = 10.0
"""Time (s) that a node has for its end."""


@pytest.fixture(scope="session")
def joined_master() -> Iterator[PrivateMaster]:
    """A roscore on a free port, of which this process is a node."""
    import rospy

    from telex_control.ros.rospy_fixes.connecting import miss_nothing

    with PrivateMaster() as master, pytest.MonkeyPatch.context() as patch:
        set_environment(patch, master.environment())
        miss_nothing()
        rospy.init_node("tests", disable_signals=True)
        patch.undo()
        yield master
        set_environment(patch, master.environment())
        rospy.signal_shutdown("the tests are over")


@pytest.fixture(scope="module")
def master(joined_master: PrivateMaster) -> Iterator[Dict[str, str]]:
    """Environment of that roscore, which is this process's for the time of a module."""
    import rosgraph

    environment = joined_master.environment()
    server = rosgraph.Master("/tests", joined_master.uri)
    with pytest.MonkeyPatch.context() as patch:
        set_environment(patch, environment)
        before = set(server.getParamNames())
        yield environment
        for name in set(server.getParamNames()) - before:
            server.deleteParam(name)


def set_environment(patch: pytest.MonkeyPatch, environment: Dict[str, str]) -> None:
    """Let rospy of this process find a master."""
    patch.delenv("ROS_NAMESPACE", raising=False)
    for name, value in environment.items():
        if os.environ.get(name) != value:
            patch.setenv(name, value)


class Topics:
    """Publishers, subscribers and services in a namespace, which end with it (context manager).

    Parameters
    ----------
    namespace
        Of relative names, "/telex" for instance.
    """

    def __init__(self, namespace: str) -> None:
        self.namespace = namespace
        self._ends: List[Callable[[], object]] = []

    def __enter__(self) -> Topics:
        return self

    def __exit__(self, *exception: object) -> None:
        while self._ends:
            self._ends.pop()()

    def name(self, name: str) -> str:
        """Return the whole name of a relative one."""
        return name if name.startswith("/") else f"{self.namespace}/{name}"

    def publisher(self, name: str, kind: type, **options: Any) -> Any:
        """Return a new publisher (queue size 10, if nothing else is said)."""
        import rospy

        made = rospy.Publisher(self.name(name), kind, **{"queue_size": 10, **options})
        self._ends.append(made.unregister)
        return made

    def subscriber(self, name: str, kind: type, callback: Callable, **options: Any) -> Any:
        """Return a new subscriber."""
        import rospy

        made = rospy.Subscriber(self.name(name), kind, callback, tcp_nodelay=True, **options)
        self._ends.append(made.unregister)
        return made

    def heard(self, name: str, kind: type) -> List[Any]:
        """Return a list to which each message of a topic is appended."""
        messages: List[Any] = []
        self.subscriber(name, kind, messages.append)
        return messages

    def service(self, name: str, kind: type, handler: Callable) -> None:
        """Offer a service."""
        import rospy

        made = rospy.Service(self.name(name), kind, handler)
        self._ends.append(made.shutdown)

    def calls(self, name: str, kind: type) -> Any:
        """Return a function that calls a service."""
        import rospy

        return rospy.ServiceProxy(self.name(name), kind)


def wait_until_connected(*ends: Any, timeout: float = 30.0) -> None:
    """Wait until somebody is at the other end of each of some publishers and subscribers."""

    import rospy

    from telex_control.ros.rospy_fixes.connections import has_answer

    def is_alone(end: Any) -> bool:
        # rospy counts a subscriber's connection while it is still being made.
        subscribes = isinstance(end, rospy.Subscriber)
        return not (has_answer(end) if subscribes else end.get_num_connections())

    def alone() -> List[str]:
        return [each.resolved_name for each in ends if is_alone(each)]

    wait_until(
        lambda: not alone(), lambda: f"somebody at the other end of {', '.join(alone())}", timeout
    )


class NodeProcess:
    """A node in a process of its own, which ends with it (context manager).

    Parameters
    ----------
    command
        Program and arguments.
    environment
        As the fixture `master` has it.
    **options
        Of `subprocess.Popen`. Without ``stdout``, what the node says is shown with a failed test.
    """

    def __init__(self, command: Sequence[str], environment: Dict[str, str], **options: Any) -> None:
        self._command = [*DIES_WITH_US, *map(str, command)]
        self._options = {"env": environment, **options}
        self.start()

    def __enter__(self) -> NodeProcess:
        return self

    def __exit__(self, *exception: object) -> None:
        if self.process.poll() is None:
            self.end()

    def start(self) -> None:
        """Start it, or start it again."""
        self.process = subprocess.Popen(self._command, **self._options)

    def kill(self) -> None:
        """End it without a warning."""
        self.process.kill()
        self.process.wait()

    def end(self, number: int = signal.SIGTERM) -> int:
        """Ask it to end, kill it where it does not, and return its exit status."""
        self.process.send_signal(number)
        try:
            return self.process.wait(LONGEST_END)
        except subprocess.TimeoutExpired:
            self.kill()
            raise
