"""Level ground: straight on, and turning in place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Tuple

import numpy as np

from telex_training.operators.scripted_operator import TICK

from .offline import OfflineTrial

FLAT = (0.01, 0.01)
"""As the preset: the tips 4 mm off the floor."""
FLUSH = (0.0, 0.0)
UP = (1.20, 1.20)
UPRIGHT = (1.57, 1.20)
"""With the arm as in `drive`, the centre of mass is then 8 mm before base_link, not 16."""


@dataclass(frozen=True)
class Straight:
    """What was measured on a straight drive.

    Attributes
    ----------
    speed : float
        Mean (m/s).
    vertical : float
        Root mean square of the vertical velocity (m/s).
    pitching : float
        Root mean square of the pitch rate (rad/s).
    """

    speed: float
    vertical: float
    pitching: float


@dataclass(frozen=True)
class SpotTurn:
    """What was measured in a turn in place.

    Attributes
    ----------
    rate : float
        Mean (rad/s).
    drift : float
        Farthest that base_link came from where it was (m).
    """

    rate: float
    drift: float


def straight(
    trial: OfflineTrial, speed: float, seconds: float = 3.0, flippers: Tuple[float, float] = UP
) -> Straight:
    """Drive straight on, and measure once the speed is reached.

    With the flippers flat, the belts touch the floor along 1.6 m, here and there: what holds the
    hull level changes from step to step.
    """
    operator = trial.operator
    operator.flippers(*flippers)
    operator.wait(1.5)
    operator.drive(speed)
    operator.wait(1.5)
    samples: List[Tuple[float, float]] = []

    def sample() -> None:
        linear, angular = trial.velocity()
        heading = operator.pose.yaw
        samples.append((linear[2], angular[1] * np.cos(heading) - angular[0] * np.sin(heading)))

    trial.each_step.append(sample)
    before = trial.position()
    operator.wait(seconds)
    way = trial.position() - before
    trial.each_step.remove(sample)
    vertical, pitching = np.sqrt(np.mean(np.square(samples), axis=0))
    heading = operator.pose.yaw
    along = way[0] * np.cos(heading) + way[1] * np.sin(heading)
    return Straight(float(along / seconds), float(vertical), float(pitching))


def turn(
    trial: OfflineTrial,
    rate: float,
    seconds: float = 4.0,
    ramp: float = 0.6,
    flippers: Tuple[float, float] = UPRIGHT,
) -> SpotTurn:
    """Turn in place with the flippers up.

    The robot turns about a point before or behind base_link, about twice as far from it as the
    centre of mass: upright front flippers make up for the turret.

    Parameters
    ----------
    rate : float
        rad/s.
    seconds : float
        Over which rate and drift are measured.
    ramp : float
        From rest until it begins to be measured (s).
    flippers : tuple of float
        Front and rear (rad).
    """
    operator = trial.operator
    operator.flippers(*flippers)
    operator.wait(2.5)
    operator.drive(0.0, rate)
    operator.wait(ramp)
    begin = trial.position()
    drift = turned = 0.0
    last = operator.pose.yaw
    for _ in range(round(seconds / TICK)):
        operator.tick()
        turned += math.remainder(operator.pose.yaw - last, 2.0 * math.pi)
        last = operator.pose.yaw
        drift = max(drift, float(np.linalg.norm(trial.position() - begin)))
    return SpotTurn(turned / (round(seconds / TICK) * TICK), drift)
