"""Dead reckoning by wheels, and that of a differential drive."""

from __future__ import annotations

import math
from collections import deque
from typing import ClassVar, Deque, Optional, Tuple

from ..common.geometry.quaternions import Quaternion, about
from ..common.stateful import Names, Stateful


class RollingVelocity(Stateful):
    """Mean of the last velocities.

    Parameters
    ----------
    window : int
        How many.
    """

    SAVED = ("_angular", "_linear", "_window")

    def __init__(self, window: int) -> None:
        self._window: Deque[Tuple[float, float]] = deque(maxlen=window)
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._window.clear()
        self._linear = self._angular = 0.0

    def add(self, linear: float, angular: float) -> Tuple[float, float]:
        """Take a velocity (m/s, rad/s), and return the mean."""
        window = self._window
        if len(window) == window.maxlen:
            old = window[0]
            self._linear -= old[0]
            self._angular -= old[1]
        window.append((linear, angular))
        self._linear += linear
        self._angular += angular
        return self._linear / len(window), self._angular / len(window)


class WheelOdometry(Stateful):
    """What the wheels of two sides tell: way, turn, and the mean velocity of the last cycles.

    Parameters
    ----------
    window : int
        Number of cycles over which the reported velocity is averaged.

    Attributes
    ----------
    linear, angular : float
        Velocity along the base's x axis, and about its z axis (m/s, rad/s).
    """

    SAVED: ClassVar[Names] = ("_last", "angular", "linear")
    SAVED_PARTS = ("_mean",)

    def __init__(self, window: int) -> None:
        self._mean = RollingVelocity(window)
        self._last: Optional[Tuple[float, float]] = None
        self.linear = 0.0
        self.angular = 0.0

    def set_geometry(
        self, wheel_separation: float, left_radius: float, right_radius: float
    ) -> None:
        """Change the effective geometry (m) from the next cycle on."""
        self._separation = wheel_separation
        self._left_radius = left_radius
        self._right_radius = right_radius

    def restart(self) -> None:
        """Forget the last wheel positions but keep the pose."""
        self.linear = self.angular = 0.0
        self._last = None
        self._mean.clear()

    def _covered(self, left: float, right: float, period: float) -> Optional[Tuple[float, float]]:
        """Return way (m) and turn (rad) of a cycle; None when it has no cycle before it.

        Parameters
        ----------
        left, right : float
            Wheel positions (rad).
        period : float
            Time since the last cycle (s).
        """
        last, self._last = self._last, (left, right)
        if last is None or period <= 0.0:
            return None
        left_way = (left - last[0]) * self._left_radius
        right_way = (right - last[1]) * self._right_radius
        return 0.5 * (left_way + right_way), (right_way - left_way) / self._separation


class DifferentialOdometry(WheelOdometry):
    """Integrates wheel positions, or commanded velocities, to a pose in the plane.

    Parameters
    ----------
    wheel_separation, left_radius, right_radius : float
        Effective geometry (m).
    window : int
        Number of cycles over which the reported velocity is averaged.
    """

    SAVED = ("heading", "x", "y")

    def __init__(
        self, wheel_separation: float, left_radius: float, right_radius: float, window: int
    ) -> None:
        super().__init__(window)
        self.set_geometry(wheel_separation, left_radius, right_radius)
        self.x = 0.0
        self.y = 0.0
        self.heading = 0.0

    @property
    def position(self) -> Tuple[float, float, float]:
        """Where the robot is (m)."""
        return self.x, self.y, 0.0

    @property
    def orientation(self) -> Quaternion:
        """Quaternion (x, y, z, w)."""
        return about((0.0, 0.0, 1.0), self.heading)

    def reset(self) -> None:
        """Start again at the origin."""
        self.x = self.y = self.heading = 0.0
        self.restart()

    def update(self, left: float, right: float, period: float) -> None:
        """Advance by one cycle.

        Parameters
        ----------
        left, right : float
            Wheel positions (rad).
        period : float
            Time since the last cycle (s).
        """
        covered = self._covered(left, right, period)
        if covered is None:
            return
        way, turn = covered
        self._integrate(way, turn)
        self.linear, self.angular = self._mean.add(way / period, turn / period)

    def update_open_loop(self, linear: float, angular: float, period: float) -> None:
        """Advance by one cycle of commanded velocities (m/s, rad/s), as if they were obeyed."""
        self.linear, self.angular = linear, angular
        self._integrate(linear * period, angular * period)

    def _integrate(self, way: float, turn: float) -> None:
        # Exact for a circular arc: the chord lies at half the turn.
        half = 0.5 * turn
        chord = way * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        self.x += chord * math.cos(self.heading + half)
        self.y += chord * math.sin(self.heading + half)
        self.heading = math.remainder(self.heading + turn, 2.0 * math.pi)
