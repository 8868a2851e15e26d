"""Loads and starts controllers, and stops and unloads them again when it ends.

The command line is that of ros_control's ``spawner``, and ``--optional`` beyond it.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from typing import List, Optional

import rospy
import yaml
from controller_manager_msgs.srv import (
    LoadController,
    SwitchController,
    SwitchControllerRequest,
    UnloadController,
)
from std_msgs.msg import Bool

from telex_control.controller_joints import controller_joints
from telex_control.urdf_joints import UrdfError, parse_urdf, transmissions

_STOP_TIMEOUT = 1.0
"""Wall time (s) that the manager gets to stop and unload when the spawner ends."""


def parse(arguments: List[str]) -> argparse.Namespace:
    """Read the command line (without the program's name and ROS's remappings)."""
    parser = argparse.ArgumentParser(prog="spawner", description=__doc__.split("\n", 1)[0])
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
    parser.add_argument("--stopped", action="store_true", help="load only, do not start")
    parser.add_argument("--wait-for", metavar="TOPIC", help="a std_msgs/Bool that must be true")
    parser.add_argument("--namespace", metavar="NS", help="namespace of the controller manager")
    parser.add_argument(
        "--timeout", type=float, default=30.0, help="seconds to wait for the manager"
    )
    parser.add_argument(
        "--shutdown-timeout", type=float, help="taken for compatibility, without effect"
    )
    parser.add_argument("--no-timeout", action="store_true", help="wait for the manager for ever")
    return parser.parse_args(arguments)


class SpawnerError(Exception):
    """The command line cannot be carried out; the message says why."""


class Spawner:
    """Brings a group of controllers up and down."""

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._prefix = f"{namespace}/controller_manager" if namespace else "controller_manager"
        self._loaded: List[str] = []
        self._started = False

    def names_of(self, argument: str) -> List[str]:
        """Controllers that an argument stands for; a file's parameters are loaded.

        Raises
        ------
        SpawnerError
            The file cannot be read, or holds no controllers.
        """
        if not argument.endswith((".yaml", ".yml")):
            return [argument]
        try:
            with open(argument) as file:
                params = yaml.safe_load(file)
        except (OSError, yaml.YAMLError) as error:
            raise SpawnerError(f"{argument}: {error}") from error
        if not isinstance(params, dict) or not all(isinstance(v, dict) for v in params.values()):
            raise SpawnerError(f"{argument}: a mapping of controller names to parameters is needed")
        for name, values in params.items():
            rospy.set_param(self._param(str(name)), values)
        return [str(name) for name in params]

    def wait_for_manager(self, timeout: Optional[float]) -> bool:
        """Wait for the services; False, with a warning, when they do not come."""
        rospy.loginfo("Controller Spawner: waiting for service %s/load_controller", self._prefix)
        end = None if timeout is None else time.monotonic() + timeout
        try:
            for name in ("load_controller", "switch_controller", "unload_controller"):
                left = None if end is None else max(end - time.monotonic(), 0.01)
                rospy.wait_for_service(f"{self._prefix}/{name}", timeout=left)
        except rospy.ROSException:
            if not rospy.is_shutdown():
                rospy.logwarn(
                    "Controller Spawner couldn't find the expected controller_manager ROS "
                    "interface (%s/load_controller) within %s s; is the simulator running, and "
                    "is this its namespace?",
                    self._prefix,
                    timeout,
                )
            return False
        return True

    def present(self, names: List[str], optional: List[str]) -> List[str]:
        """Return `names` and those of the `optional` controllers whose joints the robot has.

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
        return kept

    def _driven_joints(self) -> List[str]:
        description = rospy.get_param(self._param("robot_description"), None)
        if description is None:
            raise SpawnerError(
                f"--optional needs the parameter {self._param('robot_description')}, which is not "
                "set"
            )
        try:
            return [each.joint for each in transmissions(parse_urdf(str(description)))]
        except UrdfError as error:
            raise SpawnerError(str(error)) from error

    def _joints_of(self, controller: str) -> List[str]:
        return controller_joints(rospy.get_param(self._param(controller), {}))

    def _param(self, name: str) -> str:
        return f"{self._namespace}/{name}" if self._namespace else name

    def start(self, names: List[str], stopped: bool) -> bool:
        """Load all of `names`, and start them in one switch unless `stopped`."""
        load = rospy.ServiceProxy(f"{self._prefix}/load_controller", LoadController)
        for name in names:
            rospy.loginfo("Loading controller: %s", name)
            if not load(name).ok:
                rospy.logerr("Failed to load %s; the controller manager's log says why", name)
                return False
            self._loaded.append(name)
        if stopped:
            return True
        if not self._switch(start=names):
            rospy.logerr("Failed to start %s", " ".join(names))
            return False
        self._started = True
        rospy.loginfo("Started controllers: %s", ", ".join(names))
        return True

    def stop(self) -> None:
        """Stop and unload what was started, in reverse order.

        When everything is shut down together, the manager may die while it is asked; a service
        call has no timeout, so it is not waited for longer than `_STOP_TIMEOUT`.
        """
        worker = threading.Thread(target=self._stop, daemon=True)
        worker.start()
        worker.join(_STOP_TIMEOUT)

    def _stop(self) -> None:
        names, self._loaded = self._loaded[::-1], []
        try:
            if self._started:
                self._switch(stop=names)
            unload = rospy.ServiceProxy(f"{self._prefix}/unload_controller", UnloadController)
            for name in names:
                unload(name)
        except (rospy.ServiceException, rospy.ROSException):
            rospy.logdebug("the controller manager went before its spawner")

    def _switch(self, start: Optional[List[str]] = None, stop: Optional[List[str]] = None) -> bool:
        switch = rospy.ServiceProxy(f"{self._prefix}/switch_controller", SwitchController)
        answer = switch(
            start_controllers=start or [],
            stop_controllers=stop or [],
            strictness=SwitchControllerRequest.STRICT,
            start_asap=False,
            timeout=0.0,
        )
        return bool(answer.ok)


def main() -> None:
    """Run the spawner until it is shut down."""
    options = parse(rospy.myargv(sys.argv)[1:])
    rospy.init_node("spawner", anonymous=True)
    spawner = Spawner(options.namespace or "")
    try:
        names = [name for argument in options.controllers for name in spawner.names_of(argument)]
        if options.wait_for:
            message = None
            while message is None or not message.data:
                message = rospy.wait_for_message(options.wait_for, Bool)
        if not spawner.wait_for_manager(None if options.no_timeout else options.timeout):
            return
        rospy.on_shutdown(spawner.stop)
        ok = spawner.start(spawner.present(names, options.optional), options.stopped)
    except SpawnerError as error:
        rospy.logerr("%s", error)
        sys.exit(1)
    except (rospy.ServiceException, rospy.ROSInterruptException) as error:
        if not rospy.is_shutdown():
            rospy.logerr("The controller manager did not answer: %s", error)
        return
    if not ok:
        sys.exit(1)
    rospy.spin()
