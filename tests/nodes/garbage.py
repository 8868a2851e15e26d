#!/usr/bin/env python3
"""Garbage on every topic and service of a robot, and what came of it.

Run as a program in the robot's namespace, `garbage.py SECONDS` prints it as JSON; with more words,
as ROS gives them to a node, it is a test.
"""

from __future__ import annotations

import contextlib
import json
import math
import random
import re
import sys
import time
import unittest
from concurrent import futures
from typing import Any, Dict, List, Tuple
from xmlrpc.client import ServerProxy

import genpy
import rosgraph
import roslib.message
import rospy
import rosservice
import rostest
from robot import Robot
from waiting import wait_until

from telex_control.urdf.joints import joints, parse_urdf

SPARED_TOPICS = re.compile(r"/clock$|/tf(_static)?$|/rosout(_agg)?$|/e_stop$|/sim/|/joint_states$")
"""What only the simulator says, and the emergency stop, under which nothing could move."""
SPARED_SERVICES = re.compile(
    r"/sim/(pause|unpause|reset|step)$|delete_param$|set_param$|/(get|set)_loggers?(_level)?$"
    r"|/reload_controller_libraries$"
)
"""What has no arguments to be wrong, or does as it is told whatever that is: with ``force_kill``, a
reload of the controllers' libraries takes them all out."""
FLOATS32 = (math.nan, math.inf, -math.inf, 3e38, -3e38, 1e17, -1e17)
FLOATS64 = (*FLOATS32, 1e308, -1e308, 1e39, -1e39)
STRINGS = (
    "",
    "\x00",
    "a" * 5000,
    "../..",
    "☃",
    "{",
    "no_such",
    "[" * 2000,
    "{type: crate, mass: .nan}",
)
CALLS_A_SECOND, MESSAGES_A_SECOND = 20.0, 200.0
WARM_UP = 30.0
"""Time (s) of garbage after which memory is looked at first: logs and caches have filled, and the
C library's arenas, of which a process has up to eight a core, each for some of its threads. Each
keeps room for the largest request that it has seen: in the simulator some 15 MB, once. With two
arenas it grew by 0.5 MB over 950 calls after the first 200."""
LONGEST = 40.0
"""Time (s) after which too few calls and messages are enough."""
LOADING = 180.0
"""Longest wait (s) for the cameras to have the scene. They make its textures once, which takes them
some 100 MB in the training hall, and minutes on a busy machine: that is no growth by garbage."""


