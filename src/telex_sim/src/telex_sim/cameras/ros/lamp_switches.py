"""The robot's lamps as ROS switches them."""

from __future__ import annotations

from typing import Callable, Dict, List, Mapping

import rospy
from std_msgs.msg import Float64

from ..cameras_config import LampConfig


class LampSwitches:
    """Hears on ``lamps/<name>/command`` how brightly each lamp shall burn.

    Parameters
    ----------
    lamps
        By name.
    """

    def __init__(self, lamps: Mapping[str, LampConfig]) -> None:
        # Single items are replaced by ROS's threads, which needs no lock.
        self._levels: Dict[str, float] = {name: lamp.level for name, lamp in lamps.items()}
        self._subscribers: List[rospy.Subscriber] = [
            rospy.Subscriber(
                f"lamps/{name}/command", Float64, self._take, callback_args=name, queue_size=1
            )
            for name in lamps
        ]

    def levels(self, burns: Callable[[str], bool]) -> Dict[str, float]:
        """Level of each lamp, 0 (off) to 1, by its name; `burns` says which are whole."""
        return {name: level if burns(name) else 0.0 for name, level in self._levels.items()}

    def _take(self, message: Float64, name: str) -> None:
        # Also false for NaN.
        if not 0.0 <= message.data <= 1.0:
            rospy.logwarn(
                "lamp %s: level is %g; 0 to 1 is possible, it stays at %g",
                name,
                message.data,
                self._levels[name],
            )
            return
        self._levels[name] = message.data
