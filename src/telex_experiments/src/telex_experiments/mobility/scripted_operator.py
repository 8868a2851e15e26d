"""A scripted operator's hands and eyes: commands to the robot's topics, and what comes back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, Sequence, Tuple

from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from telex_control.common.geometry.quaternions import rpy_from_quaternion
from telex_control.ros.node_handle import NodeHandle, Publisher
from telex_control.ros.pose_messages import quaternion_in, vector_in

TICK = 0.04
"""Sim time from one look at the robot to the next (s): a whole number of its messages' periods."""

TIPPED, ROLLED = 1.40, 0.90
"""Nose up or down, and sideways (rad), from which there is no way back."""

FRONT_FLIPPERS = ("front_left_flipper", "front_right_flipper")
REAR_FLIPPERS = ("rear_left_flipper", "rear_right_flipper")

FlipperAngles = Tuple[float, float]
"""Front and rear (rad): 0 is flat on the floor, positive up."""

_HEADING_GAIN = 2.0  # (rad/s)/rad
_ASIDE_GAIN = 1.5  # rad/m
_UNSEEN = 0.02  # rad; an operator does not correct what cannot be seen
_MOST_CORRECTION = 0.5  # rad
_MOST_TURNING = 0.6  # rad/s
_PROGRESS = 0.02  # m, that tells progress from slipping


class NotManagedError(Exception):
    """The robot did not do what the script is for; the message says what happened instead."""


@dataclass(frozen=True)
class Pose:
    """Where the robot's base is.

    Attributes
    ----------
    x, y, z : float
        Of base_link, which lies on the line of the axles (m).
    roll : float
        About the robot's x axis (rad).
    rise : float
        Angle of the robot's x axis over the horizon (rad): positive nose up.
    yaw : float
        Heading (rad).
    """

    x: float
    y: float
    z: float
    roll: float
    rise: float
    yaw: float

    @staticmethod
    def of(position: Any, orientation: Any) -> Pose:
        """Read a geometry_msgs/Point and Quaternion."""
        roll, pitch, yaw = rpy_from_quaternion(quaternion_in(orientation))
        return Pose(*vector_in(position), roll, -pitch, yaw)


