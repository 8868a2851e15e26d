"""Loads and starts controllers, and stops and unloads them again when it ends.

The command line is that of ros_control's ``spawner``; ``--optional``, ``--optional-stopped``,
``--start`` and ``--watch`` are beyond it.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import threading
import time
from typing import Any, Callable, Collection, Dict, List, Optional, Set, Tuple
from xmlrpc.client import MAXINT, MININT

import rosparam  # noqa: F401
import rospy
from controller_manager_msgs.msg import ControllerState
from std_msgs.msg import Bool

from ..common.yaml_files import load_yaml
from ..manager.client import ControllerManagerClient
from ..manager.controller_joints import controller_joints, without_joints
from ..urdf.joints import UrdfError, parse_urdf
from ..urdf.transmission_parser import driven_joints
from . import program
from .last_calls import call_at_the_end, manager_address

_WATCH_PERIOD = 0.5
"""Wall time (s) between two checks whether the manager has been replaced."""

_LIST_PERIOD = 2.0
"""Wall time (s) from an answer of the manager to the next question what it has."""

_EMPTY_LISTS = 2
"""Lists without any of ours, one after the other, by which the manager has lost them. A single one
may fall between unloading and loading by ``reload-libraries --restore``, or into the removal of the
robot."""


class SpawnerError(Exception):
    """The command line cannot be carried out; the message says why."""


def parse(arguments: List[str]) -> argparse.Namespace:
    """Read the command line.

    Returns
    -------
    argparse.Namespace
        `timeout` is None when the manager is waited for without end.
    """
    parser = argparse.ArgumentParser(prog="spawner", description=__doc__)
    parser.add_argument(
        "controllers",
        nargs="+",
        metavar="NAME|FILE.yaml",
        help="controllers in load order, or files whose parameters are loaded first",
    )
    parser.add_argument(
        "--optional",
        nargs="*",
        default=[],
        metavar="NAME",
        help="further controllers, left out where the robot lacks all their joints",
    )
    parser.add_argument(
        "--optional-stopped",
        nargs="*",
        default=[],
        metavar="NAME",
        help="as --optional, but these are loaded only, not started",
    )
    parser.add_argument(
        "--start",
        nargs="*",
        metavar="NAME",
        help="of what is loaded, start these alone; without names, in load order those that take "
        "no joint of one before. Otherwise all are started in one switch, or none where two of "
        "them take the same joint",
    )
    parser.add_argument(
        "--watch",
        action="store_true",
        help="load and start them again whenever the manager has been started again, or has none "
        "of them any more, and take over what is loaded already",
    )
    parser.add_argument("--stopped", action="store_true", help="load only, do not start")
    parser.add_argument(
        "--wait-for", metavar="TOPIC", help="load nothing before a std_msgs/Bool on it is true"
    )
    parser.add_argument("--namespace", metavar="NS", help="namespace of the controller manager")
    parser.add_argument(
        "--timeout",
        metavar="T",
        type=float,
        default=30.0,
        help="seconds to wait for the manager (30); 0 waits without end",
    )
    parser.add_argument(
        "--no-timeout", action="store_true", help="wait for the manager without end"
    )
    parser.add_argument("--shutdown-timeout", metavar="T", help="deprecated; it has no effect")
    options = parser.parse_args(arguments)
    if options.no_timeout or options.timeout <= 0.0:
        options.timeout = None
    return options


def read_file(path: str, namespace: str = "") -> Dict[str, Any]:
    """Read a YAML file of parameters: names to values.

    Parameters
    ----------
    namespace : str
        Of the robot. Where the controllers stand in a namespace of the file, what is in there is
        taken for what is meant for this one; of several, that of the same name.

    Raises
    ------
    SpawnerError
        It cannot be read, or holds no controller, that is, no struct with a ``type``, or holds some
        in several namespaces, or a value that the parameter server does not take.
    """
    try:
        with open(path) as file:
            # rosparam has taught it angles (!degrees 90, deg(90)), which roslaunch reads, too.
            params = load_yaml(file)
    except Exception as error:  # angles are evaluated as Python: the file can raise anything
        raise SpawnerError(f"{path}: {error}") from error
    if not isinstance(params, dict) or not _holds_controllers(params):
        raise SpawnerError(f"{path}: a mapping of controller names to parameters is needed")
    while not controllers_of(params):
        inner = [name for name, value in params.items() if _holds_controllers(value)]
        own = [name for name in inner if str(name).strip("/") in namespace.strip("/").split("/")]
        if len(inner) > 1 and len(own) != 1:
            raise SpawnerError(
                f"{path}: there are controllers in the namespaces "
                f"{', '.join(str(name) for name in inner)}; one is needed, or one named as the "
                f"robot's, {namespace or '/'}"
            )
        params.update(params.pop((own or inner)[0]))
    named = {str(name): value for name, value in params.items()}
    try:
        _require_settable(named, "")
    except SpawnerError as error:
        raise SpawnerError(f"{path}: {error}") from None
    return named


def _require_settable(value: Any, name: str) -> None:
    """Raise a `SpawnerError` unless the parameter server, which speaks XML-RPC, takes a value."""
    if isinstance(value, dict):
        for key, each in value.items():
            if not isinstance(key, str) or not key:
                raise SpawnerError(f"a key of {name or 'the file'} is {key!r}; text is needed")
            _require_settable(each, f"{name}/{key}" if name else key)
    elif isinstance(value, (list, tuple)):
        for index, each in enumerate(value):
            _require_settable(each, f"{name}[{index}]")
    elif isinstance(value, int):
        if not MININT <= value <= MAXINT:
            raise SpawnerError(f"{name} is {value}; a whole number of 32 bits is needed")
    elif not isinstance(value, (str, float, bytes)):
        raise SpawnerError(f"{name} is {value!r}; text, a number, a list or a struct is needed")


def _holds_controllers(params: Any) -> bool:
    if not isinstance(params, dict):
        return False
    return bool(controllers_of(params)) or any(map(_holds_controllers, params.values()))


def controllers_of(params: Dict[str, Any]) -> List[str]:
    """Names of those parameters that describe a controller."""
    return [
        str(name) for name, value in params.items() if isinstance(value, dict) and "type" in value
    ]


def without_conflict(
    names: Collection[str], listed: Collection[ControllerState]
) -> Tuple[List[str], Dict[str, str]]:
    """Choose from controllers those that can run together with each other and with what runs.

    Parameters
    ----------
    names : collection of str
        In the order in which they are preferred.
    listed : collection of ControllerState
        All that are loaded.

    Returns
    -------
    chosen : list of str
    left : dict
        The others, and why each cannot run with those.
    """
    claims = {
        each.name: [joint for claim in each.claimed_resources for joint in claim.resources]
        for each in listed
    }
    taken = {
        joint: each.name
        for each in listed
        if each.state == "running"
        for joint in claims[each.name]
    }
    chosen, left = [], {}
    for name in names:
        joints = claims.get(name, [])
        busy = [joint for joint in joints if taken.get(joint, name) != name]
        if busy:
            left[name] = f"{', '.join(busy)} is taken by {taken[busy[0]]}"
        elif len(set(joints)) < len(joints):
            left[name] = "it takes a joint through two interfaces"
        else:
            chosen.append(name)
            taken.update((joint, name) for joint in joints)
    return chosen, left


class _Inventory:
    """Asks a manager now and then what it has, while others go on: it may never answer."""

    def __init__(self, client: ControllerManagerClient) -> None:
        self._client = client
        self._asking: Optional[threading.Thread] = None
        self._ask_at = time.monotonic() + _LIST_PERIOD
        self._answer: Optional[Set[str]] = None

    def news(self) -> Optional[Set[str]]:
        """Names of all that is loaded, once for each answer; None: there is no new one."""
        if self._asking is None:
            if time.monotonic() >= self._ask_at:
                self._asking = threading.Thread(target=self._ask, daemon=True)
                self._asking.start()
            return None
        if self._asking.is_alive():
            return None
        self._asking, self._ask_at = None, time.monotonic() + _LIST_PERIOD
        answer, self._answer = self._answer, None
        return answer

    def _ask(self) -> None:
        with contextlib.suppress(rospy.ServiceException, rospy.ROSException):
            self._answer = {each.name for each in self._client.list_controllers()}


class Spawner:
    """Brings a group of controllers up and down.

    Parameters
    ----------
    namespace : str
        Of the robot; relative to this node's when it does not begin with a slash.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace.rstrip("/")
        self._client = ControllerManagerClient(namespace)
        self._loaded: List[str] = []
        # What is being loaded when the spawner is told to end has to be unloaded, too.
        self._asking = threading.Lock()
        self._ending = False

    def names_of(self, argument: str) -> List[str]:
        """Controllers that an argument stands for; a file's parameters are loaded.

        Raises
        ------
        SpawnerError
            The file cannot be read, or holds no controllers.
        """
        if not (argument.endswith((".yaml", ".yml")) or os.path.isfile(argument)):
            return [argument]
        params = read_file(argument, rospy.resolve_name(self._param("x")).rpartition("/")[0])
        for name, value in params.items():
            rospy.set_param(self._param(name), value)
        return controllers_of(params)

    def wait_for_manager(self, timeout: Optional[float]) -> bool:
        """Wait for the services; False, with a warning, when they do not come in `timeout` s."""
        prefix = self._client.prefix
        end = None if timeout is None else time.monotonic() + timeout
        for name in ("load_controller", "switch_controller", "unload_controller"):
            service = f"{prefix}/{name}"
            rospy.loginfo("Controller Spawner: Waiting for service %s", service)
            while True:
                left = None if end is None else max(end - time.monotonic(), 0.01)
                try:
                    rospy.wait_for_service(service, timeout=left)
                    break
                except rospy.ROSInterruptException:
                    raise
                except rospy.ROSException:
                    # A simulator that has not published its clock is still coming up.
                    if not (rospy.get_param("/use_sim_time", False) and rospy.Time.now().is_zero()):
                        rospy.logwarn(
                            "Controller Spawner couldn't find the expected controller_manager ROS "
                            "interface (%s) within %s s; is the simulator running, and is this "
                            "its namespace?",
                            rospy.resolve_name(service),
                            timeout,
                        )
                        return False
                    rospy.loginfo("Waiting for /clock to be available...")
                    end = time.monotonic() + (timeout or 0.0)
        return True

    def present(self, names: List[str], optional: List[str]) -> List[str]:
        """Return `names` and those of the `optional` controllers whose joints the robot has.

        One for many joints does without those that belong to a controller that is left out.

        Raises
        ------
        SpawnerError
            An optional controller has no joints, or the robot has a joint that no controller takes
            while one is left out for a joint that is not there: its name is wrong, then.
        """
        if not optional:
            return names
        driven = self._driven_joints()
        kept, absent = list(names), {}
        for name in optional:
            joints = self._joints_of(name)
            if not joints:
                raise SpawnerError(f"--optional {name}: its parameters name no joint")
            if any(joint in driven for joint in joints):
                kept.append(name)
            else:
                absent[name] = joints
        taken = {joint for name in kept for joint in self._joints_of(name)}
        without = [joint for joint in driven if joint not in taken]
        for name, joints in absent.items():
            if without:
                raise SpawnerError(
                    f"controller {name} is for {', '.join(joints)}, which the robot lacks, and no "
                    f"controller is for its {', '.join(without)}; one of the names is wrong, or a "
                    "controller is missing"
                )
            rospy.loginfo("Left out: %s, for this robot has no %s", name, ", ".join(joints))
        gone = {joint for joints in absent.values() for joint in joints}
        for name in kept[len(names) :]:
            self._fit(name, gone)
        return kept

    def _fit(self, name: str, gone: Collection[str]) -> None:
        """Take joints that are gone from a controller for a list of joints."""
        params = rospy.get_param(self._param(name), {})
        lacking = [joint for joint in controller_joints(params) if joint in gone]
        if lacking:
            rospy.set_param(self._param(name), without_joints(params, gone))
            rospy.loginfo("%s does without %s", name, ", ".join(lacking))

    def _driven_joints(self) -> List[str]:
        description = rospy.get_param(self._param("robot_description"), None)
        if description is None:
            raise SpawnerError(
                f"--optional needs the parameter {self._param('robot_description')}, which is not "
                "set"
            )
        try:
            return [each.joint for each in driven_joints(parse_urdf(str(description)))]
        except UrdfError as error:
            raise SpawnerError(str(error)) from error

    def _joints_of(self, controller: str) -> List[str]:
        return controller_joints(rospy.get_param(self._param(controller), {}))

    def _param(self, name: str) -> str:
        return f"{self._namespace}/{name}" if self._namespace else name

    def manager_address(self) -> Optional[str]:
        """Where the manager's services are, which differs for every process; None if nowhere."""
        return manager_address(self._client.prefix)

    def wait_for_another_manager(self, address: Optional[str]) -> bool:
        """Wait until the manager is another one; False when this node is shut down.

        That is one at another address, or one that has nothing of ours any more: a robot that was
        taken out and added again has a new one in the same process.

        Parameters
        ----------
        address : str, optional
            Of the former one; without it, any manager is another one.
        """
        inventory, empty = _Inventory(self._client), 0
        while not rospy.is_shutdown():
            # Sim time may stand still.
            time.sleep(_WATCH_PERIOD)
            now = self.manager_address()
            if now not in (None, address):
                rospy.logwarn("Controller Spawner: the controller manager has been started again")
                return True
            # Without an address there is nobody to ask; without an answer nobody knows.
            names = inventory.news() if now is not None and self._loaded else None
            if names is not None:
                empty = empty + 1 if names.isdisjoint(self._loaded) else 0
            if empty == _EMPTY_LISTS:
                rospy.logwarn(
                    "Controller Spawner: the controller manager has none of %s any more",
                    ", ".join(self._loaded),
                )
                return True
        return False

    def clear(self) -> None:
        """Unload what another manager has of ours: it may have come while we were loading."""
        listed = {each.name: each.state for each in self._client.list_controllers()}
        names = [name for name in self._loaded[::-1] if name in listed]
        running = [name for name in names if listed[name] == "running"]
        if running:
            self._client.switch([], running)
        for name in names:
            self._client.unload(name)
        self._loaded = []

    def adopt(self, names: Collection[str]) -> List[str]:
        """Take over what a spawner has left that was killed.

        Returns
        -------
        list of str
            Those that have been started before; who stopped some of them meant to.
        """
        states = {each.name: each.state for each in self._client.list_controllers()}
        self._loaded = [name for name in names if name in states]
        if self._loaded:
            rospy.loginfo("Controller Spawner: Loaded already: %s", ", ".join(self._loaded))
        return [name for name in self._loaded if states[name] != "initialized"]

    def load(self, names: List[str]) -> List[str]:
        """Load controllers; those that cannot be loaded are reported and left out."""
        for name in names:
            if name in self._loaded:
                continue
            rospy.loginfo("Loading controller: %s", name)
            with self._asking:
                if self._ending:
                    break
                loaded = self._client.load(name)
                if loaded:
                    self._loaded.append(name)
            if not loaded:
                rospy.logerr("Failed to load %s; the controller manager's log says why", name)
        rospy.loginfo("Controller Spawner: Loaded controllers: %s", ", ".join(self._loaded))
        return self._loaded

    def start(self, but: Collection[str] = (), only: Optional[Collection[str]] = None) -> None:
        """Start what was loaded, in one switch.

        Parameters
        ----------
        but : collection of str
            These stay stopped.
        only : collection of str, optional
            Start no others than these; where it is empty, those that do not conflict.
        """
        started = [name for name in self._loaded if name not in but]
        if only:
            started = [name for name in started if name in only]
        elif only is not None:
            started, left = without_conflict(started, self._client.list_controllers())
            for name, reason in left.items():
                rospy.logwarn(
                    "Loaded and left stopped: %s, for %s; --start, start:= of robot.launch, "
                    "says which to start",
                    name,
                    reason,
                )
        if not started:
            return
        names = ", ".join(started)
        with self._asking:
            if self._ending:
                return
            running = self._client.switch(started, [])
        if running:
            rospy.loginfo("Started controllers: %s", names)
        else:
            rospy.logerr("Failed to start controllers: %s", names)

    def stop(self) -> None:
        """Stop and unload what was loaded, in reverse order."""
        self._ending = True
        call_at_the_end(self._client.prefix, self._stop)

    def _stop(self, answered: Callable[[], None]) -> None:
        with self._asking:
            names = self._loaded[::-1]
        if not names:
            return
        # Others may have stopped some: a STRICT switch would then stop none.
        listed = self._client.list_controllers()
        running = {each.name for each in listed if each.state == "running"}
        answered()
        to_stop = [name for name in names if name in running]
        if to_stop:
            self._client.switch([], to_stop)
        for name in names:
            answered()
            self._client.unload(name)


