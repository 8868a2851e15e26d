"""The robot's URDF on the parameter server."""

from __future__ import annotations

import time

import rospy

GLOBAL_NAME = "/robot_description"


def offer_globally(description: str) -> None:
    """Set the URDF where tools look for it that know no namespaces.

    rqt_joint_trajectory_controller does, and much else that was written for a robot of its own.
    """
    rospy.set_param(GLOBAL_NAME, description)


def wait_for_robot_description() -> str:
    """Return the URDF of this node's namespace, as soon as it is there.

    Raises
    ------
    rospy.ROSInterruptException
        When the node is shut down meanwhile.
    """
    name = rospy.resolve_name("robot_description")
    reminded = -30.0
    while not rospy.is_shutdown():
        description = rospy.get_param(name, None)
        if description is not None:
            return str(description)
        # Not rospy's throttle and sleep: sim time need not run before there is a robot.
        if time.monotonic() - reminded >= 10.0:
            reminded = time.monotonic()
            rospy.logwarn(f"waiting for the parameter {name}; the simulator's launch file sets it")
        time.sleep(0.1)
    raise rospy.ROSInterruptException("shut down while waiting for robot_description")
