"""``diff_drive_controller/DiffDriveController``: drives two sides of wheels or belts by a twist."""

from __future__ import annotations

import math
import time as wall
from typing import Any, List, NamedTuple, Tuple

from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from ..controller import Controller, ControllerInitError
from ..hardware_interface import JointHandle, RobotHW, VelocityJointInterface
from ..node_handle import NodeHandle
from ..odometry import DifferentialOdometry
from ..ros_time import stamp
from ..speed_limiter import SpeedLimiter


class _Command(NamedTuple):
    """A velocity command, replaced as a whole by the subscriber's thread."""

    linear: float
    angular: float
    serial: int
    received: float  # wall time (s, monotonic)


class DiffDriveController(Controller):
    """Follows ``cmd_vel`` (geometry_msgs/Twist: linear.x in m/s, angular.z in rad/s).

    A command that is older than ``cmd_vel_timeout`` counts as zero, and the limits apply to
    that too: the robot brakes, it does not jump. Publishes ``odom`` and its transform.

    Parameters: ``left_wheel``, ``right_wheel`` (a joint or a list of joints), ``wheel_radius``,
    ``wheel_separation`` (m), ``wheel_radius_multiplier``, ``wheel_separation_multiplier``,
    ``cmd_vel_timeout`` (s), ``publish_rate`` (Hz), ``base_frame_id``, ``odom_frame_id``,
    ``enable_odom_tf``, ``velocity_rolling_window_size``, ``pose_covariance_diagonal``,
    ``twist_covariance_diagonal`` (six numbers each), ``linear/x`` and ``angular/z`` (limits, see
    `SpeedLimiter`).
    """

    parameters = frozenset(
        (
            "angular",
            "base_frame_id",
            "cmd_vel_timeout",
            "enable_odom_tf",
            "left_wheel",
            "linear",
            "odom_frame_id",
            "pose_covariance_diagonal",
            "publish_rate",
            "right_wheel",
            "twist_covariance_diagonal",
            "velocity_rolling_window_size",
            "wheel_radius",
            "wheel_radius_multiplier",
            "wheel_separation",
            "wheel_separation_multiplier",
        )
    )

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Claim the wheels and open the topics."""
        self._node = node
        wheels = hw.get(VelocityJointInterface)
        sides: List[List[JointHandle]] = [
            [wheels.get_handle(joint) for joint in _names(node, side)]
            for side in ("left_wheel", "right_wheel")
        ]
        if len(sides[0]) != len(sides[1]):
            raise ControllerInitError(
                f"parameters {node.resolve('left_wheel')} and {node.resolve('right_wheel')} name "
                f"{len(sides[0])} and {len(sides[1])} joints; both need the same number"
            )
        self._left, self._right = sides
        self._radius = _positive(node, "wheel_radius") * _positive(
            node, "wheel_radius_multiplier", 1.0
        )
        self._separation = _positive(node, "wheel_separation") * _positive(
            node, "wheel_separation_multiplier", 1.0
        )
        self._timeout = _positive(node, "cmd_vel_timeout", 0.5)
        self._publish_period = 1.0 / _positive(node, "publish_rate", 50.0)
        try:
            self._linear_limiter = SpeedLimiter.from_params(
                node.param("linear/x", dict, {}), node.resolve("linear/x")
            )
            self._angular_limiter = SpeedLimiter.from_params(
                node.param("angular/z", dict, {}), node.resolve("angular/z")
            )
        except ValueError as error:
            raise ControllerInitError(str(error)) from error
        window = node.param("velocity_rolling_window_size", int, 10)
        if window < 1:
            raise ControllerInitError(
                f"parameter {node.resolve('velocity_rolling_window_size')} is {window}; "
                "at least 1 is needed"
            )
        self._odometry = DifferentialOdometry(self._separation, self._radius, self._radius, window)
        self._pose_covariance = _covariance(node, "pose_covariance_diagonal")
        self._twist_covariance = _covariance(node, "twist_covariance_diagonal")
        self._base_frame = node.param("base_frame_id", str, "base_link")
        self._odom_frame = node.param("odom_frame_id", str, "odom")
        self._odom = node.advertise("odom", Odometry)
        self._tf = (
            node.advertise("/tf", TFMessage) if node.param("enable_odom_tf", bool, True) else None
        )
        self._command = _Command(0.0, 0.0, 0, 0.0)
        node.subscribe("cmd_vel", Twist, self._on_command)

    def _on_command(self, message: Twist) -> None:
        linear, angular = message.linear.x, message.angular.z
        if not (math.isfinite(linear) and math.isfinite(angular)):
            self._node.warn(
                f"cmd_vel: linear.x {linear}, angular.z {angular} is not finite and is dropped"
            )
            return
        self._command = _Command(linear, angular, self._command.serial + 1, wall.monotonic())

    def starting(self, time: float) -> None:
        """Stand still; commands from before are forgotten."""
        self._obeyed = self._command.serial
        self._received = time
        self._linear = (0.0, 0.0)
        self._angular = (0.0, 0.0)
        self._next_publish = time
        self._odometry.restart()
        self._brake()

    def update(self, time: float, period: float) -> None:
        """Limit the command, turn it into wheel speeds, and keep the odometry."""
        self._odometry.update(_mean_position(self._left), _mean_position(self._right), period)
        if time >= self._next_publish - 5e-7:
            self._next_publish = max(self._next_publish + self._publish_period, time)
            self._publish(time)
        command = self._command
        if command.serial != self._obeyed:
            self._obeyed = command.serial
            # Its age in sim time counts from this cycle. A command that came while the simulation
            # was paused may be old by the wall's clock, which is the operator's.
            if wall.monotonic() - command.received <= self._timeout:
                self._received = time
                self._active = (command.linear, command.angular)
        elif time - self._received > self._timeout:
            self._active = (0.0, 0.0)
        linear = self._linear_limiter.limit(self._active[0], *self._linear, period)
        angular = self._angular_limiter.limit(self._active[1], *self._angular, period)
        self._linear = (linear, self._linear[0])
        self._angular = (angular, self._angular[0])
        difference = 0.5 * angular * self._separation
        left, right = (linear - difference) / self._radius, (linear + difference) / self._radius
        for wheel in self._left:
            wheel.command = left
        for wheel in self._right:
            wheel.command = right

    def stopping(self, time: float) -> None:
        """Brake at once."""
        self._brake()

    def reset(self, time: float) -> None:
        """Stand still, and start the odometry again at the origin."""
        self._odometry.reset()
        self.starting(time)

    def _brake(self) -> None:
        self._active = (0.0, 0.0)
        for wheel in (*self._left, *self._right):
            wheel.command = 0.0

    def _publish(self, time: float) -> None:
        odometry = self._odometry
        now = stamp(time)
        sine, cosine = math.sin(0.5 * odometry.heading), math.cos(0.5 * odometry.heading)
        if self._tf is not None:
            transform = TransformStamped()
            transform.header.stamp = now
            transform.header.frame_id = self._odom_frame
            transform.child_frame_id = self._base_frame
            transform.transform.translation.x = odometry.x
            transform.transform.translation.y = odometry.y
            transform.transform.rotation.z = sine
            transform.transform.rotation.w = cosine
            self._tf.publish(TFMessage([transform]))
        if not self._odom.has_subscribers():
            return
        message = Odometry()
        message.header.stamp = now
        message.header.frame_id = self._odom_frame
        message.child_frame_id = self._base_frame
        message.pose.pose.position.x = odometry.x
        message.pose.pose.position.y = odometry.y
        message.pose.pose.orientation.z = sine
        message.pose.pose.orientation.w = cosine
        message.pose.covariance = self._pose_covariance
        message.twist.twist.linear.x = odometry.linear
        message.twist.twist.angular.z = odometry.angular
        message.twist.covariance = self._twist_covariance
        self._odom.publish(message)


def _mean_position(wheels: List[JointHandle]) -> float:
    return sum(wheel.state.position for wheel in wheels) / len(wheels)


def _names(node: NodeHandle, key: str) -> List[str]:
    value: Any = node.param(key, (str, list))
    names = [value] if isinstance(value, str) else value
    if not names or not all(isinstance(name, str) for name in names):
        raise ControllerInitError(
            f"parameter {node.resolve(key)} is {value!r}; a joint name or a list of them is needed"
        )
    return names


def _positive(node: NodeHandle, key: str, *default: float) -> float:
    value = node.param(key, float, *default)
    if value <= 0.0:
        raise ControllerInitError(f"parameter {node.resolve(key)} is {value}; it must be above 0")
    return value


def _covariance(node: NodeHandle, key: str) -> Tuple[float, ...]:
    """Return a 6x6 matrix, row by row, from the diagonal that the parameter gives."""
    diagonal = node.param(key, list)
    if len(diagonal) != 6 or not all(
        isinstance(value, (int, float)) and math.isfinite(value) for value in diagonal
    ):
        raise ControllerInitError(
            f"parameter {node.resolve(key)} is {diagonal!r}; six finite numbers are needed"
        )
    matrix = [0.0] * 36
    for index, value in enumerate(diagonal):
        matrix[7 * index] = float(value)
    return tuple(matrix)
