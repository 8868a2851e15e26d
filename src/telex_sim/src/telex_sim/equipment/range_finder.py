"""A simulated laser range finder: one ray test for each reading."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Optional, Tuple

import pybullet

from telex_control.common.geometry.quaternions import rotate
from telex_control.common.stateful import Stateful

from ..engine.world import Body
from ..robot.robot import Robot
from .equipment_config import RangeFinderConfig
from .errors import Errors

_BEHIND = 1e-3
"""Way (m) past a surface of its own housing, from which the beam is looked for again."""
_MOST_OWN = 4
"""Surfaces of its own housing that the beam may leave through."""


class RangeFinder(Stateful):
    """Measures how far away it is what the beam meets first, fingers and what they hold included.

    The link that carries it does not stand in its way. As a watcher of the robot it goes back to a
    bookmark with it.

    Attributes
    ----------
    link : str
        In whose origin it sits.
    """

    SAVED_PARTS = ("_errors",)

    def __init__(self, robot: Robot, config: RangeFinderConfig) -> None:
        self._robot = robot
        self._config = config
        self.link = config.link
        self._errors = Errors(robot, "range_finder", config.seed)

    @classmethod
    def training_aid(cls, robot: Robot, config: RangeFinderConfig) -> RangeFinder:
        """Make what measures in place of the range finder that the robot lacks, without errors."""
        exact = replace(config, noise=0.0, noise_share=0.0, resolution=0.0)
        return cls(robot, replace(exact, link=config.training_link))

    def measure(self) -> float:
        """Take a reading (m); infinite where nothing is in range, and minus that where it is near.

        In the simulation's thread.
        """
        config = self._config
        met = first_met(self._robot.body, self.link, config.max)
        if met is None:
            return math.inf
        distance, _ = met
        reading = distance + self._errors.draw(config.noise + config.noise_share * distance)
        if config.resolution:
            reading = config.resolution * round(reading / config.resolution)
        if reading < config.min:
            return -math.inf
        return reading if reading <= config.max else math.inf


def first_met(body: Body, link: str, reach: float) -> Optional[Tuple[float, Tuple[int, int]]]:
    """Find what stands along a link's x axis, within a distance (m) of its origin.

    Returns
    -------
    tuple of float and tuple of int, or None
        How far away it is (m); PyBullet's numbers of the body and its link.
    """
    own = (body.uid, body.place(link)[0])
    origin, orientation = body.pose(link)
    x, y, z = rotate(orientation, (1.0, 0.0, 0.0))
    end = (origin[0] + reach * x, origin[1] + reach * y, origin[2] + reach * z)
    passed = 0.0
    for _ in range(_MOST_OWN):
        start = (origin[0] + passed * x, origin[1] + passed * y, origin[2] + passed * z)
        (hit,) = pybullet.rayTest(start, end, physicsClientId=body.client)
        if hit[0] < 0:
            return None
        distance = passed + hit[2] * (reach - passed)
        if (hit[0], hit[1]) != own:
            return distance, (hit[0], hit[1])
        passed = distance + _BEHIND
        if passed >= reach:
            return None
    return None
