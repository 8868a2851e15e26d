"""``telex_controllers/TrackedDriveController``: a diff drive on tracks, that turns as told."""

from __future__ import annotations

import math
from typing import Any, List, Optional, Sequence, Tuple

from ..base.braking import BrakingConfig, BrakingLimit
from ..base.imu import BaseImu, BaseImuConfig, sensor_mount
from ..base.tracked_odometry import OdometryErrors, TrackedOdometry
from ..base.yaw_rate_loop import YawRateLoop, YawRateLoopConfig
from ..common.params import read_config
from ..hardware.hardware_interface import (
    HardwareInterfaceError,
    ImuSensorHandle,
    ImuSensorInterface,
    JointHandle,
    RobotHW,
)
from ..kinematics.urdf_tree import KinematicsError
from ..laws.gravity import GravityError, gravity_of, joint_states
from ..manager.controller import ControllerInitError
from ..ros.node_handle import NodeHandle
from ..urdf.joints import UrdfError, parse_urdf
from .diff_drive_controller import DiffDriveController

_STANDS = 1e-3
"""Belt speed (m/s) below which a belt stands."""


class TrackedDriveController(DiffDriveController):
    """Follows ``cmd_vel`` with two sides of belts, in turns too, by the robot's inertial sensor.

    All topics and parameters are those of `DiffDriveController`; ``wheel_separation_multiplier``
    is how much faster than wheels the belts turn to begin with. Without the sensor, or while it
    is silent, that factor alone has to do; a warning says so. The odometry takes its way from the
    belts and its attitude from the sensor; its covariance grows, and the diagonals of the
    parameters are added to it.

    Parameters beside those: ``max_belt_speed`` (m/s, required), ``imu`` (see `BaseImuConfig`),
    ``yaw_rate_loop`` (see `YawRateLoopConfig`), ``odometry_errors`` (see `OdometryErrors`),
    ``braking`` (see `BrakingConfig`; without it, the limits of ``linear/x`` hold everywhere).

    Attributes
    ----------
    imu : BaseImu, optional
        The robot's inertial sensor, with the bias that was learnt.
    yaw_loop : YawRateLoop
        What adapts the turn of the belts.
    """

    parameters = DiffDriveController.parameters | {
        "braking",
        "imu",
        "max_belt_speed",
        "odometry_errors",
        "yaw_rate_loop",
    }
    SAVED = ("_sensor_lost",)
    SAVED_PARTS = ("_braking_limit", "imu", "yaw_loop")

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the belts, find the sensor and open the topics."""
        self._sensor_config: BaseImuConfig = _config(BaseImuConfig, node, "imu")
        self._errors: OdometryErrors = _config(OdometryErrors, node, "odometry_errors")
        loop: YawRateLoopConfig = _config(YawRateLoopConfig, node, "yaw_rate_loop")
        factor = node.positive_param("wheel_separation_multiplier", 1.0)
        if loop.max_factor < factor:
            raise ControllerInitError(
                f"parameter {node.resolve('yaw_rate_loop')}/max_factor is {loop.max_factor}; it "
                f"must not be below {node.resolve('wheel_separation_multiplier')}, {factor}"
            )
        self.yaw_loop = YawRateLoop(loop, node.positive_param("max_belt_speed"))
        self.imu = self._find_sensor(hw, root, node)
        self._sensor_lost = False
        super().init(hw, root, node)
        self._braking_limit = self._make_braking_limit(hw, root, node)

    def _make_braking_limit(
        self, hw: RobotHW, root: NodeHandle, node: NodeHandle
    ) -> Optional[BrakingLimit]:
        if node.find_param("braking", None) is None:
            return None
        config: BrakingConfig = _config(BrakingConfig, node, "braking")
        try:
            gravity = gravity_of(hw, root)
            return BrakingLimit(
                config,
                parse_urdf(root.param("robot_description", str)),
                node.param("base_frame_id", str, "base_link"),
                self._nominal_radius,
                joint_states(hw),
                lambda joint: gravity.joint(joint).effort,
            )
        except (GravityError, KinematicsError, UrdfError) as error:
            raise ControllerInitError(
                f"{error}; {node.resolve('braking')} cannot be reckoned, and may be left out"
            ) from error

    def _find_sensor(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> Optional[BaseImu]:
        config = self._sensor_config
        if not config.name:
            return None
        try:
            handle: ImuSensorHandle = hw.get(ImuSensorInterface).get_handle(config.name)
        except HardwareInterfaceError:
            node.logger.warning(
                "%s: the robot has no inertial sensor '%s' (%s/name); turns are left to the "
                "fixed factor wheel_separation_multiplier, and depend on the ground",
                node.namespace,
                config.name,
                node.resolve("imu"),
            )
            return None
        base = node.param("base_frame_id", str, "base_link")
        try:
            robot = parse_urdf(root.param("robot_description", str))
            mount = sensor_mount(robot, base, handle.frame_id)
        except (KinematicsError, UrdfError) as error:
            raise ControllerInitError(
                f"{error}; {node.resolve('imu')}/name set to '' does without the sensor"
            ) from error
        return BaseImu(handle, mount, config)

    def _make_odometry(self, window: int) -> Any:
        """Odometry of the drive, with velocities averaged over `window` cycles."""
        return TrackedOdometry(window, self._errors, self.imu, self._sensor_config.noise_density)

    def starting(self, time: float) -> None:
        """Stand still; commands from before are forgotten."""
        self.yaw_loop.reset()
        if self.imu is not None:
            self.imu.restart()
        if self._braking_limit is not None:
            self._braking_limit.restart()
        super().starting(time)

    def reset(self, time: float) -> None:
        """Stand still, and start odometry and sensor again from nothing."""
        if self.imu is not None:
            self.imu.reset()
        super().reset(time)

    def _brake(self) -> None:
        super()._brake()
        self.yaw_loop.reset()

    def _measure(self, time: float, period: float) -> None:
        if self.imu is not None:
            self.imu.update(self._stands(), period)
            self._watch_sensor(self.imu)
        super()._measure(time, period)

    def _stands(self) -> bool:
        """Whether no belt runs, or is told to."""
        if self._linear[0] != 0.0 or self._angular[0] != 0.0:
            return False
        limit = _STANDS / max(self._left_radius, self._right_radius)
        return all(abs(each.command) + abs(each.state.velocity) < limit for each in self._wheels)

    def _watch_sensor(self, imu: BaseImu) -> None:
        """Say when the sensor falls silent, and when it is back."""
        lost = imu.rates is None
        if lost == self._sensor_lost:
            return
        self._sensor_lost = lost
        if lost:
            self._node.logger.warning(
                "%s: no reading of the inertial sensor '%s' for %g s; turns are left to the fixed "
                "factor wheel_separation_multiplier, and depend on the ground",
                self._node.namespace,
                self._sensor_config.name,
                self._sensor_config.timeout,
            )
        else:
            self._node.logger.info(
                "%s: the inertial sensor '%s' is back",
                self._node.namespace,
                self._sensor_config.name,
            )

    def _braking(self, time: float, period: float) -> float:
        if self._braking_limit is None:
            return math.inf
        now, before = self._linear
        return self._braking_limit.limit(
            time,
            now,
            (now - before) / period if period > 0.0 else 0.0,
            None if self.imu is None else self.imu.up(),
        )

    def _side_speeds(self, linear: float, angular: float, period: float) -> Tuple[float, float]:
        if linear == 0.0 and angular == 0.0:
            self.yaw_loop.reset()
            return 0.0, 0.0
        rates = None if self.imu is None else self.imu.rates
        left = _mean_velocity(self._left) * self._left_radius
        right = _mean_velocity(self._right) * self._right_radius
        return self.yaw_loop.update(
            linear,
            angular,
            None if rates is None else rates[2],
            0.5 * (right - left),
            (self._nominal_separation, self._separation),
            period,
        )

    def _publish(self, time: float) -> None:
        # Whether or not anybody listens: growth depends on the way in between.
        self._odometry.propagate()
        super()._publish(time)

    def _covariances(self) -> Tuple[Sequence[float], Sequence[float]]:
        odometry = self._odometry
        return (
            _sum(self._pose_covariance, odometry.pose_covariance()),
            _sum(self._twist_covariance, odometry.twist_covariance()),
        )


def _config(kind: Any, node: NodeHandle, key: str) -> Any:
    return read_config(kind, node.find_param(key, {}), node.resolve(key))


def _mean_velocity(belts: List[JointHandle]) -> float:
    total = 0.0
    for belt in belts:
        total += belt.state.velocity
    return total / len(belts)


def _sum(first: Sequence[float], second: Sequence[float]) -> List[float]:
    return [a + b for a, b in zip(first, second)]
