"""The ``add_robot`` node: puts the robot of its namespace into a simulator while it lives."""

from __future__ import annotations

import sys
from typing import Optional

import rospy
from telex_msgs.srv import AddRobot, RemoveRobot

from telex_control.ros.node_start import init_node

_REMIND = 10.0


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
    problem = _problem(service, robot)
    if problem is not None:
        rospy.logfatal("%s cannot be added: %s", robot or "/", problem)
        sys.exit(1)

    def remove() -> None:
        try:
            rospy.ServiceProxy(f"{simulator}/sim/remove_robot", RemoveRobot)(robot)
        except rospy.ServiceException as error:
            # Most likely the simulator has ended too, and with it the robot.
            rospy.logdebug("%s could not be removed: %s", robot, error)

    rospy.on_shutdown(remove)
    rospy.spin()
