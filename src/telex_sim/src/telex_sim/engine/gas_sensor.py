"""Gas sensor of one robot in a simulation."""

from __future__ import annotations

import math
from typing import Optional

from telex_control.common.stateful import Stateful

from ..robot.robot import Robot
from .simulation import Simulation


class GasSensor(Stateful):
    """Reads the gas at a link, in the simulation's thread; nothing in scenes without leaks.

    As a watcher of the robot it goes back to a bookmark with it.
    """

    SAVED = ("_reading",)
    SAVED_TIMES = ("_read",)

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._reading = 0.0
        self._read: Optional[float] = None
        self._starts = -1

    def observe(self, simulation: Simulation) -> Optional[float]:
        """Read it now; returns the share of volume, None where there is nothing to read."""
        gas, config = simulation.gas, self._robot.config.gas
        if gas is None or config.link not in self._robot.body.link_names():
            self._read = None
            return None
        if self._starts != self._robot.starts:
            self._starts, self._read = self._robot.starts, None
        share, now = gas.share(self._robot.body.pose(config.link)[0]), simulation.time
        if self._read is None:
            self._reading = 0.0  # it is taken along from fresh air
        elif config.response == 0.0:
            self._reading = share
        else:
            left = math.exp(-max(now - self._read, 0.0) / config.response)
            self._reading = share + (self._reading - share) * left
        self._read = now
        return self._reading

    def restore_state(self, saved: object, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        super().restore_state(saved, elapsed)
        self._starts = self._robot.starts
