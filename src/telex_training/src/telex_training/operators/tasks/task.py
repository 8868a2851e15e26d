"""Base class of the tasks of figure 9: objects put before the robot, work, and a verdict."""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass
from typing import Any, Dict, Tuple

import numpy as np

from ..handling import Hand
from ..station import Station

View = Tuple[str, float, float, float, Tuple[float, float, float]]
"""Where an instructor's camera looks from: mode, azimuth, elevation (rad), distance (m) and centre
(m), as telex_msgs/OverviewView has them."""


@dataclass(frozen=True)
class Verdict:
    """What became of it, by the ground truth.

    Attributes
    ----------
    measure : float
        What was asked for, in the task's unit.
    text : str
        In words.
    """

    done: bool
    measure: float
    text: str


class OperatorTask(abc.ABC):
    """A thing to do, from a start that differs from run to run.

    Attributes
    ----------
    measure : str
        What a verdict's measure is, with its unit.
    subject : str
        Name of the object that it is about.
    view : tuple
        Where the instructor's camera looks from, see `View`.
    """

    measure: str
    subject: str
    view: View

    @abc.abstractmethod
    def lay_out(self, rng: np.random.Generator) -> Dict[str, Dict[str, Any]]:
        """Return what is put before the robot: names and entries of a scene file."""

    @abc.abstractmethod
    def begin(self, station: Station) -> None:
        """Note where things are before the operator begins."""

    @abc.abstractmethod
    def act(self, hand: Hand) -> None:
        """Do it.

        Raises
        ------
        NotManagedError
            The operator gives up; the message says what was tried, and where.
        """

    @abc.abstractmethod
    def judge(self, station: Station) -> Verdict:
        """Judge, once the operator says that it is done, or has given up."""


def placed(
    rng: np.random.Generator, ahead: float, scatter: Tuple[float, float, float]
) -> Dict[str, Any]:
    """Return position and yaw of something so far ahead (m), scattered by up to x, y, yaw."""
    dx, dy, turn = (float(rng.uniform(-each, each)) for each in scatter)
    return {"position": [round(ahead + dx, 4), round(dy, 4), 0.0], "yaw": round(turn, 4)}


def heading_of(pose: np.ndarray) -> float:
    """Return the heading of a pose's x axis (rad)."""
    return math.atan2(pose[1, 0], pose[0, 0])
