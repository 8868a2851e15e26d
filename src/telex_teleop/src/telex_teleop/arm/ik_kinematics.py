"""The arm's inverse kinematics as the tool's motion needs it."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from telex_control.kinematics import Chain, IKOptions, IKSolver
from telex_teleop.motion.reference import MotionLimits


class IKKinematics:
    """Forward kinematics and tracking of one chain.

    Parameters
    ----------
    limits
        Of its joints: positions and velocities, inside the URDF's.
    """

    def __init__(self, chain: Chain, limits: Sequence[MotionLimits]) -> None:
        self._chain = chain
        # Another posture is the operator's to choose: the tool would swing on the way to it.
        self._solver = IKSolver(
            chain,
            IKOptions(reconfigure_after=None, search_iterations=0),
            velocity_limits=[each.max_velocity for each in limits],
            position_limits=([each.lower for each in limits], [each.upper for each in limits]),
        )

    def warm_up(self) -> None:
        """Compile, or load what was compiled before: seconds the first time."""
        self._solver.warm_up()

    def forward(self, positions: np.ndarray) -> np.ndarray:
        """Return the tool's pose (4x4) in the base's frame."""
        return self._chain.forward(positions.tolist())

    def jacobian(self, positions: np.ndarray) -> np.ndarray:
        """Return the tool's Jacobian, shape (6, n), along the base's axes."""
        return self._chain.jacobian(positions.tolist())

    def track(
        self, target: np.ndarray, q: np.ndarray, dt: float, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        """Return the joint positions nearest to a pose that are reached from `q` in time `dt`."""
        # The bounds of this moment are mostly those of the limits, which the solver knows. Where a
        # blocked joint narrows them, the others need not make up for it.
        # Accelerations are the caller's: it tries several targets before it takes one.
        tick = self._solver.track(target, q.tolist(), dt, acceleration_time=None)
        return np.clip(tick.q, lower, upper)
