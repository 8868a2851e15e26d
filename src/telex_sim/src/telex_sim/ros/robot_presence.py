"""Topics and services of one simulated robot, in its namespace."""

from __future__ import annotations

import time as wall
from typing import Callable, Optional, Tuple

import rospy
from geometry_msgs.msg import Point, PoseStamped, Vector3
from std_msgs.msg import Bool, Header
from telex_msgs.msg import (
    GripperContact,
    PadContact,
    Proximity,
    ProximityPair,
    SimStatus,
    Stability,
)

from telex_control.manager.controller import ControllerState
from telex_control.manager.controller_manager import Strictness
from telex_control.manager.services import ControllerManagerServices
from telex_control.ros.pose_messages import pose_message

from ..engine.simulation import Simulation
from ..proximity.monitor import NearPair
from ..proximity.monitor import Proximity as Near
from ..robot.gripper.contact import GripperContact as Contact
from ..robot.robot import Robot
from ..scene.model import WORLD_FRAME
from ..stability.monitor import Margin, StabilityMonitor
from .malfunction_service import Change, MalfunctionService
from .sensors.equipment_publisher import EquipmentPublisher
from .sensors.gas_publisher import GasPublisher
from .sensors.microphone_publisher import MicrophonePublisher
from .sensors.radiation_publisher import RadiationPublisher
from .sensors.radio_publisher import RadioPublisher
from .truth_publisher import TruthPublisher

_STOP_TIMEOUT = 1.0
_OLD_NEWS = 2.0
"""Wall time (s) in which a new simulator hears what was latched before it began."""