class Operator:
    """Drives one robot by its controllers' topics, and sees it by its own.

    Nothing here knows of a simulation: time passes by `advance` alone.

    Parameters
    ----------
    node : NodeHandle
        The robot's namespace.
    advance : callable
        Lets so much sim time (s) pass, and returns once its messages are there.
    drive_topic : str
        Where speeds go (geometry_msgs/Twist).

    Attributes
    ----------
    time : float
        Sim time since the script began (s).
    pose : Pose
        Of ``sim/base_pose``, as an instructor sees it.
    longest_wait : float
        How long anything is waited for at most (s), as if it came then: where it is short, scripts
        only show that they still run.
    """

    pose: Pose
    longest_wait = math.inf

    def __init__(
        self,
        node: NodeHandle,
        advance: Callable[[float], None],
        drive_topic: str = "track_controller/cmd_vel",
    ) -> None:
        self.time = 0.0
        self._node = node
        self._advance = advance
        self._joints: Dict[str, float] = {}
        self._velocity = (0.0, 0.0)
        self._lane: Optional[Tuple[float, float, float]] = None
        self._positions: Dict[str, Tuple[Publisher, float]] = {}
        self._tracks = node.advertise(drive_topic, Twist)
        node.subscribe("sim/base_pose", PoseStamped, self._on_base_pose)
        node.subscribe("joint_states", JointState, self._on_joint_states)

    def _on_base_pose(self, message: PoseStamped) -> None:
        self.pose = Pose.of(message.pose.position, message.pose.orientation)

    def _on_joint_states(self, message: JointState) -> None:
        self._joints = dict(zip(message.name, message.position))

    def joint(self, name: str) -> float:
        """Measured position of a joint, by its name without ``_joint`` (rad, m)."""
        return self._joints[f"{name}_joint"]

    # --- commands --------------------------------------------------------------------------------

    def drive(self, linear: float, angular: float = 0.0) -> None:
        """Drive with so much speed (m/s, rad/s) from now on."""
        self._velocity, self._lane = (linear, angular), None

    def keep_lane(
        self, linear: float, through: Tuple[float, float] = (0.0, 0.0), yaw: float = 0.0
    ) -> None:
        """Drive from now on (m/s) along the line through a point (m) with a heading, by eye."""
        self._velocity, self._lane = (linear, 0.0), (*through, yaw)

    def stop(self) -> None:
        """Stand still from now on."""
        self.drive(0.0)

    def move(self, **positions: float) -> None:
        """Send joints, named without ``_joint``, to positions (rad, m)."""
        for name, position in positions.items():
            publisher, last = self._positions.get(name, (None, None))
            if last == position:
                continue
            if publisher is None:
                publisher = self._node.advertise(f"{name}_position_controller/command", Float64)
            publisher.publish(Float64(position))
            self._positions[name] = (publisher, position)

    def flippers(self, front: float, rear: float) -> None:
        """Send the flippers, left and right together, to angles (rad); see `FlipperAngles`."""
        self.move(**dict.fromkeys(FRONT_FLIPPERS, front), **dict.fromkeys(REAR_FLIPPERS, rear))

    # --- time ------------------------------------------------------------------------------------

    def tick(self) -> None:
        """Repeat the speed, as a held key does, and let a moment pass.

        Raises
        ------
        NotManagedError
            The robot lies on its side or back.
        """
        self._tracks.publish(self._speed())
        self._advance(TICK)
        self.time += TICK
        pose = self.pose
        if abs(pose.rise) > TIPPED or abs(pose.roll) > ROLLED:
            raise NotManagedError(f"tipped over {self.where()}")

    def say_nothing(self, seconds: float) -> None:
        """Let time pass (s) as an operator who is lost: not even a stop is sent."""
        self._advance(seconds)
        self.time += seconds

    def _speed(self) -> Twist:
        """Return what the tracks are told now."""
        message = Twist()
        message.linear.x, message.angular.z = self._velocity
        if self._lane is not None:
            message.angular.z = self._steering(*self._lane)
        return message

    def _steering(self, x: float, y: float, yaw: float) -> float:
        """Turning (rad/s) that leads back to the lane."""
        pose, forwards = self.pose, math.copysign(1.0, self._velocity[0])
        aside = (pose.y - y) * math.cos(yaw) - (pose.x - x) * math.sin(yaw)
        back = max(-_MOST_CORRECTION, min(_MOST_CORRECTION, _ASIDE_GAIN * aside))
        error = math.remainder(yaw - forwards * back - pose.yaw, 2.0 * math.pi)
        if abs(error) < _UNSEEN:
            return 0.0
        return max(-_MOST_TURNING, min(_MOST_TURNING, _HEADING_GAIN * error))

    def wait(self, seconds: float) -> None:
        """Go on for so much sim time (s)."""
        for _ in range(round(min(seconds, self.longest_wait) / TICK)):
            self.tick()

    def until(
        self,
        reached: Callable[[], bool],
        timeout: float,
        what: str,
        meanwhile: Optional[Callable[[], None]] = None,
    ) -> None:
        """Go on until something is reached.

        Parameters
        ----------
        reached : callable
        timeout : float
            s.
        what : str
            What is to be reached, for the message.
        meanwhile : callable, optional
            What the operator does at every look.

        Raises
        ------
        NotManagedError
            It is not reached within `timeout`.
        """
        end = self.time + min(timeout, self.longest_wait)
        while not reached():
            if self.time >= end:
                if timeout > self.longest_wait:
                    return
                raise NotManagedError(f"not within {timeout:g} s: {what}; {self.where()}")
            if meanwhile is not None:
                meanwhile()
            self.tick()

    def work_on(
        self,
        reached: Callable[[], bool],
        settings: Sequence[FlipperAngles],
        timeout: float,
        what: str,
        patience: float = 1.5,
        way: Optional[Callable[[], float]] = None,
    ) -> None:
        """Go on, trying one setting of the flippers after the other.

        Parameters
        ----------
        reached : callable
        settings : sequence of FlipperAngles
            The next is tried, round and round, when there is no progress with one.
        timeout : float
            s.
        what : str
            What is to be reached, for the message.
        patience : float
            How long to wait for progress (s).
        way : callable, optional
            How far the robot has come (m); without it, by its x.

        Raises
        ------
        NotManagedError
            It is not reached within `timeout`.
        """
        come = way or (lambda: self.pose.x)
        end, turn = self.time + min(timeout, self.longest_wait), 0
        best, since = come(), self.time
        self.flippers(*settings[0])
        while not reached():
            if self.time >= end:
                if timeout > self.longest_wait:
                    return
                raise NotManagedError(f"not within {timeout:g} s: {what}; {self.where()}")
            if come() > best + _PROGRESS:
                best, since = come(), self.time
            elif self.time - since > patience:
                turn, since = turn + 1, self.time
                self.flippers(*settings[turn % len(settings)])
            self.tick()

    def where(self) -> str:
        """Time and place, for messages."""
        pose = self.pose
        return (
            f"at {self.time:.1f} s, x {pose.x:.2f} y {pose.y:.2f} z {pose.z:.2f} m, "
            f"rise {math.degrees(pose.rise):.0f}, roll {math.degrees(pose.roll):.0f} deg"
        )
