#!/usr/bin/env python3
"""Waits until the robot can be driven and the first picture has come, then says how to begin."""

from __future__ import annotations

import argparse
import os
import sys
import time
import urllib.error
import urllib.request
from typing import Callable, Optional
from xmlrpc.client import Error as XmlRpcError

import rosgraph
import rospy
from controller_manager_msgs.srv import ListControllers

KEYS = """
  Console   {url}
  Keys      W S A D  drive       R F  front flippers    T G  rear flippers
            J L  turret    I K  shoulder    U O  telescope    P ;  elbow
            , .  gripper   - =  speed       Esc  emergency stop
            The page shows all. Hold to move, release to stop.
  Terminal  source env.sh && rosrun telex_teleop keyboard_teleop
  ROS       source env.sh && rostopic list        (everything is under {namespace})
  Stop      Ctrl-C
"""


def alive(pid: int) -> bool:
    """Whether process `pid` still runs."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


class Waiter:
    """Waits for one condition after the other, with a common deadline."""

    def __init__(self, launch_pid: int, timeout: float) -> None:
        self._launch_pid = launch_pid
        self._started = time.monotonic()
        self._deadline = self._started + timeout

    def wait(self, what: str, condition: Callable[[], Optional[object]]) -> object:
        """Return the first true value of `condition`; ends the program when none comes."""
        while True:
            value = condition()
            if value:
                print(f"  {what}: {time.monotonic() - self._started:.1f} s", flush=True)
                return value
            if self._launch_pid and not alive(self._launch_pid):
                sys.exit(f"waiting for '{what}': roslaunch has ended")
            if time.monotonic() > self._deadline:
                sys.exit(f"'{what}' did not come in time; see the messages of the nodes above")
            time.sleep(0.1)


def controllers_run(namespace: str) -> bool:
    """Whether controllers are loaded and all of them run."""
    try:
        service = rospy.ServiceProxy(
            f"{namespace}/controller_manager/list_controllers", ListControllers
        )
        states = [controller.state for controller in service().controller]
    except rospy.ServiceException:
        return False
    return bool(states) and all(state == "running" for state in states)


def console_url(namespace: str) -> Optional[str]:
    """Address of the console, once the video server has one; None while it has not."""
    return rospy.get_param(f"{namespace}/video_server/url", None)


def first_picture(url: str, namespace: str) -> bool:
    """Whether the video server delivers a picture of the front camera."""
    address = f"{url}/snapshot?topic={namespace}/cameras/front/image_raw"
    try:
        with urllib.request.urlopen(address, timeout=5.0) as answer:
            return answer.read(2) == b"\xff\xd8"
    except (urllib.error.URLError, OSError):
        return False


def main() -> None:
    """Wait, then print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--namespace", default="telex")
    parser.add_argument("--launch-pid", type=int, default=0)
    parser.add_argument("--no-console", action="store_true", help="the console was not asked for")
    parser.add_argument("--no-picture", action="store_true", help="the cameras were not asked for")
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
    waiter.wait("robot controllable", lambda: controllers_run(namespace))
    url = "(not started)"
    if not options.no_console:
        url = str(waiter.wait("console", lambda: console_url(namespace)))
        if not options.no_picture:
            waiter.wait("first camera picture", lambda: first_picture(url, namespace))
    print(KEYS.format(url=url, namespace=namespace), flush=True)


if __name__ == "__main__":
    main()
