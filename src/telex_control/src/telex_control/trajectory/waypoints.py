"""Reading of trajectory_msgs/JointTrajectory."""

from __future__ import annotations

import math
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Sequence

from control_msgs.msg import FollowJointTrajectoryResult as Result

from ..common.plausible import (
    LARGEST_ACCELERATION,
    LONGEST,
    number_problem,
    position_problem,
    speed_problem,
)
from .path import Track
from .spline import State


class TrajectoryError(ValueError):
    """A trajectory cannot be carried out.

    Attributes
    ----------
    code : int
        One of FollowJointTrajectoryResult's.
    """

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Bounds(NamedTuple):
    """Limits of one joint, which its positions (rad, m) and velocities (rad/s, m/s) are for."""

    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf

    def problem(self, field: str, value: float) -> str:
        """Why a number of a point can be none of this joint's; empty where it can."""
        if field == "positions":
            return position_problem(value, self.lower, self.upper)
        if field == "velocities":
            return speed_problem(value, self.velocity)
        return number_problem(value, LARGEST_ACCELERATION)


def read_tracks(
    trajectory: Any, joints: Mapping[str, Bounds], allow_partial: bool
) -> Dict[str, Track]:
    """Return what each joint is to do.

    Parameters
    ----------
    trajectory : trajectory_msgs/JointTrajectory
        With at least one point. Its joints may come in any order.
    joints : mapping of str to Bounds
        Joints of the controller.
    allow_partial : bool
        Whether the trajectory may leave out some of them.

    Raises
    ------
    TrajectoryError
        INVALID_JOINTS, or INVALID_GOAL for points that are incomplete, not in order, or
        have numbers that cannot be meant.
    """
    names = list(trajectory.joint_names)
    check_joints(names, joints, allow_partial)
    times: List[float] = []
    states: List[List[State]] = [[] for _ in names]
    last = -math.inf
    for number, point in enumerate(trajectory.points):
        time = point.time_from_start.to_sec()
        # A first one somewhat below 0, as of a planner that rounds, lies in the past like others.
        if time <= last:
            raise TrajectoryError(
                Result.INVALID_GOAL,
                f"point {number} has time_from_start {time:g} s; it must be after that of the "
                f"point before, {last:g} s",
            )
        if abs(time) > LONGEST:
            raise TrajectoryError(
                Result.INVALID_GOAL,
                f"point {number} has time_from_start {time:g} s; at most {LONGEST:g} s is possible",
            )
        last = time
        times.append(time)
        for column, state in zip(states, _states(point, number, names, joints)):
            column.append(state)
    return {name: Track(times, column) for name, column in zip(names, states)}


def check_joints(names: Sequence[str], joints: Collection[str], allow_partial: bool) -> None:
    """Raise TrajectoryError INVALID_JOINTS unless a trajectory for `names` is for `joints`.

    Parameters
    ----------
    allow_partial : bool
        Whether some may be left out; never all of them.
    """
    expected = f"this controller has {', '.join(joints)}"
    unknown = [name for name in names if name not in joints]
    if unknown:
        raise TrajectoryError(Result.INVALID_JOINTS, f"joint '{unknown[0]}' is unknown; {expected}")
    if len(set(names)) != len(names):
        raise TrajectoryError(Result.INVALID_JOINTS, "a joint is named twice")
    missing = [name for name in joints if name not in names]
    if missing and (not allow_partial or not names):
        raise TrajectoryError(Result.INVALID_JOINTS, f"joint '{missing[0]}' is missing; {expected}")


def _states(
    point: Any, number: int, names: Sequence[str], joints: Mapping[str, Bounds]
) -> List[State]:
    columns: List[Sequence[Any]] = []
    for field in ("positions", "velocities", "accelerations"):
        values = getattr(point, field)
        if len(values) != len(names) and (len(values) or field == "positions"):
            raise TrajectoryError(
                Result.INVALID_GOAL,
                f"point {number} has {len(values)} {field}; {len(names)} are needed, one a joint",
            )
        for name, value in zip(names, values):
            problem = joints[name].problem(field, value)
            if problem:
                raise TrajectoryError(
                    Result.INVALID_GOAL,
                    f"point {number}: {field} of joint '{name}' is {value}, which {problem}",
                )
        columns.append(values or (None,) * len(names))
    return [State(*row) for row in zip(*columns)]
