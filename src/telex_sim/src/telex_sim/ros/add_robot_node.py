"""The ``add_robot`` node: puts the robot of its namespace into a simulator while it lives.

A simulator that comes anew after a crash gets it again.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Optional

import rosgraph
import rospy
from telex_msgs.srv import AddRobot, RemoveRobot

from telex_control.ros.node_start import init_node

_REMIND = 10.0
"""Wall time (s) after which it says that it waits for a simulator."""

_WATCH_PERIOD = 1.0
"""Wall time (s) between two looks whether the simulator is another one."""


def _wait_for(service: str) -> None:
    """Wait for a service, and say so now and then.

    Raises
    ------
    rospy.ROSInterruptException
        The node is shut down.
    """
    while not rospy.is_shutdown():
        try:
            # Wall time, for sim time does not run without a simulator.
            rospy.wait_for_service(service, _REMIND)
            return
        except rospy.ROSInterruptException:
            raise
        except rospy.ROSException:
            rospy.logwarn("waiting for %s; is there a simulator in this namespace?", service)
    raise rospy.ROSInterruptException("shut down while waiting")


def _problem(service: str, robot: str) -> Optional[str]:
    """Why the robot cannot be added, or None when it was."""
    try:
        answer = rospy.ServiceProxy(service, AddRobot)(robot)
    except rospy.ServiceException as error:
        return str(error)
    return None if answer.success else answer.message


def _address(service: str) -> Optional[str]:
    """Where a service is offered; None where that is not known now."""
    try:
        return str(rosgraph.Master(rospy.get_name()).lookupService(service))
    except (rosgraph.MasterException, OSError):
        return None


def _wait_for_another(service: str, address: Optional[str]) -> Optional[str]:
    """Wait until a service is offered elsewhere, and return where; None when the node ends."""
    while not rospy.is_shutdown():
        time.sleep(_WATCH_PERIOD)
        now = _address(service)
        if now not in (None, address):
            return now
    return None


def main() -> None:
    """Add the robot, and take it out again when the node ends."""
    init_node("add_robot")
    robot = rospy.get_namespace().rstrip("/")
    simulator = rospy.resolve_name(rospy.get_param("~simulator", "/telex")).rstrip("/")
    service = f"{simulator}/sim/add_robot"
    try:
        _wait_for(service)
    except rospy.ROSInterruptException:
        return
    address = _address(service)
    # Started again after a crash of its own, it finds the robot there, and moves nothing.
    there = address == _address(f"{robot}/controller_manager/list_controllers")
    problem = None if there else _problem(service, robot)
    if problem is not None:
        rospy.logfatal("%s cannot be added: %s", robot or "/", problem)
        sys.exit(os.EX_CONFIG)

    def remove() -> None:
        try:
            rospy.ServiceProxy(f"{simulator}/sim/remove_robot", RemoveRobot)(robot)
        except rospy.ServiceException as error:
            # Most likely the simulator has ended too, and with it the robot.
            rospy.logdebug("%s could not be removed: %s", robot, error)

    rospy.on_shutdown(remove)
    while True:
        address = _wait_for_another(service, address)
        if address is None:
            return
        rospy.logwarn("the simulator has been started again")
        problem = _problem(service, robot)
        if problem is not None:
            rospy.logerr("%s cannot be added again: %s", robot or "/", problem)
