"""Joint references that lead the tool along a path: the operational-space scheme, in advance.

Inverse kinematics tracks each pose from the reference before it, as an operator's commands are
followed; nothing in it depends on where the joints are. So the whole motion is worked out before
the robot moves, and a path that leaves the workspace is refused instead of followed half-way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

import numpy as np

from ..common.geometry.matrices import homogeneous
from ..kinematics import Chain, IKSolver
from ..urdf.joints import PRISMATIC
from . import FollowTrajectoryError
from .paths import Path
from .speed_profile import SpeedProfile

LOST = 1e-4
"""A reference further from the path than this (m, rad) does not follow it."""


@dataclass(frozen=True)
class PlannedPath:
    """A tool motion, and the joint references for it.

    Attributes
    ----------
    period : float
        Time between references (s).
    references : ndarray, shape (n, joints)
        From the start of the path until its end is reached (rad, m).
    """

    chain: Chain
    path: Path
    profile: SpeedProfile
    period: float
    references: np.ndarray

    @property
    def start(self) -> np.ndarray:
        """Joint positions at the start of the path."""
        return self.references[0]

    def tool(self, time: np.ndarray) -> np.ndarray:
        """Desired places of the tool at some times, shape (n, 3) (m, in the base link's frame)."""
        return self.path.position(self.profile.length(time))

    def reference(self, time: float) -> np.ndarray:
        """Joint references at a time (s); before the start and after the end the nearest."""
        place = min(max(time / self.period, 0.0), len(self.references) - 1.0)
        index = min(int(place), len(self.references) - 2)
        share = place - index
        return (1.0 - share) * self.references[index] + share * self.references[index + 1]


def plan(
    solver: IKSolver,
    path: Path,
    profile: SpeedProfile,
    orientation: np.ndarray,
    seed: Sequence[float],
    period: float,
) -> PlannedPath:
    """Work out the references for a path.

    Parameters
    ----------
    path : Path
        In the base link's frame.
    orientation : ndarray, shape (3, 3)
        Of the tool, all the way.
    seed : sequence of float
        Joint positions near which the start is looked for.
    period : float
        Time between references (s).

    Raises
    ------
    FollowTrajectoryError
        The path leaves the workspace, or asks a joint for more speed than it has.
    """
    count = int(np.ceil(profile.duration / period)) + 1
    places = path.position(profile.length(period * np.arange(count)))
    first: Optional[FollowTrajectoryError] = None
    for guess in _seeds(solver.chain, np.asarray(seed, dtype=float)):
        try:
            begin = _begin(solver, homogeneous(orientation, places[0]), guess)
            references = _track(solver, orientation, places, begin, period)
            return PlannedPath(solver.chain, path, profile, period, references)
        except FollowTrajectoryError as error:
            first = first or error
    assert first is not None
    raise first


def _seeds(chain: Chain, seed: np.ndarray) -> List[np.ndarray]:
    """Postures to try as a start from which the whole path can be followed, the nearest first.

    A posture with a joint on a limit reaches the start as well as another, but not what follows.
    """
    limited = np.isfinite(chain.lower) & np.isfinite(chain.upper)
    middle = np.where(limited, 0.5 * (chain.lower + chain.upper), seed)
    sliding = np.array([joint.kind == PRISMATIC for joint in chain.joints])
    return [
        seed,
        np.where(sliding, middle, seed),
        0.5 * (seed + middle),
        middle,
    ]


def _begin(solver: IKSolver, target: np.ndarray, seed: np.ndarray) -> np.ndarray:
    """Joint positions for the start of a path."""
    found = solver.solve(target, seed.tolist())
    if not found.converged:
        raise FollowTrajectoryError(
            f"the start of the path, {_shown(target[:3, 3])}, cannot be reached with the tool as "
            f"it is turned: {1000.0 * found.position_error:.0f} mm are left; another centre, or "
            "another orientation of the tool, is needed"
        )
    return np.asarray(found.q)


def _track(
    solver: IKSolver, orientation: np.ndarray, places: np.ndarray, begin: np.ndarray, period: float
) -> np.ndarray:
    """Joint references that lead the tool from place to place."""
    references = np.empty((len(places), len(begin)))
    references[0] = begin
    for index in range(1, len(places)):
        # No limit of accelerations: the speed profile has its own, and nothing may be late here.
        tick = solver.track(
            homogeneous(orientation, places[index]),
            references[index - 1],
            period,
            acceleration_time=None,
        )
        if tick.position_error > LOST or tick.orientation_error > LOST:
            held = [*tick.at_limits, *tick.at_speed]
            raise FollowTrajectoryError(
                f"the path cannot be followed at {_shown(places[index])}, after "
                f"{index * period:.1f} s: "
                + (f"{', '.join(held)} at its limit" if held else "the arm is at its reach")
                + "; another centre, a smaller path or less speed is needed"
            )
        references[index] = tick.q
    return references


def _shown(place: np.ndarray) -> str:
    return f"({', '.join(f'{value:.3f}' for value in place)}) m"
