"""What the tests of robots that are not Telex share: the crane of ``tests/rostest/crane.urdf``."""

from __future__ import annotations

from typing import Dict, Optional

import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from telex_msgs.msg import SimStatus
from waiting import wait_until


class Crane:
    """Its topics.

    Parameters
    ----------
    prefix : str
        Of their names, with a slash at the end; without it, they are relative.
    """

    def __init__(self, prefix: str = "") -> None:
        self.state: Optional[JointState] = None
        self.status: Optional[SimStatus] = None
        self.base: Optional[PoseStamped] = None
        self._subscribers = [
            rospy.Subscriber(f"{prefix}joint_states", JointState, self._on_state),
            rospy.Subscriber(f"{prefix}sim/status", SimStatus, self._on_status),
            rospy.Subscriber(f"{prefix}sim/base_pose", PoseStamped, self._on_base),
        ]
        self.slew = rospy.Publisher(f"{prefix}slew_controller/command", Float64, queue_size=1)
        self.trolley = rospy.Publisher(f"{prefix}trolley_controller/command", Float64, queue_size=1)
        self.e_stop = rospy.Publisher(f"{prefix}e_stop", Bool, queue_size=1)

    def _on_state(self, message: JointState) -> None:
        self.state = message

    def _on_status(self, message: SimStatus) -> None:
        self.status = message

    def _on_base(self, message: PoseStamped) -> None:
        self.base = message

    def wait_until_controllable(self) -> None:
        """Wait until its controllers listen and the joint states come."""
        publishers = (self.slew, self.trolley, self.e_stop)
        wait_until(
            lambda: all(p.get_num_connections() for p in publishers), "the crane to listen", 60.0
        )
        wait_until(lambda: self.state, "joint states", 10.0)

    def positions(self) -> Dict[str, float]:
        """Joint positions (rad, m)."""
        assert self.state is not None
        return dict(zip(self.state.name, self.state.position))

    def obeys(self) -> None:
        """Command both joints, and see that they follow."""
        self.trolley.publish(Float64(0.5))
        self.slew.publish(Float64(0.5))
        wait_until(lambda: abs(self.positions()["trolley_joint"] - 0.5) < 2e-3, "the trolley", 20.0)
        before = self.positions()["slew_joint"]
        wait_until(lambda: self.positions()["slew_joint"] > before + 0.2, "the jib to turn", 20.0)
        self.slew.publish(Float64(0.0))
