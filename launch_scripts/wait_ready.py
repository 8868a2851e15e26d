#!/usr/bin/env python3
"""Waits until the robot can be driven and the first picture has come, then says how to begin."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import socket
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from http.client import HTTPException
from typing import Any, Callable, Dict, List, Optional, Set, Tuple
from xmlrpc.client import Error as XmlRpcError

import rosgraph
import rospy
from controller_manager_msgs.srv import ListControllers

from telex_control.common.params import ConfigError
from telex_control.ros.node_start import init_node
from telex_teleop.web.token_files import read_token

_NODE_START = 20.0
"""Time (s) in which a node that is waited for must have registered."""

_ONE_CAMERA = 5.0
"""Time (s) for which the picture of one camera is waited for before others are asked for theirs."""

_COMPRESSED = "/compressed"

_TELEOP = ("arm_teleop", "flipper_teleop", "gripper_teleop", "track_teleop")
"""Nodes that a key goes through before the robot moves."""

_NO_HEAD = 405
"""Status of the bridge's answer to a HEAD request, which it does not take for a client's."""

_ADVICE = "its last message says why"
_SERVER_ADVICE = f"{_ADVICE}; if its port is in use, try {{}}"

_ENV_MASTER = "http://localhost:11311"
"""ROS master of a shell that has read env.sh and says nothing else."""

_HERE = urllib.request.build_opener(urllib.request.ProxyHandler({}))
"""Asks servers of this machine, past the proxy that the environment may name for all others."""

READY = """
{pages}
{keys}
  ROS       {shell} && rostopic list        (everything is under {namespace})
  Stop      Ctrl-C
"""

KEYS = """\
  Keys      W S A D  drive       R F  front flippers    T G  rear flippers
            J L  turret    I K  shoulder    U O  telescope    P ;  elbow
            , .  gripper   - =  speed       Esc  emergency stop
            The page shows all. Hold to move, release to stop.
  Terminal  {shell} && rosrun telex_teleop keyboard_teleop{robot}"""

OWN_KEYS = """\
  Keys      The page shows all. Hold to move, release to stop; Esc: emergency stop."""


def alive(pid: int) -> bool:
    """Whether process `pid` still runs."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def node_answers(name: str) -> bool:
    """Whether a node is registered and listens; one that died may still be registered."""
    try:
        address = urllib.parse.urlparse(rosgraph.Master("/wait_ready").lookupNode(name))
        socket.create_connection((address.hostname, address.port), timeout=5.0).close()
    except (rosgraph.MasterException, OSError):
        return False
    return True


REPLAY = """
  Replay    {url}/replay/
            Space plays and pauses, the arrow keys go from frame to frame.
  ROS       {shell} && rosservice list        (replay/open, replay/seek under {namespace})
  Stop      Ctrl-C
"""


class Waiter:
    """Waits for one condition after the other, with a common deadline."""

    def __init__(self, launch_pid: int, timeout: float) -> None:
        self._launch_pid = launch_pid
        self._started = time.monotonic()
        self._deadline = self._started + timeout
        self._needed: List[str] = []
        self._advice = ""
        self._needed_by = math.inf
        self._seen: Set[str] = set()

    def need(self, nodes: List[str], advice: str = _ADVICE, within: float = _NODE_START) -> None:
        """Give up when one of these has been there and is gone, or has not come within a time."""
        self._needed, self._advice, self._seen = nodes, advice, set()
        self._needed_by = time.monotonic() + within

    def _check_needed(self) -> None:
        late = time.monotonic() > self._needed_by
        for node in self._needed:
            if node_answers(node):
                self._seen.add(node)
            elif late or node in self._seen:
                sys.exit(f"the node {node} has ended: {self._advice}")

    def wait(self, what: str, condition: Callable[[], Optional[object]]) -> object:
        """Return the first true value of `condition`; ends the program when none comes."""
        while True:
            value = condition()
            if value:
                print(f"  {what}: {time.monotonic() - self._started:.1f} s", flush=True)
                return value
            if self._launch_pid and not alive(self._launch_pid):
                sys.exit(f"waiting for '{what}': roslaunch has ended")
            self._check_needed()
            if time.monotonic() > self._deadline:
                sys.exit(f"'{what}' did not come in time; see the messages of the nodes above")
            time.sleep(0.1)


