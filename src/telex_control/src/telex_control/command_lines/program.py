"""What the command lines share: how they begin, and how they end when ROS does not answer."""

from __future__ import annotations

import sys
from typing import Callable, List

import rospy

from ..node_start import init_node

SIGINT_STATUS = 130
"""Exit status of a program that was ended by SIGINT, by convention of shells."""


def run(name: str, work: Callable[[], int]) -> None:
    """Run `work` in a node called `name` (made unique), and end the process with its status.

    A manager that goes while it is asked is one line of error and status 1, not a traceback.
    """
    try:
        init_node(name, anonymous=True)
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


def arguments() -> List[str]:
    """The command line without the program's name and ROS's remappings."""
    return list(rospy.myargv(sys.argv)[1:])
