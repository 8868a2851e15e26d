"""Settings of the tool's motion: speeds, leads and times."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telex_control.common.params import Declared, number
from telex_teleop.motion.reference import stoppable_speed

# A way that takes less time than this at full speed (s) is done.
ARRIVED_TIME = 1e-5


@dataclass(frozen=True)
class ToolSettings(Declared):
    """How the tool moves."""

    max_linear: float = number(
        0.15, "Largest speed of the tool centre point (m/s) at speed scale 1.", above=0.0
    )
    max_angular: float = number(0.6, "The same (rad/s).", above=0.0)
    acceleration_time: float = number(0.3, "Time (s) from rest to the largest speed.", above=0.0)
    look_ahead: float = number(
        0.4,
        "How far ahead (s) the path is tried; should exceed the joints' acceleration_time, so that "
        "they can brake within it.",
        above=0.0,
    )
    lead: float = number(
        0.005,
        "How far (m) the desired pose may be ahead of what the arm can reach: where the arm slides "
        "along a boundary, it is off the desired line by at most so much.",
        above=0.0,
    )
    angular_lead: float = number(0.03, "The same (rad).", maximum=math.pi / 2, above=0.0)
    hold_lead: float = number(
        0.3,
        "The same (m) while the tool keeps its place in the world: further off, it gives the place "
        "up.",
        lambda own: own.lead,
    )
    angular_hold_lead: float = number(
        0.6, "The same (rad).", lambda own: own.angular_lead, math.pi / 2
    )
    hold_ahead: float = number(
        0.045,
        "Time (s) by which a tool that keeps its place is led ahead of the base's motion: joints "
        "follow their references late.",
        0.0,
        0.2,
    )
    least_share: float = number(
        0.03,
        "Share of the speed that is tried where the path seems to end; it makes the arm slide.",
        maximum=0.2,
        above=0.0,
    )

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
