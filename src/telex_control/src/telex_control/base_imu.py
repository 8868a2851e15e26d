"""An inertial sensor as a robot's base sees it: in its axes, and without the gyroscope's bias."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple
from xml.etree import ElementTree

from .hardware_interface import ImuSensorHandle
from .kinematics.urdf_tree import FIXED, KinematicsError, Origin, UrdfTree
from .params import require_range

Vector = Tuple[float, float, float]
Matrix = Tuple[Vector, Vector, Vector]

_IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class BaseImuConfig:
    """The sensor, and what is known of its gyroscope.

    Attributes
    ----------
    name : str
        Of the sensor; empty for none.
    timeout : float
        Time without a reading after which the sensor counts as gone (s).
    noise_density : float
        White noise of the gyroscope (rad/s/sqrt(Hz)).
    turn_on_bias : float
        Standard deviation of its bias before it was ever seen at rest (rad/s).
    bias_random_walk : float
        Of the bias (rad/s^2/sqrt(Hz)).
    settling_time : float
        How long the drives must stand before the robot counts as at rest (s).
    still_rate : float
        Largest turn rate of a robot at rest, noise included (rad/s); faster, it is moved by
        something else.
    """

    name: str = "imu"
    timeout: float = 0.1
    noise_density: float = 2.5e-4
    turn_on_bias: float = 5.0e-3
    bias_random_walk: float = 2.0e-5
    settling_time: float = 0.3
    still_rate: float = 0.05

    def __post_init__(self) -> None:
        require_range(self, "timeout", above=0.0)
        require_range(self, "noise_density", above=0.0)
        for name in ("turn_on_bias", "bias_random_walk", "settling_time", "still_rate"):
            require_range(self, name, 0.0)


class BaseImu:
    """Reads an inertial sensor, and learns the bias of its gyroscope while the robot rests.

    Parameters
    ----------
    handle : ImuSensorHandle
        Whoever fills it puts in a new tuple with each reading; so it shows when readings cease.
    mount : tuple of 3 Vector
        Rotation matrix from the sensor's axes to the base's, row by row.
    config : BaseImuConfig

    Attributes
    ----------
    rates : Vector or None
        Angular velocity of the base in its axes (rad/s), without bias; 0 at rest, so that a
        standing robot does not turn in its own eyes. None while there are no readings.
    bias_variance : float
        Of each rate's bias (rad^2/s^2).
    at_rest : bool
    """

    def __init__(self, handle: ImuSensorHandle, mount: Matrix, config: BaseImuConfig) -> None:
        self._handle = handle
        self._mount = mount
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget everything: the sensor was switched on anew."""
        self._bias: Vector = (0.0, 0.0, 0.0)
        self.bias_variance = self._config.turn_on_bias**2
        self.restart()

    def restart(self) -> None:
        """Forget when the last reading came, but not the bias."""
        self.rates: Optional[Vector] = None
        self.at_rest = False
        self._reading: Optional[Tuple[float, ...]] = None
        self._age = 0.0
        self._standing = 0.0

    def update(self, standing: bool, period: float) -> None:
        """Look at the sensor, `period` after the last time (s).

        Parameters
        ----------
        standing : bool
            Whether the robot's drives stand.
        """
        config = self._config
        self._standing = self._standing + period if standing else 0.0
        self.bias_variance += config.bias_random_walk**2 * period
        reading = self._handle.angular_velocity
        # A reading that is not a number is as good as none.
        fresh = reading is not None and reading is not self._reading and _is_finite(reading)
        self._age = 0.0 if fresh else self._age + period
        if not fresh:
            if self._age > config.timeout:
                self.rates = None
                self.at_rest = False
            return
        assert reading is not None
        self._reading = reading
        bias = self._bias
        rates = (reading[0] - bias[0], reading[1] - bias[1], reading[2] - bias[2])
        self.at_rest = (
            self._standing >= config.settling_time and max(map(abs, rates)) <= config.still_rate
        )
        if self.at_rest:
            self._learn(rates, period)
            self.rates = (0.0, 0.0, 0.0)
        else:
            self.rates = _turned(self._mount, rates)

    def _learn(self, rates: Vector, period: float) -> None:
        """Take what is measured at rest for the bias, as far as it is better known than before."""
        if period <= 0.0:
            return
        white = self._config.noise_density**2 / period
        gain = self.bias_variance / (self.bias_variance + white)
        self.bias_variance *= 1.0 - gain
        bias = self._bias
        self._bias = (
            bias[0] + gain * rates[0],
            bias[1] + gain * rates[1],
            bias[2] + gain * rates[2],
        )

    def up(self) -> Optional[Vector]:
        """Direction away from gravity in the axes of the base; None while it is not known."""
        if self.rates is None:
            return None
        orientation = self._handle.orientation
        if orientation is None or not _is_finite(orientation):
            return None
        x, y, z, w = orientation
        # The world's z axis in the sensor's axes: the last row of its rotation matrix.
        up = (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y))
        return _turned(self._mount, up)


def sensor_mount(robot: ElementTree.Element, base: str, frame: str) -> Matrix:
    """Rotation matrix from the axes of a sensor to those of the base, row by row.

    Parameters
    ----------
    robot : Element
        ``<robot>`` of the URDF.
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
    rotation = _IDENTITY
    for joint in tree.path(base if base in tree.inertials else tree.root, frame):
        if joint.kind != FIXED:
            raise KinematicsError(
                f"link '{frame}' moves against the base, by joint '{joint.name}'; the sensor must "
                "be fixed to it"
            )
        rotation = _product(rotation, _matrix(joint.origin))
    return rotation


def _matrix(origin: Origin) -> Matrix:
    roll, pitch, yaw = origin.rpy
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _product(a: Matrix, b: Matrix) -> Matrix:
    columns = tuple(zip(*b))
    return tuple(  # type: ignore[return-value]
        tuple(sum(x * y for x, y in zip(row, column)) for column in columns) for row in a
    )


def _turned(m: Matrix, v: Vector) -> Vector:
    return (
        m[0][0] * v[0] + m[0][1] * v[1] + m[0][2] * v[2],
        m[1][0] * v[0] + m[1][1] * v[1] + m[1][2] * v[2],
        m[2][0] * v[0] + m[2][1] * v[1] + m[2][2] * v[2],
    )


def _is_finite(values: Tuple[float, ...]) -> bool:
    return math.isfinite(sum(values))
