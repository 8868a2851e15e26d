"""Results of the inverse kinematics."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np


class IKStatus(enum.Enum):
    """How an answer stands to its target."""

    CONVERGED = "CONVERGED"
    """The target is reached."""
    LAGGING = "LAGGING"
    """On the way; the speed or acceleration limit of a joint holds it back."""
    BEST_EFFORT = "BEST_EFFORT"
    """As near as can be: from any posture that was tried, or from the present one."""
    NEEDS_RECONFIGURE = "NEEDS_RECONFIGURE"
    """As near as the present posture allows; another posture reaches the target."""


@dataclass(frozen=True)
class IKResult:
    """Answer of a solve.

    Attributes
    ----------
    q : ndarray, shape (n,)
        Joint positions (rad, m), always within the limits.
    status : IKStatus
        CONVERGED or BEST_EFFORT.
    position_error, orientation_error : float
        Distance from the target (m, rad), beyond the bounds of the tolerance.
    """

    q: np.ndarray
    status: IKStatus
    position_error: float
    orientation_error: float
    iterations: int
    restarts: int

    @property
    def converged(self) -> bool:
        """Whether the target is reached."""
        return self.status is IKStatus.CONVERGED


@dataclass(frozen=True)
class TrackResult:
    """Answer of one tick of streaming control.

    Attributes
    ----------
    q : ndarray, shape (n,)
        The next joint reference (rad, m).
    velocity : ndarray, shape (n,)
        On the way there (rad/s, m/s).
    position_error, orientation_error : float
        Distance of `q` from the target (m, rad), beyond the bounds of the tolerance.
    at_limits, at_speed : tuple of str
        Joints that stand on a position limit and would have to go beyond it to come nearer to the
        target, and those that move at their speed limit.
    margins : ndarray, shape (n,)
        Distance of `q` from the nearer position limit (rad, m); infinite where there is none.
    sigma : float
        Smallest singular value of the Jacobian, lengths weighted with `IKOptions.length_weight`,
        of the directions that the tolerance asks for, and without joints that a position limit
        holds; 0 is singular. Of a chain of fewer joints than directions, of as many as it has
        joints.
    singular : bool
        `sigma` is below `IKOptions.singular_below`.
    singular_direction : ndarray, shape (6,)
        Unit twist (base frame, lengths weighted) of the tip that costs most joint speed.
    twist_ratio : float
        `track_twist` only: share of the asked twist that the tick carries out along its direction
        (0 to 1); 1 otherwise.
    posture : ndarray, shape (n,), optional
        With NEEDS_RECONFIGURE: joint positions (rad, m) that reach the target.
    """

    q: np.ndarray
    velocity: np.ndarray
    status: IKStatus
    position_error: float
    orientation_error: float
    at_limits: Tuple[str, ...]
    at_speed: Tuple[str, ...]
    margins: np.ndarray
    sigma: float
    singular: bool
    singular_direction: np.ndarray
    twist_ratio: float = 1.0
    posture: Optional[np.ndarray] = None

    @property
    def converged(self) -> bool:
        """Whether the target is reached."""
        return self.status is IKStatus.CONVERGED
