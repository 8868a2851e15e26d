"""A `PathRig` over ROS: the controllers of a simulator, or a robot, that runs."""

from __future__ import annotations

from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import rospy
from control_msgs.msg import JointControllerState
from sensor_msgs.msg import JointState
from telex_msgs.msg import Proximity, SimStatus

from ..step_response.ros_session import RosRig
from . import FollowTrajectoryError
from .analysis import PathRecording, overdue
from .watch import MotionWatch

References = Callable[[float], Mapping[str, float]]

_GLANCE = 0.01
"""Sim time (s) between two looks at whether the motion may go on."""
_LATE = 1.0
"""Sim time (s) after the end of a stream in which its last joint state has to come."""


class TrajectoryRig(RosRig):
    """The position controllers of an arm, led at the pace of the joint states.

    Parameters
    ----------
    namespace : str
        Of the robot, without a slash at its end.
    joints : sequence of str
        The arm's, in the order of recordings.
    rate : float
        Of the references (Hz of sim time); joint states that come faster are recorded only.
    watch : MotionWatch
        Ends motions early. The joints then come to rest at the last references.

    Raises
    ------
    StepError
        As `RosRig`.
    FollowTrajectoryError
        A joint has no controller that runs; or, from a motion, the watch has ended it.
    """

    def __init__(
        self, namespace: str, joints: Sequence[str], rate: float, watch: MotionWatch
    ) -> None:
        self._arm = list(joints)
        self._period = 1.0 / rate
        self._references: Optional[References] = None
        self._begin: Optional[float] = None
        self._next = 0.0
        self._samples_of_arm: List[Tuple[float, List[float]]] = []
        # Of a stream: when references were due, and which; what controllers held, and when.
        self._sent: List[Tuple[float, Mapping[str, float]]] = []
        self._held: Dict[str, List[Tuple[float, float]]] = {joint: [] for joint in joints}
        self._watch = watch
        super().__init__(namespace, self._arm)
        rospy.Subscriber(f"{namespace}/sim/proximity", Proximity, watch.on_proximity)
        rospy.Subscriber(f"{namespace}/sim/status", SimStatus, watch.on_status)
        without = [joint for joint in self._arm if joint not in self._controllers]
        if without:
            raise FollowTrajectoryError(
                f"no position controller runs for {', '.join(without)}; start them, e.g. by "
                "controller_group switch manual"
            )

    def lag(self) -> float:
        """See `PathRig`: the delay of the filters, and of references that are held, in the mean."""
        frequencies = [
            float(
                rospy.get_param(
                    f"{self._namespace}/{self._controllers[joint]}/command_filter_frequency", 0.0
                )
            )
            for joint in self._arm
        ]
        delays = [2.0 / each if each > 0.0 else 0.0 for each in frequencies]
        return sum(delays) / len(delays) + 0.5 * self._period

    def wait(self, seconds: float) -> None:
        """See `PathRig`."""
        end = rospy.get_time() + seconds
        while True:
            if self._watch.reason is not None:
                raise FollowTrajectoryError(self._watch.reason)
            left = end - rospy.get_time()
            if left <= 0.0:
                return
            super().wait(min(left, _GLANCE))

    def stream(self, references: References, end: float) -> PathRecording:
        """See `PathRig`."""
        self._samples_of_arm, self._sent = [], []
        self._held = {joint: [] for joint in self._arm}
        self._begin, self._next = None, 0.0
        self._references = references
        try:
            self.wait(end)
            late = 0.0
            while not self._samples_of_arm or self._samples_of_arm[-1][0] < end:
                if late > _LATE:
                    raise FollowTrajectoryError(
                        "joint states stopped before the end; is the simulator paused?"
                    )
                self.wait(0.02)
                late += 0.02
        finally:
            self._references = None
        times, positions = zip(*self._samples_of_arm)
        return PathRecording(np.array(times), np.array(positions), self._overdue())

    def _overdue(self) -> np.ndarray:
        due = [time for time, _ in self._sent]
        late: List[float] = []
        for joint, looks in self._held.items():
            late += overdue(due, [references[joint] for _, references in self._sent], looks)
        return np.array(late)

    def _keeper(self, joint: str) -> Callable[[JointControllerState], None]:
        keep = super()._keeper(joint)

        def keep_all(message: JointControllerState) -> None:
            keep(message)
            if self._references is not None and self._begin is not None:
                time = message.header.stamp.to_sec() - self._begin
                self._held[joint].append((time, message.set_point))

        return keep_all

    def _on_joint_states(self, message: JointState) -> None:
        super()._on_joint_states(message)
        references = self._references
        if references is None or not set(self._arm) <= set(message.name):
            return
        if self._stopped or self._watch.reason is not None:
            return
        stamp = message.header.stamp.to_sec()
        if self._begin is None:
            self._begin = stamp
        time = stamp - self._begin
        measured: Dict[str, float] = dict(zip(message.name, message.position))
        self._samples_of_arm.append((time, [measured[joint] for joint in self._arm]))
        if time >= self._next - 1e-6:
            self._next += self._period * max(1.0, np.floor((time - self._next) / self._period) + 1)
            wanted = references(time)
            self._sent.append((time, wanted))
            for joint, position in wanted.items():
                self.command(joint, position)
