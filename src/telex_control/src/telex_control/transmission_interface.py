"""Transmissions between actuators and joints, after ros_control's transmission_interface.

A transmission turns efforts, velocities and positions of its actuators into those of its joints and
back. The handles tie one to the handles of a robot, which calls `TransmissionInterface.propagate`
in `RobotHW.read` (actuators to joints) and `RobotHW.write` (joints to actuators).

The simulated robot drives its joints directly, as Gazebo does, and uses none of this: a reduction
does not change what a controller sees.
"""

from __future__ import annotations

import abc
import math
from typing import Sequence, Tuple

from .hardware_interface import (
    ActuatorHandle,
    ActuatorStateHandle,
    JointHandle,
    JointStateHandle,
    NamedHandle,
    ResourceManager,
)

Values = Tuple[float, ...]


class TransmissionError(ValueError):
    """A transmission cannot be made; the message names what is wrong, and its value."""


class Transmission(abc.ABC):
    """A fixed relation between actuators and joints.

    All methods take and return one value for each actuator or joint, in their order: effort (Nm,
    N), velocity (rad/s, m/s) or position (rad, m).

    Attributes
    ----------
    actuator_count, joint_count : int
    """

    actuator_count: int
    joint_count: int

    @abc.abstractmethod
    def actuator_to_joint_effort(self, efforts: Sequence[float]) -> Values:
        """Efforts of the joints."""

    @abc.abstractmethod
    def actuator_to_joint_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocities of the joints."""

    @abc.abstractmethod
    def actuator_to_joint_position(self, positions: Sequence[float]) -> Values:
        """Positions of the joints."""

    @abc.abstractmethod
    def joint_to_actuator_effort(self, efforts: Sequence[float]) -> Values:
        """Efforts of the actuators."""

    @abc.abstractmethod
    def joint_to_actuator_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocities of the actuators."""

    @abc.abstractmethod
    def joint_to_actuator_position(self, positions: Sequence[float]) -> Values:
        """Positions of the actuators."""


def _check(name: str, values: Sequence[float], count: int, nonzero: bool) -> None:
    if len(values) != count:
        raise TransmissionError(f"{name} has {len(values)} values; {count} are needed")
    for value in values:
        if not math.isfinite(value) or (nonzero and value == 0.0):
            wanted = "finite and not 0" if nonzero else "finite"
            raise TransmissionError(f"{name} is {value}; it must be {wanted}")


class SimpleTransmission(Transmission):
    """One actuator on one joint, through a reducer.

    Parameters
    ----------
    reduction : float
        Turns of the actuator for one turn of the joint; negative when they turn against each other.
    joint_offset : float
        Position of the joint (rad, m) where the actuator's is 0.

    Raises
    ------
    TransmissionError
        The reduction is 0, or a value is not finite.
    """

    actuator_count = 1
    joint_count = 1

    def __init__(self, reduction: float, joint_offset: float = 0.0) -> None:
        _check("reduction", (reduction,), 1, nonzero=True)
        _check("joint_offset", (joint_offset,), 1, nonzero=False)
        self._reduction = reduction
        self._offset = joint_offset

    def actuator_to_joint_effort(self, efforts: Sequence[float]) -> Values:
        """Effort of the joint."""
        (effort,) = efforts
        return (self._reduction * effort,)

    def actuator_to_joint_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocity of the joint."""
        (velocity,) = velocities
        return (velocity / self._reduction,)

    def actuator_to_joint_position(self, positions: Sequence[float]) -> Values:
        """Position of the joint."""
        (position,) = positions
        return (position / self._reduction + self._offset,)

    def joint_to_actuator_effort(self, efforts: Sequence[float]) -> Values:
        """Effort of the actuator."""
        (effort,) = efforts
        return (effort / self._reduction,)

    def joint_to_actuator_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocity of the actuator."""
        (velocity,) = velocities
        return (self._reduction * velocity,)

    def joint_to_actuator_position(self, positions: Sequence[float]) -> Values:
        """Position of the actuator."""
        (position,) = positions
        return (self._reduction * (position - self._offset),)