def wait_until_true(topic: str, timeout: Optional[float]) -> None:
    """Wait for a true std_msgs/Bool; after `timeout` s without any message, warn."""
    heard, allowed = threading.Event(), threading.Event()

    def receive(message: Bool) -> None:
        heard.set()
        if message.data:
            allowed.set()

    subscriber = rospy.Subscriber(topic, Bool, receive)
    warn_at = time.monotonic() + (timeout if timeout is not None else 30.0)
    warned = False
    while not allowed.wait(0.05):
        if rospy.is_shutdown():
            raise rospy.ROSInterruptException("shut down while waiting for a topic")
        if not (warned or heard.is_set()) and time.monotonic() > warn_at:
            warned = True
            rospy.logwarn(
                'Controller Spawner hasn\'t heard anything from its "wait for" topic (%s)',
                subscriber.resolved_name,
            )
    subscriber.unregister()


def main() -> None:
    """Run the spawner until it is shut down."""
    options = parse(program.arguments())

    def work() -> int:
        if options.shutdown_timeout is not None:
            rospy.logwarn("DEPRECATION warning: --shutdown-timeout has no effect.")
        spawner = Spawner(options.namespace or "")
        try:
            names = [name for each in options.controllers for name in spawner.names_of(each)]
        except SpawnerError as error:
            rospy.logerr("%s", error)
            return 1
        if not spawner.wait_for_manager(options.timeout):
            return 0
        if options.wait_for:
            wait_until_true(options.wait_for, options.timeout)
        rospy.on_shutdown(spawner.stop)
        try:
            names = spawner.present(names, options.optional + options.optional_stopped)
        except SpawnerError as error:
            rospy.logerr("%s", error)
            return 1
        unknown = [name for name in options.start or () if name not in names]
        if unknown:
            rospy.logerr(
                "--start names %s; controllers are %s", ", ".join(unknown), ", ".join(names)
            )
            return 1
        address = spawner.manager_address()
        settled = spawner.adopt(names) if options.watch else []
        if not spawner.load(names):
            return 1
        if not options.stopped:
            spawner.start([*options.optional_stopped, *settled], options.start)
        if not options.watch:
            rospy.spin()
            return 0
        while spawner.wait_for_another_manager(address):
            address = spawner.manager_address()
            try:
                spawner.wait_for_manager(None)
                spawner.clear()
                spawner.load(names)
                if not options.stopped:
                    spawner.start(options.optional_stopped, options.start)
            except rospy.ServiceException as error:
                rospy.logwarn("Controller Spawner: the manager has gone once more: %s", error)
                # Whoever comes has nothing of ours, also at the same address.
                address = None
        return 0

    program.run("spawner", work)
