"""Errors of a simulated inertial sensor.

The model is the usual one of inertial navigation (IEEE Std 952, annex C; Woodman, "An introduction
to inertial navigation", 2007): white noise of a given density, and a bias that is drawn when the
sensor is switched on and walks at random from then on. The orientation that the sensor computes has
a tilt error that wanders slowly (first order Gauss-Markov), and a heading that drifts with the
gyroscope, since nothing corrects it.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, fields
from operator import length_hint
from typing import Any, Iterator, List, Tuple

import numpy as np

from telex_control.common.params import require_range
from telex_control.common.stateful import Stateful

Vector = Tuple[float, float, float]
Covariance = Tuple[float, ...]

_MOST = 1e3
"""Of each density, bias and error: beyond what any sensor has, and its square is a number."""
_EXACT = 1e-9
"""Least variance that is told: 0 would mean "not known"."""
_AT_ONCE = 1024
"""Numbers that are drawn together; one by one they would cost several times as much."""
_TELL_EVERY = 0.1
"""Time between two computations of the covariances (s)."""


@dataclass(frozen=True)
class ImuNoise:
    """How good an inertial sensor is; everything 0 is an exact one.

    Attributes
    ----------
    gyroscope_noise_density : float
        White noise of the angular velocity (rad/s/sqrt(Hz)).
    gyroscope_turn_on_bias : float
        Standard deviation of the bias at the start (rad/s).
    gyroscope_bias_random_walk : float
        Of that bias from then on (rad/s^2/sqrt(Hz)).
    accelerometer_noise_density : float
        White noise of the acceleration (m/s^2/sqrt(Hz)).
    accelerometer_turn_on_bias : float
        Standard deviation of the bias at the start (m/s^2).
    accelerometer_bias_random_walk : float
        Of that bias from then on (m/s^3/sqrt(Hz)).
    tilt_error : float
        Standard deviation of the orientation's error about each horizontal axis (rad).
    tilt_correlation_time : float
        How long that error keeps its value (s).
    seed : int
        The same seed gives the same errors.
    """

    gyroscope_noise_density: float = 0.0
    gyroscope_turn_on_bias: float = 0.0
    gyroscope_bias_random_walk: float = 0.0
    accelerometer_noise_density: float = 0.0
    accelerometer_turn_on_bias: float = 0.0
    accelerometer_bias_random_walk: float = 0.0
    tilt_error: float = 0.0
    tilt_correlation_time: float = 10.0
    seed: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.name not in ("seed", "tilt_correlation_time"):
                require_range(self, field.name, 0.0, _MOST)
        require_range(self, "tilt_correlation_time", above=0.0)


class ImuErrors(Stateful):
    """Draws the errors of one sensor, reading by reading.

    Parameters
    ----------
    name : str
        Of the sensor, and of its robot: two with the same seed differ in their errors.
    """

    SAVED = (
        "_heading",
        "_heading_bias",
        "_heading_variance",
        "_kept",
        "_period",
        "_spread",
        "_tilt",
        "_told",
        "_until_told",
    )
    SAVED_PARTS = ("_accelerometer", "_gyroscope", "_normal")

    def __init__(self, noise: ImuNoise, name: str) -> None:
        self._noise = noise
        self._name = name
        self.restart()

    def restart(self) -> None:
        """Switch the sensor on anew, with the same errors as the last time."""
        noise = self._noise
        seed = zlib.crc32(f"{noise.seed} {self._name}".encode())
        self._normal = normal = NormalNumbers(seed)
        self._gyroscope = _Axes(
            normal,
            noise.gyroscope_noise_density,
            noise.gyroscope_turn_on_bias,
            noise.gyroscope_bias_random_walk,
        )
        self._accelerometer = _Axes(
            normal,
            noise.accelerometer_noise_density,
            noise.accelerometer_turn_on_bias,
            noise.accelerometer_bias_random_walk,
        )
        self._tilt = [noise.tilt_error * next(normal) for _ in range(2)]
        self._heading = 0.0
        self._heading_variance = 0.0
        # Of heading and bias together: a bias drives the heading further and further away.
        self._heading_bias = 0.0
        # Of the tilt: what is left of it after `_period`, and what is drawn anew.
        self._period, self._kept, self._spread = 0.0, 1.0, 0.0
        self._until_told = 0.0
        self._told = self._computed_covariances(0.0)

    def gyroscope(self, period: float) -> Vector:
        """Error of the angular velocity in the sensor's axes (rad/s), after `period` (s)."""
        return self._gyroscope.draw(period)

    def accelerometer(self, period: float) -> Vector:
        """Error of the acceleration in the sensor's axes (m/s^2), after `period` (s)."""
        return self._accelerometer.draw(period)

    def orientation(self, heading_rate: float, period: float) -> Vector:
        """Error of the orientation as angles about the world's axes (rad).

        Those about x and y are small; the one about z grows, and is given within -pi and pi.

        Parameters
        ----------
        heading_rate : float
            The gyroscope's error about the vertical in this reading (rad/s).
        period : float
            Time since the last reading (s).
        """
        noise, gyroscope = self._noise, self._gyroscope
        self._heading = math.remainder(self._heading + heading_rate * period, math.tau)
        self._heading_variance += (
            2.0 * self._heading_bias + noise.gyroscope_noise_density**2
        ) * period
        self._heading_bias += gyroscope.bias_variance * period
        if noise.tilt_error > 0.0:
            if period != self._period:
                self._period = period
                self._kept = math.exp(-period / noise.tilt_correlation_time)
                self._spread = noise.tilt_error * math.sqrt(1.0 - self._kept * self._kept)
            kept, spread, normal = self._kept, self._spread, self._normal
            x, y = self._tilt
            self._tilt = [kept * x + spread * next(normal), kept * y + spread * next(normal)]
        return self._tilt[0], self._tilt[1], self._heading

    def covariances(self, period: float) -> Tuple[Covariance, Covariance, Covariance]:
        """Of orientation (rad^2), angular velocity and acceleration, when read every `period` s."""
        self._until_told -= period
        if self._until_told <= 0.0:
            self._until_told = _TELL_EVERY if period > 0.0 else 0.0
            self._told = self._computed_covariances(period)
        return self._told

    def _computed_covariances(self, period: float) -> Tuple[Covariance, Covariance, Covariance]:
        tilt = self._noise.tilt_error**2
        return (
            _diagonal(tilt, tilt, self._heading_variance),
            _diagonal(*(self._gyroscope.variance(period),) * 3),
            _diagonal(*(self._accelerometer.variance(period),) * 3),
        )


