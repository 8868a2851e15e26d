"""Controllers that publish what sensors measure: ``imu_sensor_controller`` and force-torque."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple, Type

from geometry_msgs.msg import Quaternion, Vector3, WrenchStamped
from sensor_msgs.msg import Imu

from ..common.periodic import Periodic
from ..hardware.hardware_interface import (
    ForceTorqueSensorHandle,
    ForceTorqueSensorInterface,
    HardwareInterface,
    ImuSensorHandle,
    ImuSensorInterface,
    RobotHW,
)
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle, Publisher
from ..ros.sim_time import stamp

_NOT_MEASURED = (-1.0, *(0.0,) * 8)
"""What sensor_msgs/Imu wants as the covariance of a quantity that is not measured."""
_UNKNOWN = (0.0,) * 9


class _SensorController(Controller):
    """Publishes every sensor of one kind on a topic of its name in the robot's namespace.

    Parameter: ``publish_rate`` (Hz, required; 0: never).
    """

    parameters = frozenset(("publish_rate",))
    SAVED_PARTS = ("_timer",)
    interface: Type[HardwareInterface]
    message_type: Any

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Take the sensors and open the topics."""
        self._timer = Periodic(node.positive_param("publish_rate", zero=True))
        sensors = hw.get(self.interface)
        self._sensors: List[Tuple[Any, Publisher]] = [
            (sensors.get_handle(name), node.advertise(root.resolve(name), self.message_type))
            for name in sensors.names()
        ]

    def starting(self, time: float) -> None:
        """Publish in the first cycle."""
        self._timer.restart()

    def update(self, time: float, period: float) -> None:
        """Publish when it is due."""
        if not self._timer.is_due(time):
            return
        for sensor, publisher in self._sensors:
            if publisher.has_subscribers():
                message = self._message(sensor)
                message.header.stamp = stamp(time)
                message.header.frame_id = sensor.frame_id
                publisher.publish(message)

    def _message(self, sensor: Any) -> Any:
        raise NotImplementedError


class ImuSensorController(_SensorController):
    """``imu_sensor_controller/ImuSensorController``: sensor_msgs/Imu for each inertial sensor."""

    interface = ImuSensorInterface
    message_type = Imu

    def _message(self, sensor: ImuSensorHandle) -> Any:
        message = Imu()
        if sensor.orientation is not None:
            message.orientation = Quaternion(*sensor.orientation)
        message.orientation_covariance = _covariance(
            sensor.orientation, sensor.orientation_covariance
        )
        message.angular_velocity = _vector(sensor.angular_velocity)
        message.angular_velocity_covariance = _covariance(
            sensor.angular_velocity, sensor.angular_velocity_covariance
        )
        message.linear_acceleration = _vector(sensor.linear_acceleration)
        message.linear_acceleration_covariance = _covariance(
            sensor.linear_acceleration, sensor.linear_acceleration_covariance
        )
        return message


class ForceTorqueSensorController(_SensorController):
    """``force_torque_sensor_controller/ForceTorqueSensorController``: WrenchStamped for each."""

    interface = ForceTorqueSensorInterface
    message_type = WrenchStamped

    def _message(self, sensor: ForceTorqueSensorHandle) -> Any:
        message = WrenchStamped()
        message.wrench.force = _vector(sensor.force)
        message.wrench.torque = _vector(sensor.torque)
        return message


def _vector(values: Optional[Sequence[float]]) -> Any:
    return Vector3() if values is None else Vector3(*values)


def _covariance(
    value: Optional[Sequence[float]], covariance: Optional[Sequence[float]]
) -> Sequence[float]:
    if value is None:
        return _NOT_MEASURED
    return _UNKNOWN if covariance is None else covariance
