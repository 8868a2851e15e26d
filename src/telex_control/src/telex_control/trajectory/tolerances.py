"""Tolerances of trajectories."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Dict, Iterable, Sequence

from control_msgs.msg import FollowJointTrajectoryResult as Result

from ..common.params import ConfigError
from .waypoints import TrajectoryError


@dataclass(frozen=True)
class StateTolerance:
    """Largest errors of one joint (rad, rad/s; m, m/s). 0 leaves a quantity unchecked."""

    position: float = 0.0
    velocity: float = 0.0

    def allows(self, position_error: float, velocity_error: float) -> bool:
        """Whether errors are within the tolerance."""
        return not (
            0.0 < self.position < abs(position_error) or 0.0 < self.velocity < abs(velocity_error)
        )

    def problem(self, position_error: float, velocity_error: float) -> str:
        """Which error is beyond its tolerance, and what that is; empty where none is."""
        if 0.0 < self.position < abs(position_error):
            return f"{position_error:.6f}: position, tolerance {self.position:g}"
        if 0.0 < self.velocity < abs(velocity_error):
            return f"{velocity_error:.6f}: velocity, tolerance {self.velocity:g}"
        return ""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a trajectory.

    Attributes
    ----------
    path, goal : dict of str to StateTolerance
        By joint: while the trajectory runs, and from its end on.
    goal_time : float
        How long after its end the goal tolerance may still be reached (s).
    """

    path: Dict[str, StateTolerance] = field(default_factory=dict)
    goal: Dict[str, StateTolerance] = field(default_factory=dict)
    goal_time: float = 0.0


def read_tolerances(constraints: Any, name: str, joints: Sequence[str]) -> Tolerances:
    """Read the parameter ``constraints`` of a joint trajectory controller.

    Parameters
    ----------
    constraints : dict
        ``goal_time`` (s), ``stopped_velocity_tolerance`` (0.01, at the goal), and for each joint
        {``trajectory``, ``goal``}: position errors. 0, the default, checks nothing.
    name : str
        Full name of the parameter, for messages.

    Raises
    ------
    ConfigError
        A value is no number of 0 or more, or a key is unknown.
    """
    known = {*joints, "goal_time", "stopped_velocity_tolerance"}
    for key in constraints:
        if key not in known:
            raise ConfigError(
                f"parameter {name}/{key} is unknown; known are {', '.join(sorted(known))}"
            )
    stopped = _number(constraints, "stopped_velocity_tolerance", 0.01, name)
    path, goal = {}, {}
    for joint in joints:
        own = constraints.get(joint, {})
        unknown = sorted(set(own) - {"trajectory", "goal"}) if isinstance(own, dict) else ["?"]
        if unknown:
            raise ConfigError(
                f"parameter {name}/{joint} is {own!r}; a struct of trajectory and goal is needed"
            )
        path[joint] = StateTolerance(_number(own, "trajectory", 0.0, f"{name}/{joint}"))
        goal[joint] = StateTolerance(_number(own, "goal", 0.0, f"{name}/{joint}"), stopped)
    return Tolerances(path, goal, _number(constraints, "goal_time", 0.0, name))


def _number(params: Any, key: str, default: float, name: str) -> float:
    value = params.get(key, default)
    usable = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not usable or not 0.0 <= value < math.inf:
        raise ConfigError(f"parameter {name}/{key} is {value!r}; a number of 0 or more is needed")
    return float(value)


def with_goal(defaults: Tolerances, goal: Any) -> Tolerances:
    """Return the tolerances of a FollowJointTrajectoryGoal.

    A value above 0 takes the place of the default, one below 0 checks nothing, 0 keeps the default.

    Raises
    ------
    TrajectoryError
        A tolerance is not finite.
    """
    late = goal.goal_time_tolerance.to_sec()
    return Tolerances(
        _merged(defaults.path, goal.path_tolerance),
        _merged(defaults.goal, goal.goal_tolerance),
        _chosen(defaults.goal_time, late, "goal_time_tolerance"),
    )


def _merged(
    defaults: Dict[str, StateTolerance], messages: Iterable[Any]
) -> Dict[str, StateTolerance]:
    merged = dict(defaults)
    for message in messages:
        known = merged.get(message.name)
        if known is not None:
            merged[message.name] = replace(
                known,
                position=_chosen(known.position, message.position, message.name),
                velocity=_chosen(known.velocity, message.velocity, message.name),
            )
    return merged


def _chosen(default: float, value: float, name: str) -> float:
    if not math.isfinite(value):
        raise TrajectoryError(Result.INVALID_GOAL, f"tolerance {name} is {value}; it is not finite")
    return default if value == 0.0 else max(value, 0.0)
