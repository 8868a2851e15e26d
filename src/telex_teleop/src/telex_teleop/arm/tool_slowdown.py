"""Reasons why the tool is slower than commanded, for the operator. Free of ROS."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from telex_teleop.motion.reference import MotionLimits

# A joint within this distance (rad or m) of a bound counts as at the bound.
ON_BOUND = 1e-4


@dataclass(frozen=True)
class Slowdown:
    """Why the tool is slower than commanded; `share` of the speed is left."""

    share: float
    reason: str
    joints: Tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"slowed to {100.0 * self.share:.0f} %: {self.reason}"


class SlowdownReasons:
    """Finds the joint that slows the tool, and the reason.

    Parameters
    ----------
    joints
        Names, in the order of all arrays.
    prismatic
        Which of them are measured in metres.
    limits
        Of each joint.
    look_ahead
        Time (s) for which the tool is led ahead on trial.
    """

    def __init__(
        self,
        joints: Sequence[str],
        prismatic: Sequence[bool],
        limits: Sequence[MotionLimits],
        look_ahead: float,
    ) -> None:
        self._joints = tuple(joints)
        self._prismatic = tuple(prismatic)
        self._lower = np.array([each.lower for each in limits])
        self._upper = np.array([each.upper for each in limits])
        self._velocity_limits = np.array([each.max_velocity for each in limits])
        self._look_ahead = look_ahead

    def explain(
        self,
        share: float,
        solution: np.ndarray,
        ahead: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> Slowdown:
        """Say why a trial got no further.

        Parameters
        ----------
        share
            Of the speed that is left.
        solution, ahead : ndarray, shape (n,)
            Where the joints are led now, and where the trial ended (rad or m).
        lower, upper : ndarray, shape (n,)
            Between which the trial kept.
        """
        moved = ahead - solution
        fastest = int(np.argmax(np.abs(moved) / self._velocity_limits))
        on_lower, on_upper = ahead - lower <= ON_BOUND, upper - ahead <= ON_BOUND
        bounded = on_lower | on_upper
        if bounded.any():
            rooms = np.where(on_lower, solution - lower, upper - solution)
            rooms = np.where(bounded, rooms, np.inf)
            nearest = int(np.argmin(rooms / self._velocity_limits))
            towards = float(ahead[nearest])
            return self.near_bound(share, nearest, solution, towards, lower, upper)
        joint = self._joints[fastest]
        if abs(moved[fastest]) >= 0.99 * self._velocity_limits[fastest] * self._look_ahead:
            return Slowdown(share, f"{joint} is as fast as it can be", (joint,))
        return Slowdown(share, f"{joint} is near a singularity", (joint,))

    def near_bound(
        self,
        share: float,
        index: int,
        solution: np.ndarray,
        towards: float,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> Slowdown:
        """Say that a joint is near one of its bounds: that nearer to the position `towards`."""
        joint, present = self._joints[index], float(solution[index])
        below = abs(towards - lower[index]) < abs(upper[index] - towards)
        bound, limit = (lower, self._lower) if below else (upper, self._upper)
        if abs(bound[index] - limit[index]) > ON_BOUND:
            return Slowdown(share, f"something holds {joint} back", (joint,))
        room = self._shown(index, abs(float(limit[index]) - present))
        return Slowdown(share, f"{joint} is {room} from its limit", (joint,))

    def _shown(self, index: int, room: float) -> str:
        if self._prismatic[index]:
            return f"{1000.0 * max(room, 0.0):.0f} mm"
        return f"{math.degrees(max(room, 0.0)):.1f} deg"
