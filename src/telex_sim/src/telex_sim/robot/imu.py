"""A simulated inertial sensor."""

from __future__ import annotations

import math
from typing import Optional, Tuple

import pybullet

from telex_control.common.geometry.quaternions import IDENTITY, Pose, Quaternion, product
from telex_control.common.stateful import Stateful
from telex_control.hardware.hardware_interface import ImuSensorHandle

from ..engine.world import GRAVITY, Body, Vector
from .imu_noise import ImuErrors, ImuNoise

_EXACT = (1e-9, 0.0, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 1e-9)


class Imu(Stateful):
    """Measures the motion of one link, in the axes of its frame.

    The acceleration is the mean since the last reading, and proper (REP 145): at rest it is the
    gravity's opposite.

    Parameters
    ----------
    name : str
        Of the sensor.
    noise : ImuNoise, optional
        Its errors, the same after every `attach`. Without, it is exact, and its covariances are as
        good as 0; 0 itself would mean "unknown".
    robot : str
        Namespace of the robot: the sensors of two robots differ in their errors.

    Attributes
    ----------
    errors : ImuErrors or None
        What is added to the truth; None where it is exact.
    bias : float
        Of a gyroscope that has failed, about the vertical (rad/s); its heading drifts away. 0: it
        works, and its heading is right again.
    """

    SAVED = ("_drift", "_velocity")
    SAVED_PARTS = ("errors", "handle")

    def __init__(
        self, name: str, link: str, noise: Optional[ImuNoise] = None, robot: str = ""
    ) -> None:
        self.handle = ImuSensorHandle(name, link)
        self.errors = None if noise is None else ImuErrors(noise, f"{robot}/{name}")
        self.handle.orientation_covariance = _EXACT
        self.handle.angular_velocity_covariance = _EXACT
        self.handle.linear_acceleration_covariance = _EXACT
        self._body: Optional[Body] = None
        self._link = -1
        self._offset: Pose = IDENTITY
        self._velocity: Optional[Vector] = None
        self.bias = self._drift = 0.0

    def attach(self, body: Body) -> None:
        """Measure the link of `body`, from rest."""
        self._body = body
        self._link, position, orientation = body.place(self.handle.frame_id)
        self._offset = (position, orientation)
        self._velocity = None
        self._drift = 0.0
        if self.errors is not None:
            self.errors.restart()
        self.read(0.0)

    def read(self, period: float) -> None:
        """Fill the handle; `period` is the time since the last reading (s)."""
        body = self._body
        assert body is not None
        orientation, velocity, turning = self._motion(body)
        last, self._velocity = self._velocity, velocity
        # What is felt: the motion's acceleration less gravity's, in the world's axes.
        felt = [0.0, 0.0, GRAVITY]
        if last is not None and period > 0.0:
            felt = [
                (now - before) / period + rest for now, before, rest in zip(velocity, last, felt)
            ]
        m = pybullet.getMatrixFromQuaternion(orientation)
        handle = self.handle
        handle.orientation = orientation
        handle.angular_velocity = _into(m, turning)
        handle.linear_acceleration = _into(m, (felt[0], felt[1], felt[2]))
        if self.errors is not None:
            self._add(self.errors, m, period)
        if self.bias or self._drift:
            self._lead_astray(m, period)

    def _lead_astray(self, m: Tuple[float, ...], period: float) -> None:
        """Add the bias of a gyroscope that has failed; `m` is the sensor's rotation matrix."""
        handle, bias = self.handle, self.bias
        self._drift = math.remainder(self._drift + bias * period, math.tau) if bias else 0.0
        astray = (bias * m[6], bias * m[7], bias * m[8])
        handle.angular_velocity = _sum(handle.angular_velocity, astray)
        handle.orientation = _turned(handle.orientation, (0.0, 0.0), self._drift)

    def _add(self, errors: ImuErrors, m: Tuple[float, ...], period: float) -> None:
        """Add the sensor's errors to what it measures; `m` is its rotation matrix."""
        handle = self.handle
        turning = errors.gyroscope(period)
        upright = m[6] * turning[0] + m[7] * turning[1] + m[8] * turning[2]
        handle.angular_velocity = _sum(handle.angular_velocity, turning)
        handle.linear_acceleration = _sum(handle.linear_acceleration, errors.accelerometer(period))
        tilt_x, tilt_y, heading = errors.orientation(upright, period)
        handle.orientation = _turned(handle.orientation, (tilt_x, tilt_y), heading)
        (
            handle.orientation_covariance,
            handle.angular_velocity_covariance,
            handle.linear_acceleration_covariance,
        ) = errors.covariances(period)

    def _motion(self, body: Body) -> Tuple[Quaternion, Vector, Vector]:
        """Orientation, and linear and angular velocity of the link's frame, in the world."""
        if self._link < 0:
            center, turned = pybullet.getBasePositionAndOrientation(
                body.uid, physicsClientId=body.client
            )
            velocity, turning = pybullet.getBaseVelocity(body.uid, physicsClientId=body.client)
        else:
            state = pybullet.getLinkState(
                body.uid,
                self._link,
                computeLinkVelocity=1,
                computeForwardKinematics=1,
                physicsClientId=body.client,
            )
            center, turned, velocity, turning = state[0], state[1], state[6], state[7]
        origin, orientation = pybullet.multiplyTransforms(center, turned, *self._offset)
        x, y, z = (a - b for a, b in zip(origin, center))
        p, q, r = turning
        u, v, w = velocity
        # PyBullet gives the velocity of the centre of mass.
        return orientation, (u + q * z - r * y, v + r * x - p * z, w + p * y - q * x), turning


def _into(m: Tuple[float, ...], vector: Vector) -> Vector:
    """A vector of the world in the axes of a frame, whose rotation matrix is `m`, row by row."""
    x, y, z = vector
    return (
        m[0] * x + m[3] * y + m[6] * z,
        m[1] * x + m[4] * y + m[7] * z,
        m[2] * x + m[5] * y + m[8] * z,
    )


def _sum(first: Optional[Vector], second: Vector) -> Vector:
    assert first is not None
    return first[0] + second[0], first[1] + second[1], first[2] + second[2]


def _turned(
    orientation: Optional[Quaternion], tilt: Tuple[float, float], heading: float
) -> Quaternion:
    """Orientation after rotations about the world's axes: x and y at once, and then z (rad)."""
    assert orientation is not None
    angle = math.hypot(*tilt)
    share = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    a, b, w = share * tilt[0], share * tilt[1], math.cos(0.5 * angle)
    s, c = math.sin(0.5 * heading), math.cos(0.5 * heading)
    # The heading's (0, 0, s, c) times the tilt's (a, b, 0, w).
    return product((c * a - s * b, c * b + s * a, s * w, c * w), orientation)
