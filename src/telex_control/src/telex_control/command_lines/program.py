"""Common parts of the command lines: start, and end when ROS does not answer."""

from __future__ import annotations

import os
import sys
from typing import Callable, List, Type

import rosgraph
import rospy

from ..ros.node_start import init_node

SIGINT_STATUS = 130
"""Exit status of a program that was ended by SIGINT, by convention of shells."""


def run(name: str, work: Callable[[], int]) -> None:
    """Run `work` in a node called `name` (made unique), and end the process with its status.

    A manager that goes while it is asked is one line of error and status 1, not a traceback.
    """
    try:
        init_node(name, anonymous=True, coarse_clock=True)
        status = work()
    except rospy.ROSInterruptException:
        status = 0
    except rospy.ServiceException as error:
        status = 0
        if not rospy.is_shutdown():
            print(f"{name}: the controller manager did not answer: {error}", file=sys.stderr)
            status = 1
    except KeyboardInterrupt:
        status = SIGINT_STATUS
    sys.exit(status)


def run_measurement(name: str, work: Callable[[], object], *errors: Type[Exception]) -> None:
    """Run `work`, which moves the robot, and end the process: with status 1 if it breaks off.

    Parameters
    ----------
    name : str
        Of the program, for messages.
    work : callable
        Calls `begin_measurement` before it asks ROS for anything.
    *errors
        What it may raise besides errors of ROS and of files; each is one line, not a traceback.
    """
    status = 0
    try:
        work()
    except (OSError, rospy.ROSException, rospy.ServiceException, *errors) as error:
        print(f"{name}: {error}", file=sys.stderr)
        status = 1
    except KeyboardInterrupt:
        status = SIGINT_STATUS
    rospy.signal_shutdown("done")
    sys.exit(status)


def begin_measurement(name: str) -> None:
    """Become a node called `name`, made unique, that an interrupt leaves time to tidy up.

    Raises
    ------
    ConnectionError
        There is no ROS master.
    """
    if not rosgraph.is_master_online():
        uri = os.environ.get("ROS_MASTER_URI", "")
        raise ConnectionError(f"no ROS master at {uri}; start the simulator first")
    # Interrupted, the program still has a robot to put back: the node must live on.
    init_node(name, anonymous=True, own_signals=True)


def arguments() -> List[str]:
    """The command line without the program's name and ROS's remappings."""
    return list(rospy.myargv(sys.argv)[1:])
