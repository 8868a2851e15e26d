"""A scripted operator's hands and eyes: commands to the robot, and what comes back."""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass
from typing import Callable, Dict, Optional, Sequence, Tuple

from telex_control.common.geometry.quaternions import rpy_from_quaternion

from .port import Drive, JointTargets, NotManagedError, Observation, Placement, Port

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


@dataclass(frozen=True)
class RobotPose:
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
    def of(placement: Placement) -> RobotPose:
        """Return the pose of a base that is placed so."""
        roll, pitch, yaw = rpy_from_quaternion(placement.orientation)
        return RobotPose(*placement.position, roll, -pitch, yaw)


class Operator(abc.ABC):
    """Drives one robot, and sees it.

    Nothing here knows of a simulation: time passes by the port alone.

    Attributes
    ----------
    time : float
        Sim time since the script began (s).
    pose : RobotPose
        Of the base, as an instructor sees it.
    longest_wait : float
        How long anything is waited for at most (s), as if it came then: where it is short, scripts
        only show that they still run.
    """

    pose: RobotPose
    longest_wait = math.inf

    def __init__(self, port: Port) -> None:
        self.time = 0.0
        self._port = port
        self._seen = Observation()
        self._velocity = (0.0, 0.0)
        self._lane: Optional[Tuple[float, float, float]] = None

    def look(self) -> None:
        """See the robot as it is now."""
        self._seen = self._port.observe()
        if self._seen.base is not None:
            self.pose = self._pose_of(self._seen.base)

    def _pose_of(self, base: Placement) -> RobotPose:
        return RobotPose.of(base)

    def joint(self, name: str) -> float:
        """Measured position of a joint, by its name without ``_joint`` (rad, m)."""
        return self._seen.positions[f"{name}_joint"]

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

    @abc.abstractmethod
    def move(self, **positions: float) -> None:
        """Send joints, named without ``_joint``, to positions (rad, m)."""

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
        self._port.send(self._speed())
        self._pass(TICK)
        pose = self.pose
        if abs(pose.rise) > TIPPED or abs(pose.roll) > ROLLED:
            raise NotManagedError(f"tipped over {self.where()}")

    def say_nothing(self, seconds: float) -> None:
        """Let time pass (s) as an operator who is lost: not even a stop is sent."""
        self._pass(seconds)

    def _pass(self, seconds: float) -> None:
        """Let sim time pass (s), and look."""
        self._port.advance(seconds)
        self.time += seconds
        self.look()

    def _speed(self) -> Drive:
        """Return what the tracks are told now."""
        linear, angular = self._velocity
        return Drive(linear, angular if self._lane is None else self._steering(*self._lane))

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
        self.look()  # what was done since the last one may have taken long
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
        self.look()
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


class DirectOperator(Operator):
    """Drives a robot by its controllers, past the teleoperation nodes.

    Parameters
    ----------
    port : Port
        Takes `Drive` and `JointTargets`.
    """

    def __init__(self, port: Port) -> None:
        super().__init__(port)
        self._targets: Dict[str, float] = {}

    def move(self, **positions: float) -> None:
        """Send joints, named without ``_joint``, to positions (rad, m)."""
        named = {f"{name}_joint": position for name, position in positions.items()}
        news = {
            joint: position
            for joint, position in named.items()
            if self._targets.get(joint) != position
        }
        if news:
            self._port.send(JointTargets(news))
            self._targets.update(news)