class DifferentialTransmission(Transmission):
    """Two actuators that drive two joints: the first by their sum, the second by their difference.

    Parameters
    ----------
    actuator_reduction : 2 floats
        Turns of each actuator for one turn of the differential's input.
    joint_reduction : 2 floats
        Turns of the differential's outputs for one turn of each joint.
    joint_offset : 2 floats
        Positions of the joints (rad, m) where the actuators' are 0.

    Raises
    ------
    TransmissionError
        A reduction is 0, a value is not finite, or there are not two.
    """

    actuator_count = 2
    joint_count = 2

    def __init__(
        self,
        actuator_reduction: Sequence[float],
        joint_reduction: Sequence[float],
        joint_offset: Sequence[float] = (0.0, 0.0),
    ) -> None:
        _check("actuator_reduction", actuator_reduction, 2, nonzero=True)
        _check("joint_reduction", joint_reduction, 2, nonzero=True)
        _check("joint_offset", joint_offset, 2, nonzero=False)
        self._actuator = tuple(actuator_reduction)
        self._joint = tuple(joint_reduction)
        self._offset = tuple(joint_offset)

    def actuator_to_joint_effort(self, efforts: Sequence[float]) -> Values:
        """Efforts of the joints."""
        a, j = self._actuator, self._joint
        first, second = efforts[0] * a[0], efforts[1] * a[1]
        return j[0] * (first + second), j[1] * (first - second)

    def actuator_to_joint_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocities of the joints."""
        a, j = self._actuator, self._joint
        first, second = velocities[0] / a[0], velocities[1] / a[1]
        return (first + second) / (2.0 * j[0]), (first - second) / (2.0 * j[1])

    def actuator_to_joint_position(self, positions: Sequence[float]) -> Values:
        """Positions of the joints."""
        first, second = self.actuator_to_joint_velocity(positions)
        return first + self._offset[0], second + self._offset[1]

    def joint_to_actuator_effort(self, efforts: Sequence[float]) -> Values:
        """Efforts of the actuators."""
        a, j = self._actuator, self._joint
        first, second = efforts[0] / j[0], efforts[1] / j[1]
        return (first + second) / (2.0 * a[0]), (first - second) / (2.0 * a[1])

    def joint_to_actuator_velocity(self, velocities: Sequence[float]) -> Values:
        """Velocities of the actuators."""
        a, j = self._actuator, self._joint
        first, second = velocities[0] * j[0], velocities[1] * j[1]
        return a[0] * (first + second), a[1] * (first - second)

    def joint_to_actuator_position(self, positions: Sequence[float]) -> Values:
        """Positions of the actuators."""
        return self.joint_to_actuator_velocity(
            (positions[0] - self._offset[0], positions[1] - self._offset[1])
        )


class TransmissionHandle(NamedHandle):
    """A transmission between handles of a robot.

    Parameters
    ----------
    name : str
    transmission : Transmission

    Raises
    ------
    TransmissionError
        The transmission has another number of actuators or joints.
    """

    __slots__ = ("_transmission",)

    def __init__(self, name: str, transmission: Transmission, actuators: int, joints: int) -> None:
        super().__init__(name)
        self._transmission = transmission
        if (actuators, joints) != (transmission.actuator_count, transmission.joint_count):
            raise TransmissionError(
                f"transmission '{name}': {actuators} actuators and {joints} joints are given; "
                f"it has {transmission.actuator_count} and {transmission.joint_count}"
            )

    def propagate(self) -> None:
        """Carry the values over."""
        raise NotImplementedError


class ActuatorToJointStateHandle(TransmissionHandle):
    """Makes joint states of actuator states."""

    __slots__ = ("_actuators", "_joints")

    def __init__(
        self,
        name: str,
        transmission: Transmission,
        actuators: Sequence[ActuatorStateHandle],
        joints: Sequence[JointStateHandle],
    ) -> None:
        super().__init__(name, transmission, len(actuators), len(joints))
        self._actuators = tuple(actuators)
        self._joints = tuple(joints)

    def propagate(self) -> None:
        """Set position, velocity and effort of the joints."""
        actuators, transmission = self._actuators, self._transmission
        positions = transmission.actuator_to_joint_position([a.position for a in actuators])
        velocities = transmission.actuator_to_joint_velocity([a.velocity for a in actuators])
        efforts = transmission.actuator_to_joint_effort([a.effort for a in actuators])
        for joint, position, velocity, effort in zip(self._joints, positions, velocities, efforts):
            joint.position, joint.velocity, joint.effort = position, velocity, effort


class _JointToActuatorHandle(TransmissionHandle):
    """Makes actuator commands of joint commands."""

    __slots__ = ("_actuators", "_joints")

    def __init__(
        self,
        name: str,
        transmission: Transmission,
        actuators: Sequence[ActuatorHandle],
        joints: Sequence[JointHandle],
    ) -> None:
        super().__init__(name, transmission, len(actuators), len(joints))
        self._actuators = tuple(actuators)
        self._joints = tuple(joints)

    def _convert(self, commands: Sequence[float]) -> Values:
        raise NotImplementedError

    def propagate(self) -> None:
        """Set the commands of the actuators."""
        commands = self._convert([joint.command for joint in self._joints])
        for actuator, command in zip(self._actuators, commands):
            actuator.command = command


class JointToActuatorEffortHandle(_JointToActuatorHandle):
    """Makes effort commands of actuators of those of joints."""

    __slots__ = ()

    def _convert(self, commands: Sequence[float]) -> Values:
        return self._transmission.joint_to_actuator_effort(commands)


class JointToActuatorVelocityHandle(_JointToActuatorHandle):
    """Makes velocity commands of actuators of those of joints."""

    __slots__ = ()

    def _convert(self, commands: Sequence[float]) -> Values:
        return self._transmission.joint_to_actuator_velocity(commands)


class JointToActuatorPositionHandle(_JointToActuatorHandle):
    """Makes position commands of actuators of those of joints."""

    __slots__ = ()

    def _convert(self, commands: Sequence[float]) -> Values:
        return self._transmission.joint_to_actuator_position(commands)


class TransmissionInterface(ResourceManager[TransmissionHandle]):
    """The transmissions of a robot that carry values in one direction."""

    type_name = "transmission_interface::TransmissionInterface"

    def propagate(self) -> None:
        """Carry the values of all transmissions over."""
        for handle in self._handles.values():
            handle.propagate()