class Garbage:
    """Makes messages without sense.

    Parameters
    ----------
    seed : int
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def message(self, kind: type) -> Any:
        """A message with nonsense in all of its fields."""
        message = kind()
        for field, of in zip(message.__slots__, message._slot_types):
            setattr(message, field, self._value(of))
        return message

    def _value(self, kind: str) -> Any:
        choose = self._random.choice
        array = re.fullmatch(r"(.*)\[(\d*)\]", kind)
        if array:
            count = int(array[2]) if array[2] else choose((0, 1, 2, 7, 100))
            if array[1] in ("uint8", "char", "byte"):
                return bytes(self._random.getrandbits(8) for _ in range(count))
            return [self._value(array[1]) for _ in range(count)]
        if kind == "float32":
            return choose(FLOATS32)
        if kind == "float64":
            return choose(FLOATS64)
        if kind == "string":
            return choose(STRINGS)
        if kind == "bool":
            return choose((True, False))
        if kind in ("time", "duration"):
            seconds = choose((0, 1, 2**31 - 1))
            return genpy.Time(seconds, 0) if kind == "time" else genpy.Duration(seconds, 0)
        integer = re.fullmatch(r"(u?)int(\d+)|byte|char", kind)
        if integer:
            bits = int(integer[2] or 8)
            least, most = (0, 2**bits - 1) if integer[1] or kind == "char" else _signed(bits)
            return choose((least, most, 0, 1))
        return self.message(roslib.message.get_message_class(kind))


def _signed(bits: int) -> Tuple[int, int]:
    return -(2 ** (bits - 1)), 2 ** (bits - 1) - 1


def memory(master: rosgraph.Master) -> Dict[str, float]:
    """Resident memory (MB) of all nodes of this machine but this one."""
    used = {}
    names = {name for kind in master.getSystemState() for _, nodes in kind for name in nodes}
    for name in names - {rospy.get_name()}:
        with contextlib.suppress(OSError, rosgraph.MasterError):
            pid = ServerProxy(master.lookupNode(name)).getPid(rospy.get_name())[2]
            with open(f"/proc/{pid}/statm") as file:
                used[name] = int(file.read().split()[1]) * 4096 / 1e6
    return used


def wait_for_pictures(master: rosgraph.Master) -> None:
    """Wait until the cameras, if there are any, have the scene and offer pictures of it."""
    _, _, served = master.getSystemState()
    if rospy.resolve_name("cameras/configure") in {name for name, _ in served}:
        pictures = re.compile(re.escape(rospy.resolve_name("cameras")) + "/[^/]+/image_raw$")
        wait_until(
            lambda: any(pictures.match(topic) for topic, _ in master.getPublishedTopics("")),
            "pictures of the cameras, which load the scene",
            LOADING,
        )


def throw(seconds: float, seed: int = 1, least: int = 0) -> Dict[str, Any]:
    """Throw garbage at everything in this namespace.

    Parameters
    ----------
    seconds : float
        Wall time.
    seed : int
    least : int
        Messages, and calls, for which it goes on longer.

    Returns
    -------
    dict
        ``messages``, ``calls``; ``moved``: farthest that the base came (m); ``beyond``: how far a
        joint was beyond its limits (rad, m); ``factor``: least real-time factor in a second;
        ``growth``: of the memory of each node, after the first seconds (MB); ``lost``: nodes that
        are no longer there.
    """
    robot, garbage = Robot(), Garbage(seed)
    robot.wait_until_controllable()
    limits = joints(parse_urdf(rospy.get_param("robot_description")))
    wait_until(lambda: robot.status and robot.base and robot.state, "the robot's state", 10.0)
    master = rosgraph.Master(rospy.get_name())
    wait_for_pictures(master)
    time.sleep(2.0)
    _, subscribed, served = master.getSystemState()
    types = dict(master.getTopicTypes())
    publishers = []
    for topic, _ in subscribed:
        kind = roslib.message.get_message_class(types.get(topic, ""))
        if kind is not None and not SPARED_TOPICS.search(topic):
            publishers.append((rospy.Publisher(topic, kind, queue_size=5), kind))
    proxies: List[Tuple[rospy.ServiceProxy, type]] = []
    for name, _ in served:
        if not SPARED_SERVICES.search(name):
            with contextlib.suppress(rosservice.ROSServiceException, OSError):
                kind = rosservice.get_service_class_by_name(name)
                proxies.append((rospy.ServiceProxy(name, kind), kind))
    counts = {"messages": 0, "calls": 0}
    begun = time.monotonic()

    def goes_on() -> bool:
        passed = time.monotonic() - begun
        return passed < seconds or (min(counts.values()) < least and passed < LONGEST)

    at = robot.base.pose.position

    refusals = (rospy.ServiceException, rospy.ROSException, genpy.MessageException)

    def call() -> None:
        while proxies and goes_on():
            proxy, kind = garbage._random.choice(proxies)
            with contextlib.suppress(*refusals):
                proxy(garbage.message(kind._request_class))
            counts["calls"] += 1
            time.sleep(1.0 / CALLS_A_SECOND)

    calling = futures.ThreadPoolExecutor(1).submit(call)
    before: Dict[str, float] = {}
    moved, beyond, factors = 0.0, 0.0, []
    while goes_on():
        publisher, kind = garbage._random.choice(publishers)
        with contextlib.suppress(genpy.MessageException, rospy.ROSException):
            publisher.publish(garbage.message(kind))
        counts["messages"] += 1
        now = robot.base.pose.position
        moved = max(moved, math.dist((now.x, now.y, now.z), (at.x, at.y, at.z)))
        for name, position in zip(robot.state.name, robot.state.position):
            if name in limits:
                limit = limits[name]
                beyond = max(beyond, limit.lower - position, position - limit.upper)
        if not before and time.monotonic() > begun + min(WARM_UP, 0.5 * seconds):
            before = memory(master)
        if robot.status.real_time_factor:
            factors.append(robot.status.real_time_factor)
        time.sleep(1.0 / MESSAGES_A_SECOND)
    with contextlib.suppress(futures.TimeoutError):
        calling.result(20.0)  # raises what has ended the calls before their time
    after = memory(master)
    # Without its controllers nothing would have moved whatever was said.
    robot.wait_until_controllable()
    return {
        **counts,
        "topics": len(publishers),
        "services": len(proxies),
        "stuck": not calling.done(),
        "moved": moved,
        "beyond": beyond,
        "factor": min(factors, default=0.0),
        "growth": {name: after[name] - used for name, used in before.items() if name in after},
        "lost": sorted(set(before) - set(after)),
    }


class GarbageTest(unittest.TestCase):
    def test_nothing_moves_nothing_ends_and_nothing_grows(self):
        result = throw(rospy.get_param("~seconds"), least=21)
        print(f"garbage: {result}")
        self.assertGreater(min(result["messages"], result["calls"]), 20)
        self.assertEqual(result["lost"], [])
        self.assertFalse(result["stuck"])
        self.assertLess(result["moved"], 0.01)
        self.assertLess(result["beyond"], 0.005)
        self.assertLess(max(result["growth"].values()), 30.0)


if __name__ == "__main__":
    rospy.init_node("garbage", anonymous=len(sys.argv) == 2)
    if len(sys.argv) == 2:
        print(json.dumps(throw(float(sys.argv[1]))))
    else:
        rostest.rosrun("telex_tests", "garbage", GarbageTest)