class RobotPresence:
    """Controller manager, emergency stop, status, ground truth and stability of a robot.

    Topics are opened and closed in a thread of ROS; `observe`, `changed` and all that publishes
    are the simulation's thread's.

    Parameters
    ----------
    change, now : callable
        See `MalfunctionService`.
    after_crash : bool
        Whether the simulator before has crashed: latched releases of its emergency stop that come
        in the first moments may be older than the stop.
    """

    def __init__(
        self,
        robot: Robot,
        change: Change,
        now: Callable[[], rospy.Time],
        after_crash: bool = False,
    ) -> None:
        self.robot = robot
        self._no_release_before = wall.monotonic() + (_OLD_NEWS if after_crash else 0.0)
        namespace = robot.namespace
        self._told = (False, False, False)
        self._monitor: Optional[StabilityMonitor] = None
        self._margin = 1.0
        self._base_pose = rospy.Publisher(f"{namespace}/sim/base_pose", PoseStamped, queue_size=4)
        self._stability = rospy.Publisher(f"{namespace}/sim/stability", Stability, queue_size=4)
        self._status = rospy.Publisher(
            f"{namespace}/sim/status", SimStatus, queue_size=4, latch=True
        )
        self._proximity = rospy.Publisher(
            f"{namespace}/sim/proximity", Proximity, queue_size=1, tcp_nodelay=True
        )
        self._gripper_contact = rospy.Publisher(
            f"{namespace}/sim/gripper_contact", GripperContact, queue_size=1, tcp_nodelay=True
        )
        self._truth = TruthPublisher(robot)
        self.radiation = RadiationPublisher(robot)
        self.radio = RadioPublisher(robot)
        self.gas = GasPublisher(robot)
        self.microphone = MicrophonePublisher(robot)
        self.equipment = EquipmentPublisher(robot)
        self.malfunctions = MalfunctionService(robot, change, now)
        self._manager = ControllerManagerServices(robot.controllers, namespace)
        self._e_stop = rospy.Subscriber(
            f"{namespace}/e_stop", Bool, self._on_e_stop, tcp_nodelay=True
        )

    def _on_e_stop(self, message: Bool) -> None:
        robot = self.robot
        if not message.data and wall.monotonic() < self._no_release_before:
            return
        if message.data != robot.hw.e_stop:
            rospy.logwarn(
                "%s: emergency stop %s", robot.model, "set" if message.data else "released"
            )
        robot.request_e_stop(message.data)

    def observe(self, time: float) -> None:
        """Look at `time` (s) whether the robot has tipped over, or is stuck."""
        robot = self.robot
        if self._monitor is None:
            if not robot.config.tracks.belts or robot.config.fixed_base:
                return
            self._monitor = StabilityMonitor(robot)
            robot.watchers = (*robot.watchers, self._monitor)
        self._monitor.observe(time)

    def _state(self) -> Tuple[bool, bool, bool]:
        """Emergency stop, tipped over, stuck."""
        monitor = self._monitor
        if monitor is None:
            return self.robot.hw.e_stop, False, False
        return self.robot.hw.e_stop, monitor.tipped, monitor.stuck

    def changed(self) -> bool:
        """Whether the last status tells something of this robot that is no longer so."""
        return self._state() != self._told

    def publish_status(self, message: SimStatus) -> None:
        """Publish the simulator's status, with what is this robot's own."""
        self._told = self._state()
        message.e_stop, message.tipped_over, message.stuck = self._told
        warnings = []
        if message.tipped_over:
            warnings.append("the robot lies on its side or back; sim/reset puts it up again")
        if message.stuck:
            warnings.append("the robot is stuck: its belts are told to run, and it does not move")
        message.warnings = [*message.warnings, *warnings]
        self._status.publish(message)

    def publish_stability(self, stamp: rospy.Time) -> None:
        """Publish attitude and tip-over margin, when anybody listens."""
        monitor, told = self._monitor, bool(self._stability.get_num_connections())
        if monitor is None or not (told or self._truth.heard):
            return
        # Both are of one look: it is costly, and each look goes on from the one before.
        margin = monitor.margin(stamp.to_sec())
        self._margin = monitor.warning.margin
        if told:
            self._publish_stability(monitor, margin, stamp)

    def _publish_stability(
        self, monitor: StabilityMonitor, margin: Margin, stamp: rospy.Time
    ) -> None:
        warning = monitor.warning
        message = Stability(
            state=self._stability_state(monitor),
            roll=monitor.attitude.roll,
            pitch=monitor.attitude.pitch,
            margin=warning.margin,
            angle=margin.angle,
            direction=warning.direction if warning.warned else margin.direction,
            support=[Point(*corner) for corner in margin.support],
            center_of_mass=Point(*margin.center_of_mass),
        )
        message.header.stamp = stamp
        message.header.frame_id = self.robot.body.base_link
        self._stability.publish(message)

    def _stability_state(self, monitor: StabilityMonitor) -> int:
        if monitor.tipped:
            return Stability.TIPPED
        if monitor.warning.warned:
            return Stability.CRITICAL
        near = monitor.warning.margin < self.robot.config.stability.caution
        return Stability.CAUTION if near else Stability.STABLE

    def publish_truth(self, simulation: Simulation, stamp: rospy.Time, resets: int) -> None:
        """Publish all that is scored, when anybody listens."""
        self._truth.publish(simulation, stamp, resets, self._margin)

    def publish_base_pose(self, stamp: rospy.Time) -> None:
        """Publish where the root link is, when anybody listens."""
        if not self._base_pose.get_num_connections():
            return
        position, orientation = self.robot.body.base_pose()
        message = PoseStamped()
        message.header.stamp = stamp
        message.header.frame_id = WORLD_FRAME
        message.pose = pose_message(position, orientation)
        self._base_pose.publish(message)

    def publish_proximity(self, stamp: rospy.Time, measure: Callable[[Robot], Near]) -> None:
        """Publish what the arm is near to, when anybody listens; nothing is measured for nobody."""
        robot = self.robot
        if not self._proximity.get_num_connections():
            return
        near = self.equipment.sensed(measure(robot))
        self._proximity.publish(
            Proximity(
                header=Header(stamp=stamp, frame_id=robot.body.base_link),
                range=robot.config.proximity.range,
                joints=list(robot.proximity.joints),
                positions=list(near.positions),
                pairs=[_pair_message(pair) for pair in near.pairs],
            )
        )

    def publish_gripper_contact(
        self, stamp: rospy.Time, measure: Callable[[Robot], Optional[Contact]]
    ) -> None:
        """Publish what the gripper holds, when it has one and anybody listens."""
        if not self._gripper_contact.get_num_connections():
            return
        contact = measure(self.robot)
        if contact is None:
            return
        contact = self.equipment.felt(contact)
        self._gripper_contact.publish(
            GripperContact(
                header=Header(stamp=stamp, frame_id=self.robot.body.base_link),
                opening=contact.opening,
                force=contact.force,
                object=contact.object,
                slipping=contact.slipping,
                slip_speed=contact.slip_speed,
                pads=[PadContact(**pad._asdict()) for pad in contact.pads],
            )
        )

    def unload_controllers(self) -> None:
        """Stop and unload all controllers, while the robot is still in the loop."""
        manager = self.robot.controllers
        listed = manager.list_controllers()
        running = [info.name for info, state in listed if state is ControllerState.RUNNING]
        if running:
            manager.switch_controller([], running, Strictness.BEST_EFFORT, timeout=_STOP_TIMEOUT)
        for info, _ in listed:
            manager.unload_controller(info.name)

    def close(self) -> None:
        """Take all services and topics back."""
        self._e_stop.unregister()
        self._manager.shutdown()
        self._base_pose.unregister()
        self._stability.unregister()
        self._status.unregister()
        self._proximity.unregister()
        self._gripper_contact.unregister()
        self._truth.close()
        self.radiation.close()
        self.radio.close()
        self.gas.close()
        self.microphone.close()
        self.equipment.close()
        self.malfunctions.close()
        self.robot.close()


def _pair_message(pair: NearPair) -> ProximityPair:
    place = pair.place
    return ProximityPair(
        contact=ProximityPair.TOUCHABLE if pair.touchable else ProximityPair.GUARDED,
        link=pair.link,
        other=pair.other,
        distance=place.distance,
        closing_speed=pair.closing_speed,
        point=Point(*place.point),
        normal=Vector3(*place.normal),
        gradient=list(place.gradient),
    )