def controllers_run(namespace: str, own: bool) -> bool:
    """Whether controllers are loaded and all run but those that take over only when asked to.

    Those of a robot of one's own (`own`) are started together, and which do is in its files.
    """
    try:
        stopped = rospy.get_param(f"{namespace}/controller_groups/actions", [])
        service = rospy.ServiceProxy(
            f"{namespace}/controller_manager/list_controllers", ListControllers
        )
        states = [each.state for each in service().controller if each.name not in stopped]
    except (rospy.ROSException, rospy.ServiceException, OSError):
        return False
    return bool(states) and (any if own else all)(state == "running" for state in states)


def fetch(namespace: str, path: str) -> Tuple[str, bytes]:
    """Address of the video server, and what it answers to `path`; empty if it does not.

    Only what needs no token can be had. The address is read anew each time: on a master that was
    running before, it may still be that of an earlier video server.
    """
    try:
        url = str(rospy.get_param(f"{namespace}/video_server/url", ""))
        if url:
            with _HERE.open(f"{url}{path}", timeout=5.0) as answer:
                return url, answer.read()
    except (OSError, HTTPException):
        pass
    return "", b""


def console(namespace: str) -> Optional[str]:
    """Address of the console, if its page is there."""
    url, page = fetch(namespace, "/")
    return url if page.lower().startswith(b"<!doctype html>") else None


class FirstPicture:
    """The first picture of a camera, as every program of this ROS master gets it."""

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._asked = time.monotonic()
        self._came = False

    def came(self) -> bool:
        """Whether there was one; asks for it first, of one camera and in the end of all."""
        patient = time.monotonic() - self._asked < _ONE_CAMERA
        if not (patient and self._subscribers):
            for topic in self._cameras()[:1] if patient else self._published(self._cameras()):
                if topic not in self._subscribers:
                    self._subscribers[topic] = rospy.Subscriber(
                        topic, rospy.AnyMsg, self._note, queue_size=1
                    )
        return self._came

    def _note(self, _message: rospy.AnyMsg) -> None:
        self._came = True

    def _cameras(self) -> List[str]:
        """Compressed topics of the main camera, of the robot's others, of the instructor's."""
        _, answer = fetch(self._namespace, "/config.json?role=instructor")
        if not answer:
            return []
        config: Dict[str, Any] = json.loads(answer)
        cameras: List[Dict[str, str]] = config["cameras"]
        hidden = config["hidden_cameras"]
        cameras.sort(
            key=lambda each: (each["name"] != config["main_camera"], each["name"] in hidden)
        )
        return [f"{each['topic']}{_COMPRESSED}" for each in cameras]

    def _published(self, topics: List[str]) -> List[str]:
        """The raw topic of each that is not published."""
        published = {name for name, _ in rospy.get_published_topics()}
        return [topic if topic in published else topic[: -len(_COMPRESSED)] for topic in topics]


def replays(namespace: str) -> Optional[str]:
    """Address of the video server, if it shows a replay."""
    mounted = rospy.get_param(f"{namespace}/video_server/mounts/replay", None)
    return console(namespace) if mounted is not None else None


def bridge_answers(namespace: str) -> Optional[str]:
    """Address of the bridge, if one answers there; it is read anew each time, as in `fetch`."""
    try:
        url = rospy.get_param(f"{namespace}/rosbridge/url", None)
        if url is None:
            return None
        question = urllib.request.Request(str(url).replace("ws", "http", 1), method="HEAD")
        _HERE.open(question, timeout=5.0).close()
    except urllib.error.HTTPError as answer:
        return str(url) if answer.code == _NO_HEAD else None
    except (OSError, HTTPException):
        return None
    return None


