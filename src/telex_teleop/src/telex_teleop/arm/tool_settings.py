"""Settings of the tool's motion: speeds, leads and times."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telex_control.common.params import require_range
from telex_teleop.motion.reference import stoppable_speed

# A way that takes less time than this at full speed (s) is done.
ARRIVED_TIME = 1e-5


@dataclass(frozen=True)
class ToolSettings:
    """How the tool moves.

    Attributes
    ----------
    max_linear, max_angular
        Largest speed of the tool centre point (m/s, rad/s) at speed scale 1.
    acceleration_time
        Time (s) from rest to the largest speed.
    look_ahead
        How far ahead (s) the way is tried; should exceed the joints' acceleration_time, so that
        they can brake within it.
    lead, angular_lead
        How far the desired pose may be ahead of what the arm can reach (m, rad): where the arm
        slides along a boundary, it is off the desired line by at most so much.
    hold_lead, angular_hold_lead
        The same while the tool keeps its place in the world: further off, it gives the place up.
    hold_ahead
        So much ahead (s) of the base's motion the tool is led that keeps its place: joints follow
        their references late.
    least_share
        Share of the speed that is tried where the way seems to end; it makes the arm slide.
    """

    max_linear: float = 0.15
    max_angular: float = 0.6
    acceleration_time: float = 0.3
    look_ahead: float = 0.4
    lead: float = 0.005
    angular_lead: float = 0.03
    hold_lead: float = 0.3
    angular_hold_lead: float = 0.6
    hold_ahead: float = 0.045
    least_share: float = 0.03

    def __post_init__(self) -> None:
        for name in (
            "max_linear",
            "max_angular",
            "acceleration_time",
            "look_ahead",
            "lead",
            "angular_lead",
        ):
            require_range(self, name, above=0.0)
        require_range(self, "angular_lead", above=0.0, maximum=math.pi / 2)
        require_range(self, "hold_lead", self.lead)
        require_range(self, "angular_hold_lead", self.angular_lead, math.pi / 2)
        require_range(self, "hold_ahead", 0.0, 0.2)
        require_range(self, "least_share", above=0.0, maximum=0.2)

    def approach(self, way: np.ndarray, speed_scale: float, dt: float) -> np.ndarray:
        """Return the twist along a straight way to its end; turning ends with moving.

        Parameters
        ----------
        way : ndarray, shape (6,)
            Translation (m) and rotation vector (rad) that are left.
        speed_scale
            Share of the largest speed.
        dt
            Length of a step (s).
        """
        linear = float(np.linalg.norm(way[:3])) / self.max_linear
        angular = float(np.linalg.norm(way[3:])) / self.max_angular
        left = max(linear, angular)
        if left <= ARRIVED_TIME:
            return np.zeros(6)
        stoppable = stoppable_speed(1.0 / self.acceleration_time, left, dt)
        return way * (min(speed_scale, stoppable, left / dt) / left)
