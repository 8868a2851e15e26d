"""Errors of a robot's sensors, which begin anew with the robot."""

from __future__ import annotations

import zlib

from telex_control.common.stateful import Stateful

from ..robot.imu_noise import NormalNumbers
from ..robot.robot import Robot


class Errors(Stateful):
    """Draws errors of one sensor, the same ones after every start of its robot.

    Parameters
    ----------
    name : str
        Of the sensor: two of a robot differ in their errors, as those of two robots do.
    """

    SAVED_PARTS = ("_normal",)

    def __init__(self, robot: Robot, name: str, seed: int) -> None:
        self._robot = robot
        self._name = f"{seed} {robot.namespace}/{name}"
        self._restart()

    def _restart(self) -> None:
        self._starts = self._robot.starts
        self._normal = NormalNumbers(zlib.crc32(self._name.encode()))

    def draw(self, deviation: float) -> float:
        """Return the next error, by its standard deviation."""
        if self._starts != self._robot.starts:
            self._restart()
        return deviation * next(self._normal)

    def restore_state(self, saved: object, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        super().restore_state(saved, elapsed)
        self._starts = self._robot.starts
