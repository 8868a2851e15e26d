"""Dead reckoning of a tracked robot: the way by its belts, the attitude by its inertial sensor.

Belts say how far a robot came, as long as they do not slip along; they do not say how far it
turned, because turning is nothing but slip. The gyroscope does, and gravity tells which way is up,
so that the way up a ramp counts as height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from ..common.geometry.quaternions import UPRIGHT, Quaternion, Vector3, product, rotate, yaw_of
from ..common.params import Declared, number
from .imu import BaseImu
from .odometry import WheelOdometry

_TILT_TIME = 0.1
"""Time constant (s) with which the measured vertical corrects the integrated attitude."""
_LEVEL_PERIOD = 0.02
"""Time between two such corrections (s): the vertical does not wander faster."""
_AHEAD = (1.0, 0.0, 0.0)
_NO_TURN = (0.0, 0.0, 0.0)
_X, _Y, _YAW, _SCALE, _BIAS = range(5)


@dataclass(frozen=True)
class OdometryErrors(Declared):
    """How far the odometry may be trusted; all are standard deviations."""

    way_scale: float = number(
        0.03,
        "Share of the way by which the belts are wrong all along: radius, sinkage, steady slip.",
        0.0,
    )
    way_noise: float = number(
        0.01, "Of what chance adds over 1 m; it grows with the root of the way (m).", 0.0
    )
    turn_offset: float = number(
        0.06,
        "How far the robot shifts in a turn of 1 rad, because it does not turn about "
        "its middle; it grows with the root of the angle (m).",
        0.0,
    )
    turn_scale: float = number(
        0.5, "Share of a turn by which the belts alone are wrong: without an inertial sensor.", 0.0
    )
    tilt: float = number(0.005, "Of the measured roll and pitch (rad).", 0.0)


class TrackedOdometry(WheelOdometry):
    """Pose of the base since the start, with its covariance.

    Heading and place start at 0, roll and pitch where gravity says. The covariance is that of a
    Kalman filter without measurements: of x, y and yaw, together with the scale of the way and the
    gyroscope's bias, whose errors last and so make the pose's grow with the way and with time.

    Parameters
    ----------
    window : int
        Number of cycles over which the reported velocity is averaged.
    rate_noise : float
        White noise of the gyroscope (rad/s/sqrt(Hz)).

    Attributes
    ----------
    position : Vector3
        (m)
    orientation : tuple of 4 floats
        Quaternion (x, y, z, w).
    linear, angular : float
        See `WheelOdometry`.
    """

    SAVED = (
        "_ahead",
        "_blind_turn",
        "_covariance",
        "_height_variance",
        "_moved",
        "_since_level",
        "_time",
        "_time_turning",
        "_turn",
        "_way",
        "orientation",
        "position",
    )

    def __init__(
        self,
        window: int,
        errors: OdometryErrors,
        imu: Optional[BaseImu],
        rate_noise: float = 0.0,
    ) -> None:
        super().__init__(window)
        self._errors = errors
        self._imu = imu
        self._rate_noise = rate_noise
        self.set_geometry(1.0, 1.0, 1.0)
        self.reset()

    def reset(self) -> None:
        """Start again at the origin, as certain as at the first time."""
        self.position: Vector3 = (0.0, 0.0, 0.0)
        self.orientation = UPRIGHT
        self._ahead = _AHEAD
        self._covariance = np.zeros((5, 5))
        self._covariance[_SCALE, _SCALE] = self._errors.way_scale**2
        self._height_variance = 0.0
        self._forget_increments()
        self.restart()

    def restart(self) -> None:
        """Forget the last belt positions but keep the pose."""
        super().restart()
        self._since_level = 0.0

    def _forget_increments(self) -> None:
        self._moved = [0.0, 0.0]
        self._way = self._turn = self._blind_turn = self._time = self._time_turning = 0.0

    @property
    def heading(self) -> float:
        """Yaw (rad)."""
        return yaw_of(self.orientation)

    def update(self, left: float, right: float, period: float) -> None:
        """Advance by one cycle.

        Parameters
        ----------
        left, right : float
            Belt positions as angles of their wheels (rad).
        period : float
            Time since the last cycle (s).
        """
        covered = self._covered(left, right, period)
        if covered is None:
            self._correct_tilt(1.0)
            return
        way, turn = covered
        rates = None if self._imu is None else self._imu.rates
        if rates is None:
            self._advance(way, (0.0, 0.0, turn), period)
            self._blind_turn += abs(turn)
        else:
            turn = rates[2] * period
            self._advance(way, (rates[0] * period, rates[1] * period, turn), period)
            self._since_level += period
            if self._since_level >= _LEVEL_PERIOD:
                self._correct_tilt(min(1.0, self._since_level / _TILT_TIME))
                self._since_level = 0.0
            if self._imu is not None and not self._imu.at_rest:
                self._time_turning += period
        self.linear, self.angular = self._mean.add(way / period, turn / period)

    def update_open_loop(self, linear: float, angular: float, period: float) -> None:
        """Advance by one cycle of commanded velocities (m/s, rad/s), as if they were obeyed."""
        self.linear, self.angular = linear, angular
        turn = angular * period
        self._advance(linear * period, (0.0, 0.0, turn), period)
        self._blind_turn += abs(turn)

    def _advance(self, way: float, turn: Vector3, period: float) -> None:
        """Turn by the small rotation `turn` in the base's axes, and go `way` along its x axis."""
        self._time += period
        if way == 0.0 and turn == _NO_TURN:
            return
        first = self._ahead
        self.orientation = _rotated(self.orientation, turn)
        second = self._ahead = rotate(self.orientation, _AHEAD)
        half = 0.5 * way
        dx, dy = half * (first[0] + second[0]), half * (first[1] + second[1])
        x, y, z = self.position
        self.position = (x + dx, y + dy, z + half * (first[2] + second[2]))
        self._moved[0] += dx
        self._moved[1] += dy
        self._way += abs(way)
        self._turn += abs(turn[2])

    def _correct_tilt(self, share: float) -> None:
        """Turn the attitude, not the heading, by a `share` of its error against the vertical."""
        up = None if self._imu is None else self._imu.up()
        if up is None:
            return
        # Where the measured vertical points in the odometry's axes; it ought to point up.
        gravity = rotate(self.orientation, up)
        axis = (gravity[1], -gravity[0], 0.0)
        sine = math.hypot(axis[0], axis[1])
        angle = share * math.atan2(sine, gravity[2])
        if sine < 1e-12:
            return
        scale = math.sin(0.5 * angle) / sine
        a, b, c = axis[0] * scale, axis[1] * scale, math.cos(0.5 * angle)
        self.orientation = product((a, b, 0.0, c), self.orientation)
        self._ahead = rotate(self.orientation, _AHEAD)

    def propagate(self) -> None:
        """Let the covariance grow by what has been covered since the last call.

        To be called often enough that the robot goes almost straight in between; the result does
        not depend on how often otherwise.
        """
        if self._time <= 0.0:
            return
        errors, p = self._errors, self._covariance
        dx, dy = self._moved
        step = np.eye(5)
        step[_X, _YAW], step[_Y, _YAW] = -dy, dx
        step[_X, _SCALE], step[_Y, _SCALE] = dx, dy
        if self._imu is not None:
            if self._imu.bias_variance < p[_BIAS, _BIAS]:
                # Learnt anew: what is wrong with it now is not what turned the heading before.
                p[_BIAS, :] = p[:, _BIAS] = 0.0
            p[_BIAS, _BIAS] = self._imu.bias_variance
            step[_YAW, _BIAS] = -self._time_turning
        p = step @ p @ step.T
        along = errors.way_noise**2 * self._way
        length = math.hypot(dx, dy)
        if length > 0.0:
            c, s = dx / length, dy / length
            p[_X, _X] += along * c * c
            p[_X, _Y] += along * c * s
            p[_Y, _X] += along * c * s
            p[_Y, _Y] += along * s * s
        shift = errors.turn_offset**2 * self._turn
        p[_X, _X] += shift
        p[_Y, _Y] += shift
        p[_YAW, _YAW] += self._rate_noise**2 * self._time_turning
        # The belts' error in turning is always the same: its deviations add up, not its squares.
        blind = errors.turn_scale * self._blind_turn
        p[_YAW, _YAW] = (math.sqrt(p[_YAW, _YAW]) + blind) ** 2
        height = math.sqrt(self._height_variance) + errors.tilt * self._way
        self._height_variance = height * height
        self._covariance = p
        self._forget_increments()

    def pose_covariance(self) -> List[float]:
        """Of x, y, z and the rotations about them, 36 numbers; call `propagate` before."""
        p, tilt = self._covariance, self._errors.tilt**2
        matrix = [0.0] * 36
        for row, first in ((0, _X), (1, _Y), (5, _YAW)):
            for column, second in ((0, _X), (1, _Y), (5, _YAW)):
                matrix[6 * row + column] = float(p[first, second])
        matrix[14] = self._height_variance + float(p[_SCALE, _SCALE]) * self.position[2] ** 2
        matrix[21] = matrix[28] = tilt
        return matrix

    def twist_covariance(self) -> List[float]:
        """Of the velocity along the base's axes and about them, 36 numbers."""
        errors = self._errors
        rate = abs(self.angular)
        matrix = [0.0] * 36
        sideways = (errors.turn_offset * rate) ** 2
        matrix[0] = (errors.way_scale * self.linear) ** 2 + sideways
        matrix[7] = sideways
        matrix[35] = (errors.turn_scale * rate) ** 2
        if self._imu is not None and self._imu.rates is not None:
            matrix[35] = self._imu.bias_variance
        return matrix


def _rotated(q: Quaternion, turn: Vector3) -> Quaternion:
    """Orientation after a small rotation (rad) about the body's own axes.

    It computes for itself, without sines: it runs in every cycle.
    """
    x, y, z, w = q
    a, b, c = 0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]
    square = a * a + b * b + c * c
    # sin(h)/h and cos(h) to fourth order: a turn within a cycle is small.
    share = 1.0 - square / 6.0
    a, b, c, d = a * share, b * share, c * share, 1.0 - 0.5 * square + square * square / 24.0
    x, y, z, w = (
        x * d + w * a + y * c - z * b,
        y * d + w * b + z * a - x * c,
        z * d + w * c + x * b - y * a,
        w * d - x * a - y * b - z * c,
    )
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * scale, y * scale, z * scale, w * scale
