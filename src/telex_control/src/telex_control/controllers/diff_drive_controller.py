"""``diff_drive_controller/DiffDriveController``: drives two sides of wheels or belts by a twist."""

from __future__ import annotations

import math
import time as wall
from typing import Any, ClassVar, Dict, List, NamedTuple, Optional, Sequence, Tuple

from control_msgs.msg import JointTrajectoryControllerState
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from ..base.odometry import DifferentialOdometry
from ..common.periodic import Periodic
from ..common.plausible import speed_problem
from ..common.stateful import Names, Stateful
from ..hardware.hardware_interface import JointHandle, RobotHW, VelocityJointInterface
from ..laws.speed_limiter import SpeedLimiter
from ..manager.controller import Controller, ControllerInitError
from ..ros.node_handle import NodeHandle, Publisher, ReconfigurableParameter, Subscription
from ..ros.sim_time import stamp
from ..urdf.joints import UrdfError, parse_urdf
from ..urdf.wheel_geometry import wheel_radius, wheel_separation

RECONFIGURABLE = (
    ReconfigurableParameter(
        "left_wheel_radius_multiplier", 1.0, 0.5, 1.5, "Corrects the radius of the left wheels."
    ),
    ReconfigurableParameter(
        "right_wheel_radius_multiplier", 1.0, 0.5, 1.5, "Corrects the radius of the right wheels."
    ),
    ReconfigurableParameter(
        "wheel_separation_multiplier", 1.0, 0.5, 1.5, "Corrects the distance of the wheels."
    ),
    ReconfigurableParameter("publish_rate", 50.0, 0.0, 2000.0, "Of odometry and transform (Hz)."),
    ReconfigurableParameter("enable_odom_tf", True, False, True, "Publish the transform."),
)
"""Names, defaults and ranges are those of diff_drive_controller."""
_ROUNDING = 5e-7
"""Time (s) by which sums of periods are wrong at most."""


class _Command(NamedTuple):
    """A velocity command, replaced as a whole by the subscriber's thread."""

    linear: float
    angular: float
    serial: int
    received: float  # wall time (s, monotonic)
    message: Optional[Twist]  # None before the first
    brake: bool = False  # at once


class _Tuning(NamedTuple):
    """What may change at run time, replaced as a whole by the service's thread."""

    left_wheel_radius_multiplier: float
    right_wheel_radius_multiplier: float
    wheel_separation_multiplier: float
    publish_rate: float
    enable_odom_tf: bool