def pages(namespace: str, url: str, several: bool) -> str:
    """What to say of a robot's addresses; their tokens are shown on a terminal only."""
    lines = [f"  {namespace}"] if several else []
    chosen = f"?robot={namespace[1:]}" if several else ""
    for title, page, name in (
        ("Console", "/", "token_file"),
        ("Instructor", "/instructor", "instructor_token_file"),
    ):
        path = str(rospy.get_param(f"{namespace}/rosbridge/{name}", ""))
        if not path:
            wanted = page if chosen else ""
            lines += [f"  {title:<9} {url}{wanted}{chosen}"] if page == "/" or chosen else []
            continue
        token = f"…  with the token in {path}"
        if sys.stdout.isatty():
            with contextlib.suppress(ConfigError, OSError):  # it is gone again; the bridge says why
                token = read_token(path, name)
        query = f"{chosen}&" if chosen else "?"
        lines.append(f"  {title:<9} {url}{page}{query}token={token}")
    return "\n".join(lines)


def shell() -> str:
    """What makes a new shell one for this ROS master."""
    master = os.environ.get("ROS_MASTER_URI", _ENV_MASTER)
    return f"{'' if master == _ENV_MASTER else f'export ROS_MASTER_URI={master} && '}source env.sh"


def _wait_for_robot(
    waiter: Waiter, robot: str, which: str = "", own: Optional[List[str]] = None
) -> None:
    waiter.wait(f"robot{which} controllable", lambda: controllers_run(robot, own is not None))
    nodes = [f"{robot}/{name}" for name in (_TELEOP if own is None else own)]
    # On a slow machine they come one after the other.
    waiter.need(nodes, within=math.inf)
    waiter.wait(f"teleoperation{which}", lambda: all(map(node_answers, nodes)))


def _wait_for_bridge(waiter: Waiter, robot: str, which: str = "") -> None:
    waiter.need([f"{robot}/rosbridge"], _SERVER_ADVICE.format("bridge_port:=9091"))
    waiter.wait(f"bridge{which}", lambda: bridge_answers(robot))


def main() -> None:
    """Wait, then print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--namespace", default="telex")
    parser.add_argument("--beside", action="append", default=[], help="name of a further robot")
    parser.add_argument(
        "--own-robot",
        type=str.split,
        metavar="NODES",
        help="it is no Telex, and these are its teleoperation nodes",
    )
    parser.add_argument("--launch-pid", type=int, default=0)
    parser.add_argument("--no-console", action="store_true", help="the console was not asked for")
    parser.add_argument("--no-picture", action="store_true", help="the cameras were not asked for")
    parser.add_argument("--replay", action="store_true", help="a recording is shown, no simulator")
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds")
    options = parser.parse_args()
    namespace = "/" + options.namespace.strip("/")
    waiter = Waiter(options.launch_pid, options.timeout)

    def master() -> bool:
        try:
            return rosgraph.is_master_online()
        except (OSError, XmlRpcError):
            return False

    waiter.wait("ROS master", master)
    if options.replay:
        waiter.need([f"{namespace}/replay"])
        shown = str(waiter.wait("replay", lambda: replays(namespace)))
        print(REPLAY.format(url=shown, namespace=namespace, shell=shell()), flush=True)
        return
    beside = [f"/{name}" for name in options.beside]
    _wait_for_robot(waiter, namespace, own=options.own_robot)
    for robot in beside:
        _wait_for_robot(waiter, robot, f" {robot}")
    shown = "  Console   (not started)"
    if not options.no_console:
        waiter.need([f"{namespace}/video_server"], _SERVER_ADVICE.format("video_port:=8081"))
        url = str(waiter.wait("console", lambda: console(namespace)))
        _wait_for_bridge(waiter, namespace)
        for robot in beside:
            _wait_for_bridge(waiter, robot, f" {robot}")
        if not options.no_picture:
            waiter.need([f"{namespace}/cameras"])
            init_node("wait_ready", anonymous=True, own_signals=True)
            waiter.wait("first camera picture", FirstPicture(namespace).came)
        shown = "\n".join(pages(robot, url, bool(beside)) for robot in (namespace, *beside))
    robot = "" if namespace == "/telex" else f" _robot:={namespace}"
    keys = KEYS.format(shell=shell(), robot=robot) if options.own_robot is None else OWN_KEYS
    print(
        READY.format(pages=shown, keys=keys, namespace=namespace, shell=shell()),
        flush=True,
    )


if __name__ == "__main__":
    try:
        main()
    except (ConfigError, OSError) as error:
        sys.exit(f"wait_ready.py: {error}")
    finally:
        rospy.signal_shutdown("done")
