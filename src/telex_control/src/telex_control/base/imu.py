"""An inertial sensor as a robot's base sees it: in its axes, and without the gyroscope's bias."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from ..common.geometry.quaternions import (
    UPRIGHT,
    Rows,
    Vector3,
    product,
    quaternion_from_rpy,
    rotation_rows,
    transform_by_rows,
)
from ..common.params import Declared, number, parameter
from ..common.stateful import Stateful
from ..hardware.hardware_interface import ImuSensorHandle
from ..kinematics.urdf_tree import FIXED, KinematicsError, UrdfTree
from ..urdf.model import Robot

_ZERO: Vector3 = (0.0, 0.0, 0.0)

_AVERAGING = 0.5
"""Time constant (s) of the mean turn rate that tells rest from a slow turn."""
_CREDIBLE = 4.0
"""Standard deviations by which that mean may differ from the known bias; with 3, noise alone would
be taken for a turn every few minutes."""
_SETS_IN = 0.25
"""How long (s) a turn may take to be noticed; see `BaseImu`."""
_DOUBT_TIME = 240.0
"""How long (s) a turn rate has to last until it may as well be a bias that nobody knew."""


@dataclass(frozen=True)
class BaseImuConfig(Declared):
    """The sensor, and what is known of its gyroscope."""

    name: str = parameter("imu", "Of the sensor; empty for none.")
    timeout: float = number(
        0.1, "Time without a reading after which the sensor counts as gone (s).", above=0.0
    )
    noise_density: float = number(
        2.5e-4, "White noise of the gyroscope (rad/s/sqrt(Hz)).", above=0.0
    )
    turn_on_bias: float = number(
        5.0e-3, "Standard deviation of its bias before it was ever seen at rest (rad/s).", 0.0
    )
    bias_random_walk: float = number(2.0e-5, "Of the bias (rad/s^2/sqrt(Hz)).", 0.0)
    settling_time: float = number(
        0.3, "How long drives and robot must stand before it counts as at rest (s).", 0.0
    )
    still_rate: float = number(
        0.05,
        "Largest turn rate of a robot at rest, noise and unknown bias included (rad/s);"
        " faster, it is moved by something else. What is slower counts as a turn too as"
        " soon as it cannot be noise or bias.",
        0.0,
    )


class BaseImu(Stateful):
    """Reads an inertial sensor, and learns the bias of its gyroscope while the robot rests.

    Standing drives are not yet rest: the robot may slide, sink, or be lifted by its flippers.
    Learnt is what agrees with what is known already (an innovation gate, as in a Kalman filter);
    all else is a turn, and what was learnt while it set in is taken back. The longer it lasts, the
    less sure the bias is, so that one that has really changed is accepted in the end.

    Parameters
    ----------
    handle : ImuSensorHandle
        Whoever fills it puts in a new tuple with each reading; so it shows when readings cease.
    mount : tuple of 3 Vector3
        Rotation matrix from the sensor's axes to the base's, row by row.

    Attributes
    ----------
    rates : Vector3 or None
        Angular velocity of the base in its axes (rad/s), without bias; 0 at rest, so that noise
        does not turn a standing robot in its own eyes. None while there are no readings.
    bias : Vector
        Bias of the gyroscope in the base's axes (rad/s), as far as it is known.
    bias_variance : float
        Of each rate's bias (rad^2/s^2).
    at_rest : bool
    """

    SAVED = (
        "_age",
        "_before",
        "_mean",
        "_mean_variance",
        "_next",
        "_reading",
        "_still",
        "_until_next",
        "at_rest",
        "bias",
        "bias_variance",
        "rates",
    )

    def __init__(self, handle: ImuSensorHandle, mount: Rows, config: BaseImuConfig) -> None:
        self._handle = handle
        self._mount = mount
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget everything: the sensor was switched on anew."""
        self.bias: Vector3 = _ZERO
        self.bias_variance = self._config.turn_on_bias**2
        self._begin_to_learn()
        self.restart()

    def restart(self) -> None:
        """Forget when the last reading came, but not the bias."""
        self.rates: Optional[Vector3] = None
        self.at_rest = False
        self._reading: Optional[Tuple[float, ...]] = None
        self._age = 0.0
        self._stir()

    def _stir(self) -> None:
        """Forget how long the robot has been still."""
        self._still = 0.0
        self._mean: Vector3 = _ZERO
        self._mean_variance = 0.0

    def _begin_to_learn(self) -> None:
        """Keep what is known, to return to it if this turns out to be no rest."""
        # What was known of the bias `_SETS_IN` ago at least, and what to keep for later.
        self._before = self._next = (self.bias, self.bias_variance)
        self._until_next = _SETS_IN

    def update(self, standing: bool, period: float) -> None:
        """Look at the sensor, `period` after the last time (s).

        Parameters
        ----------
        standing : bool
            Whether the robot's drives stand.
        """
        config = self._config
        self.bias_variance += config.bias_random_walk**2 * period
        reading = self._handle.angular_velocity
        # A reading that is not a number is as good as none.
        fresh = reading is not None and reading is not self._reading and _is_finite(reading)
        self._age = 0.0 if fresh else self._age + period
        if not standing:
            self._stir()
        if not fresh:
            if self._age > config.timeout:
                self.rates = None
                self.at_rest = False
            return
        assert reading is not None
        self._reading = reading
        bias = self.bias
        rates = (reading[0] - bias[0], reading[1] - bias[1], reading[2] - bias[2])
        rested = self.at_rest
        still = max(map(abs, rates)) <= config.still_rate
        self.at_rest = standing and still and self._is_rest(reading, period)
        if self.at_rest:
            if not rested:
                self._begin_to_learn()
            self._learn(rates, period)
            self.rates = _ZERO
            return
        if rested and standing:
            self.bias, self.bias_variance = self._before
        if not still:
            self._stir()
        self.rates = transform_by_rows(self._mount, rates)

    def _is_rest(self, reading: Vector3, period: float) -> bool:
        """Whether nothing but noise and bias is measured, while the drives stand."""
        config = self._config
        self._still += period
        if self._still < config.settling_time or period <= 0.0:
            return False
        white = config.noise_density**2 / period
        # A plain mean to begin with, and an exponential one later.
        share = period / min(self._still - config.settling_time + period, period + _AVERAGING)
        mean, rest = self._mean, 1.0 - share
        self._mean = mean = (
            rest * mean[0] + share * reading[0],
            rest * mean[1] + share * reading[1],
            rest * mean[2] + share * reading[2],
        )
        self._mean_variance = rest**2 * self._mean_variance + share**2 * white
        bias = self.bias
        innovation = max(abs(mean[0] - bias[0]), abs(mean[1] - bias[1]), abs(mean[2] - bias[2]))
        if innovation**2 <= _CREDIBLE**2 * (self.bias_variance + self._mean_variance):
            return True
        sure, unsure = math.sqrt(self.bias_variance), config.turn_on_bias
        if sure < unsure:
            self.bias_variance = min(unsure, sure + unsure * period / _DOUBT_TIME) ** 2
        return False

    def _learn(self, rates: Vector3, period: float) -> None:
        """Take what is measured at rest for the bias, as far as it is better known than before."""
        self._until_next -= period
        if self._until_next <= 0.0:
            self._before, self._next = self._next, (self.bias, self.bias_variance)
            self._until_next = _SETS_IN
        white = self._config.noise_density**2 / period
        gain = self.bias_variance / (self.bias_variance + white)
        self.bias_variance *= 1.0 - gain
        bias = self.bias
        self.bias = (
            bias[0] + gain * rates[0],
            bias[1] + gain * rates[1],
            bias[2] + gain * rates[2],
        )

    def up(self) -> Optional[Vector3]:
        """Direction away from gravity in the axes of the base; None while it is not known."""
        if self.rates is None:
            return None
        orientation = self._handle.orientation
        if orientation is None or not _is_finite(orientation):
            return None
        # The world's z axis in the sensor's axes: the last row of its rotation matrix.
        return transform_by_rows(self._mount, rotation_rows(orientation)[2])


def sensor_mount(robot: Robot, base: str, frame: str) -> Rows:
    """Rotation matrix from the axes of a sensor to those of the base, row by row.

    Parameters
    ----------
    robot : Robot
        See `telex_control.urdf.joints.parse_urdf`.
    base : str
        Link; if there is none of this name, the root link counts.
    frame : str
        The sensor's link.

    Raises
    ------
    KinematicsError
        The sensor is not fixed to the base.
    """
    tree = UrdfTree(robot)
    rotation = UPRIGHT
    for joint in tree.path(base if base in tree.inertials else tree.root, frame):
        if joint.kind != FIXED:
            raise KinematicsError(
                f"link '{frame}' moves against the base, by joint '{joint.name}'; the sensor must "
                "be fixed to it"
            )
        rotation = product(rotation, quaternion_from_rpy(joint.origin.rpy))
    return rotation_rows(rotation)


def _is_finite(values: Tuple[float, ...]) -> bool:
    return math.isfinite(sum(values))
