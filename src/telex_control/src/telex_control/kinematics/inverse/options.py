"""Options of the inverse kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Optional, Tuple

from telex_control.common.params import require, require_choice, require_range

FREE = math.inf
SMALLEST_TOLERANCE = 1e-12
"""m and rad; below, rounding of the forward kinematics decides."""
_NONE = (0.0, 0.0, 0.0)


class Goal:
    """What decides between the solutions that a target leaves open."""

    NONE = "none"
    SEED = "seed"
    """Near the seed: least sum of squared joint moves (rad, m)."""
    MID_RANGE = "mid_range"
    """Near the middle of the joints' ranges: least sum of squared distances, in half ranges."""
    MANIPULABILITY = "manipulability"
    """Far from singularities: largest product of the Jacobian's singular values.

    T. Yoshikawa, Manipulability of robotic mechanisms, Int. J. Robotics Research 4 (1985)."""

    ALL = (NONE, SEED, MID_RANGE, MANIPULABILITY)


class Mode:
    """How many solutions are looked at."""

    SPEED = "speed"
    """The first, moved to where the goal is met best without leaving the target."""
    BEST = "best"
    """As many as the budget allows; the one that meets the goal best."""

    ALL = (SPEED, BEST)


@dataclass(frozen=True)
class Tolerance:
    """When a target counts as reached.

    The bounds are along and about the axes of the target's own frame. What is within them counts
    as no error; what is beyond must be below `position` and `rotation`.

    Attributes
    ----------
    position, rotation : float
        Norms (m, rad).
    position_bounds : tuple of 3 floats
        m; `FREE` leaves the direction open.
    rotation_bounds : tuple of 3 floats
        rad; `FREE` leaves the rotation open.
    """

    position: float = 1e-5
    rotation: float = 1e-5
    position_bounds: Tuple[float, float, float] = _NONE
    rotation_bounds: Tuple[float, float, float] = _NONE

    def __post_init__(self) -> None:
        for name in ("position", "rotation"):
            require_range(self, name, SMALLEST_TOLERANCE)
        for name in ("position_bounds", "rotation_bounds"):
            bounds = getattr(self, name)
            require(
                len(bounds) == 3 and all(bound >= 0.0 for bound in bounds),
                f"{name} is {bounds!r}; three numbers of 0 or more are needed (x, y, z)",
            )
        require(
            min((*self.position_bounds, *self.rotation_bounds)) < FREE,
            "all of position_bounds and rotation_bounds are infinite; nothing would be asked for",
        )

    @classmethod
    def position_only(cls, position: float = 1e-5) -> Tolerance:
        """Leave the orientation open."""
        return cls(position=position, rotation_bounds=(FREE, FREE, FREE))

    @classmethod
    def free_roll(cls, axis: str, position: float = 1e-5, rotation: float = 1e-5) -> Tolerance:
        """Leave the rotation about one of the target's axes open: ``x``, ``y`` or ``z``."""
        require(axis in ("x", "y", "z"), f"axis is {axis!r}; x, y and z are possible")
        x, y, z = (FREE if axis == each else 0.0 for each in "xyz")
        return cls(position=position, rotation=rotation, rotation_bounds=(x, y, z))


@dataclass(frozen=True)
class IKOptions:
    """Options of the inverse kinematics; `telex_control.common.params.read_config` reads them too.

    Attributes
    ----------
    goal : str
        One of `Goal`.
    mode : str
        One of `Mode`.
    iterations : int, optional
        Of a solve, over all its restarts: what an unreachable target costs. An iteration is about
        1 microsecond compiled and 40 without the compiler; 6000 and 500 when not given.
    time_limit : float, optional
        s of wall time for a solve. With it, answers depend on how busy the machine is; None keeps
        them reproducible.
    random_seed : int
        Of the restarts.
    length_weight : float
        rad/m: an error of 1 m weighs as much as one of this many rad. Decides the compromise where
        a target is out of reach, and the units of `TrackResult.sigma`.
    singular_below : float
        Least singular value of the Jacobian below which a posture counts as singular.
    attempt_iterations : int
        After how many a solve restarts elsewhere.
    restart_candidates : int
        Random postures tried for a restart; the one nearest to the target is taken.
    track_iterations : int
        Of one tick of `track`.
    search_iterations : int
        Spent to find out whether another posture reaches a target at which `track` stands stuck.
    reconfigure_after : float, optional
        s: when the target has stood still for so long, `track` walks to this posture, inside speed
        limits, for as long as the target stays where it is. The tool may swing far from it on the
        way: where a person leads the arm, None, which is never.
    """

    tolerance: Tolerance = field(default_factory=Tolerance)
    goal: str = Goal.NONE
    mode: str = Mode.SPEED
    iterations: Optional[int] = None
    time_limit: Optional[float] = None
    random_seed: int = 1
    length_weight: float = 3.0
    singular_below: float = 0.05
    attempt_iterations: int = 30
    restart_candidates: int = 4
    track_iterations: int = 50
    search_iterations: int = 600
    reconfigure_after: Optional[float] = 0.5

    def __post_init__(self) -> None:
        require_choice(self, "goal", Goal.ALL)
        require_choice(self, "mode", Mode.ALL)
        require(
            self.mode == Mode.SPEED or self.goal != Goal.NONE,
            f"mode is {Mode.BEST!r} and goal is {Goal.NONE!r}; the best needs one of "
            f"{', '.join(Goal.ALL[1:])}",
        )
        for name in ("iterations", "attempt_iterations", "restart_candidates", "track_iterations"):
            require_range(self, name, 1)
        require_range(self, "search_iterations", 0)
        require_range(self, "random_seed", 0, 2**63 - 1)
        require_range(self, "reconfigure_after", 0.0)
        for name in ("time_limit", "length_weight", "singular_below"):
            require_range(self, name, above=0.0)
