"""Malfunctions of one robot over ROS: ``sim/malfunction``, ``sim/malfunctions``.

With what its battery tells, where it has one: ``battery``, ``battery/range``.
"""

from __future__ import annotations

import math
import threading
from typing import Any, Callable, Dict, List, Optional

import rospy
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Float64
from telex_msgs.msg import Malfunctions
from telex_msgs.srv import Malfunction, MalfunctionResponse

from telex_control.common.params import ConfigError

from ..malfunctions.malfunctions import Active
from ..malfunctions.messages import malfunctions_message
from ..robot.robot import Robot

Change = Callable[[Callable[[], None]], None]
"""Has the simulation's thread carry something out; raises ConfigError where that is refused."""


class MalfunctionService:
    """Lets parts of a robot fail, and tells instructors what does.

    Topics are opened and closed in a thread of ROS; what publishes is the simulation's thread's.

    Parameters
    ----------
    now : callable
        Gives the sim time.
    """

    def __init__(self, robot: Robot, change: Change, now: Callable[[], rospy.Time]) -> None:
        namespace = robot.namespace
        self._robot = robot
        self._malfunctions = robot.malfunctions
        self._change = change
        self._now = now
        self._told = -1
        self._levels: Dict[str, float] = {}
        self._lamps: List[rospy.Subscriber] = []
        self._params = f"{namespace}/cameras"
        self._one_call = threading.Lock()
        cameras, lamps = self._equipment()
        robot.malfunctions.equip(cameras, lamps)
        self._hear_lamps(lamps)
        self._active = rospy.Publisher(
            f"{namespace}/sim/malfunctions", Malfunctions, queue_size=1, latch=True
        )
        self._battery: Optional[rospy.Publisher] = None
        self._range: Optional[rospy.Publisher] = None
        if robot.malfunctions.has_battery:
            self._battery = rospy.Publisher(f"{namespace}/battery", BatteryState, queue_size=1)
            if not robot.config.fixed_base:
                self._range = rospy.Publisher(f"{namespace}/battery/range", Float64, queue_size=1)
        self._service = rospy.Service(f"{namespace}/sim/malfunction", Malfunction, self._on_call)

    def _equipment(self) -> Any:
        """Cameras and lamps as the parameters of the node ``cameras`` have them."""
        return tuple(rospy.get_param(f"{self._params}/{key}", {}) for key in ("cameras", "lamps"))

    def _hear_lamps(self, lamps: Any) -> None:
        """Follow the lamps' levels, once they are known; asks the master."""
        if self._lamps:
            return
        for name in self._malfunctions.parts.lamps:
            if lamps[name].get("beam"):  # what a laser takes is nothing to a battery
                continue
            level = lamps[name].get("level", 0.0)
            lit = isinstance(level, (int, float)) and 0.0 <= level <= 1.0
            self._levels[name] = float(level) if lit else 0.0
            # The node of the cameras says how a lamp is switched, also to a simulator that begins
            # after it; where there is none, commands are all there is.
            for topic in ("command", "level"):
                self._lamps.append(
                    rospy.Subscriber(
                        f"{self._robot.namespace}/lamps/{name}/{topic}",
                        Float64,
                        self._take_level,
                        callback_args=name,
                    )
                )
        self._malfunctions.lamp_levels = sum(self._levels.values())

    def _take_level(self, message: Float64, name: str) -> None:
        # Also false for NaN.
        if 0.0 <= message.data <= 1.0:
            self._levels[name] = message.data
            self._malfunctions.lamp_levels = sum(self._levels.values())

    def _on_call(self, request: Any) -> MalfunctionResponse:
        with self._one_call:
            return self._carry_out(request)

    def _carry_out(self, request: Any) -> MalfunctionResponse:
        done: List[str] = []
        cameras, lamps = self._equipment()

        def change() -> None:
            self._malfunctions.equip(cameras, lamps)
            done.append(self._begin(request) if request.on else self._end(request))
            self.publish()

        try:
            self._change(change)
        except ConfigError as error:
            rospy.logwarn("sim/malfunction: %s", error)
            return MalfunctionResponse(success=False, message=str(error))
        self._hear_lamps(lamps)
        rospy.loginfo("%s: %s", self._robot.model, done[0])
        return MalfunctionResponse(success=True, message=done[0])

    def _begin(self, request: Any) -> str:
        made = self._malfunctions.begin(
            request.what, request.kind, request.value, request.announced, self._now().to_sec()
        )
        severity = f" {made.value:g}" if made.value else ""
        return f"{_name(made)}{severity}, {'announced' if made.announced else 'silent'}"

    def _end(self, request: Any) -> str:
        gone = self._malfunctions.end(request.what, request.kind)
        return f"ended: {', '.join(map(_name, gone)) or 'nothing was active'}"

    def publish(self) -> None:
        """Tell what fails, where that has changed."""
        malfunctions = self._malfunctions
        if malfunctions.changes == self._told:
            return
        self._told = malfunctions.changes
        message = malfunctions_message(malfunctions)
        message.header.stamp = self._now()
        self._active.publish(message)

    def publish_battery(self) -> None:
        """Tell charge and range, when anybody listens; what does not run down tells the same."""
        if self._range is not None:
            self._range.publish(self._malfunctions.reach(self._now().to_sec()))
        if self._battery is None or not self._battery.get_num_connections():
            return
        charge = self._malfunctions.charge()
        message = BatteryState(
            voltage=charge.voltage,
            temperature=math.nan,
            current=-charge.current,
            charge=charge.share * charge.capacity,
            capacity=charge.capacity,
            design_capacity=charge.capacity,
            percentage=charge.share,
            power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
            power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_GOOD,
            power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_LION,
            present=True,
        )
        message.header.stamp = self._now()
        self._battery.publish(message)

    def close(self) -> None:
        """Take service and topics back."""
        self._service.shutdown()
        for lamp in self._lamps:
            lamp.unregister()
        for topic in (self._active, self._battery, self._range):
            if topic is not None:
                topic.unregister()


def _name(each: Active) -> str:
    return f"{each.what} {each.kind}"