class _Axes(Stateful):
    """White noise and bias of three axes."""

    SAVED = ("_bias", "bias_variance")

    def __init__(
        self, normal: Iterator[float], density: float, turn_on_bias: float, random_walk: float
    ) -> None:
        self._normal = normal
        self._density = density
        self._random_walk = random_walk
        self._bias: List[float] = [turn_on_bias * next(normal) for _ in range(3)]
        self.bias_variance = turn_on_bias**2
        self._exact = density == random_walk == 0.0

    def draw(self, period: float) -> Vector:
        """Move the bias on by `period` (s), and return it with noise on top."""
        bias = self._bias
        if self._exact or period <= 0.0:
            return bias[0], bias[1], bias[2]
        normal, root = self._normal, math.sqrt(period)
        white, walk = self._density / root, self._random_walk * root
        self.bias_variance += walk * walk
        bias[0] += walk * next(normal)
        bias[1] += walk * next(normal)
        bias[2] += walk * next(normal)
        return (
            bias[0] + white * next(normal),
            bias[1] + white * next(normal),
            bias[2] + white * next(normal),
        )

    def variance(self, period: float) -> float:
        """Of one reading, of noise and bias together."""
        white = self._density**2 / period if period > 0.0 else 0.0
        return white + self.bias_variance


class NormalNumbers(Stateful):
    """Normally distributed numbers, of mean 0 and variance 1, without end."""

    def __init__(self, seed: int) -> None:
        # RandomState, because its sequence is the same in every version of numpy.
        self._source = np.random.RandomState(seed)
        self._draw()

    def _draw(self) -> None:
        self._begin = self._source.get_state()
        self._numbers = iter(self._source.standard_normal(_AT_ONCE).tolist())

    def __iter__(self) -> Iterator[float]:
        return self

    def __next__(self) -> float:
        for number in self._numbers:
            return number
        self._draw()
        return next(self._numbers)

    def save_state(self) -> Any:
        """Return where it is in its sequence."""
        return self._begin, length_hint(self._numbers)

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Go back to a place in its sequence."""
        begin, left = saved
        self._source.set_state(begin)
        self._draw()
        for _ in range(_AT_ONCE - left):
            next(self._numbers)


def _diagonal(*variances: float) -> Covariance:
    x, y, z = (max(_EXACT, each) for each in variances)
    return (x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z)