class DiffDriveController(Controller):
    """Follows ``cmd_vel`` (geometry_msgs/Twist: linear.x in m/s, angular.z in rad/s).

    A command that is older than ``cmd_vel_timeout``, or whose publisher is gone, counts as zero,
    and the limits apply to that too: the robot brakes, it does not jump. Publishes ``odom`` and its
    transform.

    Parameters: ``left_wheel``, ``right_wheel`` (a joint or a list of joints), ``wheel_radius``,
    ``wheel_separation`` (m; from ``robot_description`` when they are not given),
    ``wheel_radius_multiplier`` (or one each: ``left_wheel_radius_multiplier``,
    ``right_wheel_radius_multiplier``), ``wheel_separation_multiplier``,
    ``cmd_vel_timeout`` (s), ``allow_multiple_cmd_vel_publishers``, ``publish_rate`` (Hz),
    ``open_loop`` (odometry from commands), ``base_frame_id``, ``odom_frame_id``,
    ``enable_odom_tf``, ``tf_topic`` (where its transform goes, ``/tf``),
    ``velocity_rolling_window_size``, ``pose_covariance_diagonal``, ``twist_covariance_diagonal``
    (six numbers each), ``linear/x`` and ``angular/z`` (limits, see `SpeedLimiter`), ``publish_cmd``
    (the limited command, on ``cmd_vel_out``),
    ``publish_wheel_joint_controller_state`` (on ``wheel_joint_controller_state``). The
    multipliers, ``publish_rate`` and ``enable_odom_tf`` may be changed at run time.
    """

    parameters = frozenset(
        (
            "allow_multiple_cmd_vel_publishers",
            "angular",
            "base_frame_id",
            "cmd_vel_timeout",
            "enable_odom_tf",
            "left_wheel",
            "left_wheel_radius_multiplier",
            "linear",
            "odom_frame_id",
            "open_loop",
            "pose_covariance_diagonal",
            "publish_cmd",
            "publish_rate",
            "publish_wheel_joint_controller_state",
            "right_wheel",
            "right_wheel_radius_multiplier",
            "tf_topic",
            "twist_covariance_diagonal",
            "velocity_rolling_window_size",
            "wheel_radius",
            "wheel_radius_multiplier",
            "wheel_separation",
            "wheel_separation_multiplier",
        )
    )
    SAVED: ClassVar[Names] = ("_active", "_angular", "_linear")
    SAVED_TIMES = ("_received",)
    SAVED_PARTS: ClassVar[Names] = ("_odometry", "_publish_timer", "_wheel_state")

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
        self._wheels = [*self._left, *self._right]
        self._nominal_radius, self._nominal_separation = self._geometry(root, node)
        self._timeout = node.positive_param("cmd_vel_timeout", 0.5)
        self._linear_limiter, self._angular_limiter = (
            SpeedLimiter.from_params(node.param(key, dict, {}), node.resolve(key))
            for key in ("linear/x", "angular/z")
        )
        window = node.param("velocity_rolling_window_size", int, 10)
        if window < 1:
            raise ControllerInitError(
                f"parameter {node.resolve('velocity_rolling_window_size')} is {window}; "
                "at least 1 is needed"
            )
        self._open_loop = node.param("open_loop", bool, False)
        self._pose_covariance = _covariance(node, "pose_covariance_diagonal")
        self._twist_covariance = _covariance(node, "twist_covariance_diagonal")
        self._base_frame = node.param("base_frame_id", str, "base_link")
        self._odom_frame = node.param("odom_frame_id", str, "odom")
        self._tuning = _read_tuning(node)
        self._odometry = self._make_odometry(window)
        self._apply(self._tuning)
        self._odom = node.advertise("odom", Odometry)
        self._tf = node.advertise(node.param("tf_topic", str, "/tf"), TFMessage)
        self._limited: Optional[Publisher] = None
        if node.param("publish_cmd", bool, False):
            self._limited = node.advertise("cmd_vel_out", TwistStamped, queue_size=1)
        self._wheel_state: Optional[_WheelStatePublisher] = None
        if node.param("publish_wheel_joint_controller_state", bool, False):
            self._wheel_state = _WheelStatePublisher(node, self._wheels)
        self._command = _Command(0.0, 0.0, 0, 0.0, None)
        # Limited commands of the last two cycles.
        self._linear: Tuple[float, float] = (0.0, 0.0)
        self._angular: Tuple[float, float] = (0.0, 0.0)
        self._several_publishers = node.param("allow_multiple_cmd_vel_publishers", bool, True)
        self._subscription: Optional[Subscription] = None
        self._subscription = node.subscribe("cmd_vel", Twist, self._on_command)
        node.serve_reconfiguration("", RECONFIGURABLE, self._tuning._asdict(), self._on_tuning)

    def _make_odometry(self, window: int) -> Any:
        """Odometry of the drive, with velocities averaged over `window` cycles."""
        return DifferentialOdometry(1.0, 1.0, 1.0, window)

    def _geometry(self, root: NodeHandle, node: NodeHandle) -> Tuple[float, float]:
        """Return radius and separation of the wheels (m)."""
        left, right = self._left[0].name, self._right[0].name
        known = [
            node.positive_param(key) if node.find_param(key, None) is not None else None
            for key in ("wheel_radius", "wheel_separation")
        ]
        radius, separation = known
        try:
            if radius is None:
                radius = wheel_radius(parse_urdf(root.param("robot_description", str)), left)
            if separation is None:
                separation = wheel_separation(
                    parse_urdf(root.param("robot_description", str)), left, right
                )
        except UrdfError as error:
            raise ControllerInitError(
                f"{error}; parameters {node.resolve('wheel_radius')} and "
                f"{node.resolve('wheel_separation')} give them without it"
            ) from error
        return radius, separation

    def _on_command(self, message: Twist) -> None:
        linear, angular = message.linear.x, message.angular.z
        for name, value, limiter in (
            ("linear.x", linear, self._linear_limiter),
            ("angular.z", angular, self._angular_limiter),
        ):
            allowed = limiter.velocity
            limit = math.inf if allowed is None else max(-allowed.low, allowed.high)
            problem = speed_problem(value, limit)
            if problem:
                self._node.warn(
                    f"{self._node.resolve('cmd_vel')}: {name} {value} {problem} and is dropped"
                )
                return
        serial = self._command.serial + 1
        if not self._several_publishers and self._subscription is not None:
            count = self._subscription.publisher_count()
            if count > 1:
                self._node.warn(
                    f"{self._node.resolve('cmd_vel')} has {count} publishers, and "
                    "allow_multiple_cmd_vel_publishers is false; going to brake"
                )
                self._command = _Command(0.0, 0.0, serial, wall.monotonic(), message, brake=True)
                return
        self._command = _Command(linear, angular, serial, wall.monotonic(), message)

    def _on_tuning(self, values: Dict[str, Any]) -> None:
        if values["publish_rate"] <= 0.0:
            raise ValueError(f"publish_rate is {values['publish_rate']}; it must be above 0 Hz")
        self._tuning = _Tuning(**values)

    def _apply(self, tuning: _Tuning) -> None:
        self._applied = tuning
        self._left_radius = self._nominal_radius * tuning.left_wheel_radius_multiplier
        self._right_radius = self._nominal_radius * tuning.right_wheel_radius_multiplier
        self._separation = self._nominal_separation * tuning.wheel_separation_multiplier
        self._odometry.set_geometry(self._separation, self._left_radius, self._right_radius)
        self._publish_timer = Periodic(tuning.publish_rate)

    def starting(self, time: float) -> None:
        """Stand still; commands from before are forgotten."""
        self._obeyed = self._command.serial
        self._received = time
        self._publish_timer.restart()
        self._odometry.restart()
        if self._wheel_state is not None:
            self._wheel_state.restart()
        self._brake()

    def update(self, time: float, period: float) -> None:
        """Limit the command, turn it into wheel speeds, and keep the odometry."""
        if self._tuning is not self._applied:
            self._apply(self._tuning)
        self._measure(time, period)
        if self._publish_timer.is_due(time):
            self._publish(time)
        self._obey(self._command, time)
        linear = self._linear_limiter.limit(
            self._active[0], *self._linear, period, self._braking(time, period)
        )
        angular = self._angular_limiter.limit(self._active[1], *self._angular, period)
        self._linear = (linear, self._linear[0])
        self._angular = (angular, self._angular[0])
        left, right = self._side_speeds(linear, angular, period)
        for wheel in self._left:
            wheel.command = left / self._left_radius
        for wheel in self._right:
            wheel.command = right / self._right_radius
        if self._limited is not None and self._limited.has_subscribers():
            message = TwistStamped()
            message.header.stamp = stamp(time)
            message.header.frame_id = self._base_frame
            message.twist.linear.x, message.twist.angular.z = linear, angular
            self._limited.publish(message)
        if self._wheel_state is not None:
            self._wheel_state.update(time, period)

    def _measure(self, time: float, period: float) -> None:
        """Advance the odometry to `time`, `period` after the last cycle (s)."""
        if self._open_loop:
            self._odometry.update_open_loop(self._linear[0], self._angular[0], period)
        else:
            self._odometry.update(mean_position(self._left), mean_position(self._right), period)

    def _braking(self, time: float, period: float) -> float:
        """Deceleration (m/s2) that must not be exceeded at `time` (s), whatever is configured."""
        return math.inf

    def _side_speeds(self, linear: float, angular: float, period: float) -> Tuple[float, float]:
        """Speed (m/s) at which the left and right wheels run for a limited command (m/s, rad/s)."""
        difference = 0.5 * angular * self._separation
        return linear - difference, linear + difference

    def _covariances(self) -> Tuple[Sequence[float], Sequence[float]]:
        """Covariances of pose and twist, 36 numbers each."""
        return self._pose_covariance, self._twist_covariance

    def _obey(self, command: _Command, time: float) -> None:
        """Take a new command over, or give up an old one."""
        if command.serial == self._obeyed:
            if time - self._received > self._timeout + _ROUNDING or self._is_orphaned(command):
                self._active = (0.0, 0.0)
            return
        self._obeyed = command.serial
        # Its age in sim time counts from this cycle. A command that came while the simulation
        # was paused may be old by the wall's clock, which is the operator's.
        if wall.monotonic() - command.received <= self._timeout:
            self._received = time
            self._active = (command.linear, command.angular)
        if command.brake:
            self._brake()

    def _is_orphaned(self, command: _Command) -> bool:
        """Whether a command still moves the robot, and nobody is there to end it."""
        if self._active == (0.0, 0.0) or self._subscription is None:
            return False
        return not self._subscription.is_connected(command.message)

    def stopping(self, time: float) -> None:
        """Brake at once."""
        self._brake()

    def reset(self, time: float) -> None:
        """Stand still, and start the odometry again at the origin."""
        self._odometry.reset()
        self.starting(time)

    def interrupt(self, time: float) -> None:
        """Come to rest as after an old command, within the limits."""
        self._obeyed = self._command.serial
        self._active = (0.0, 0.0)

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; commands from before this are forgotten.

        What was obeyed then is obeyed again, until it is as old as it may be.
        """
        super().restore_state(saved, elapsed)
        self._obeyed = self._command.serial

    def _brake(self) -> None:
        self._active = (0.0, 0.0)
        self._linear = (0.0, 0.0)
        self._angular = (0.0, 0.0)
        for wheel in self._wheels:
            wheel.command = 0.0

    def _publish(self, time: float) -> None:
        odometry = self._odometry
        now = stamp(time)
        position, orientation = Vector3(*odometry.position), Quaternion(*odometry.orientation)
        if self._applied.enable_odom_tf:
            transform = TransformStamped()
            transform.header.stamp = now
            transform.header.frame_id = self._odom_frame
            transform.child_frame_id = self._base_frame
            transform.transform.translation = position
            transform.transform.rotation = orientation
            self._tf.publish(TFMessage([transform]))
        if not self._odom.has_subscribers():
            return
        message = Odometry()
        message.header.stamp = now
        message.header.frame_id = self._odom_frame
        message.child_frame_id = self._base_frame
        message.pose.pose.position = Point(*odometry.position)
        message.pose.pose.orientation = orientation
        message.twist.twist.linear.x = odometry.linear
        message.twist.twist.angular.z = odometry.angular
        message.pose.covariance, message.twist.covariance = self._covariances()
        self._odom.publish(message)


class _WheelStatePublisher(Stateful):
    """Publishes commands and measurements of the wheels in every cycle, when anybody listens."""

    SAVED = ("_desired", "_last_commands", "_last_velocities")

    def __init__(self, node: NodeHandle, wheels: List[JointHandle]) -> None:
        self._wheels = wheels
        self._publisher = node.advertise(
            "wheel_joint_controller_state", JointTrajectoryControllerState, queue_size=1
        )
        self.restart()

    def restart(self) -> None:
        """Begin at the measured state."""
        self._desired = [wheel.state.position for wheel in self._wheels]
        self._last_commands = [0.0] * len(self._wheels)
        self._last_velocities = [wheel.state.velocity for wheel in self._wheels]

    def update(self, time: float, period: float) -> None:
        """Publish the cycle at `time`, `period` after the last (s)."""
        wheels = self._wheels
        commands = [wheel.command for wheel in wheels]
        velocities = [wheel.state.velocity for wheel in wheels]
        self._desired = [
            position + command * period for position, command in zip(self._desired, commands)
        ]
        if self._publisher.has_subscribers():
            desired = JointTrajectoryPoint(
                positions=self._desired,
                velocities=commands,
                accelerations=_rates(commands, self._last_commands, period),
                effort=[math.nan] * len(wheels),
            )
            actual = JointTrajectoryPoint(
                positions=[wheel.state.position for wheel in wheels],
                velocities=velocities,
                accelerations=_rates(velocities, self._last_velocities, period),
                effort=[wheel.state.effort for wheel in wheels],
            )
            message = JointTrajectoryControllerState()
            message.header.stamp = stamp(time)
            message.joint_names = [wheel.name for wheel in wheels]
            message.desired, message.actual = desired, actual
            message.error = JointTrajectoryPoint(
                positions=_differences(desired.positions, actual.positions),
                velocities=_differences(desired.velocities, actual.velocities),
                accelerations=_differences(desired.accelerations, actual.accelerations),
                effort=[math.nan] * len(wheels),
            )
            self._publisher.publish(message)
        self._last_commands, self._last_velocities = commands, velocities


def _differences(first: List[float], second: List[float]) -> List[float]:
    return [a - b for a, b in zip(first, second)]


def _rates(now: List[float], before: List[float], period: float) -> List[float]:
    if period <= 0.0:
        return [0.0] * len(now)
    return [difference / period for difference in _differences(now, before)]


def mean_position(wheels: List[JointHandle]) -> float:
    """Mean position of the wheels of one side (rad)."""
    return sum(wheel.state.position for wheel in wheels) / len(wheels)


def _names(node: NodeHandle, key: str) -> List[str]:
    value: Any = node.find_param(key, None)
    names = [value] if isinstance(value, str) else node.param(key, list)
    if not names or not all(isinstance(name, str) for name in names):
        raise ControllerInitError(
            f"parameter {node.resolve(key)} is {value!r}; a joint name or a list of them is needed"
        )
    return names


def _read_tuning(node: NodeHandle) -> _Tuning:
    both = node.positive_param("wheel_radius_multiplier", 1.0)
    return _Tuning(
        node.positive_param("left_wheel_radius_multiplier", both),
        node.positive_param("right_wheel_radius_multiplier", both),
        node.positive_param("wheel_separation_multiplier", 1.0),
        node.positive_param("publish_rate", 50.0),
        node.param("enable_odom_tf", bool, True),
    )


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
