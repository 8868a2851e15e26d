"""Radiation that the cameras have received, as ROS tells it."""

from __future__ import annotations

import math
from typing import Dict, NamedTuple

import rospy
from telex_msgs.msg import CameraRadiation


class Received(NamedTuple):
    """Of one camera: dose rate (Gy/h), dose (Gy), and whether it has died of it."""

    dose_rate: float = 0.0
    dose: float = 0.0
    failed: bool = False


_NOTHING = Received()


class ReceivedDose:
    """Hears on ``cameras/radiation`` what each camera has received."""

    def __init__(self) -> None:
        # Replaced as a whole by a thread of ROS, which needs no lock.
        self._received: Dict[str, Received] = {}
        self._subscriber = rospy.Subscriber(
            "cameras/radiation", CameraRadiation, self._take, queue_size=1, tcp_nodelay=True
        )

    def of(self, camera: str) -> Received:
        """What a camera has received; nothing where nobody tells of it."""
        return self._received.get(camera, _NOTHING)

    def _take(self, message: CameraRadiation) -> None:
        columns = (message.names, message.dose_rate, message.dose, message.failed)
        numbers = [*message.dose_rate, *message.dose]
        if len({len(column) for column in columns}) > 1 or not all(
            math.isfinite(number) and number >= 0.0 for number in numbers
        ):
            rospy.logwarn_throttle(
                10.0,
                "cameras/radiation: it has %s names, rates, doses and failures, the numbers %s; as "
                "many of each are needed, and numbers from 0 up; it is not heeded",
                [len(column) for column in columns],
                numbers,
            )
            return
        self._received = {name: Received(*values) for name, *values in zip(*columns)}
