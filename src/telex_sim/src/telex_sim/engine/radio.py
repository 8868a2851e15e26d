"""Radio signal between a robot in a simulation and its operator's antenna."""

from __future__ import annotations

import math

from ..radio.reception import Signal, signal_of, thicknesses_between
from ..robot.robot import Robot
from .simulation import Simulation


def signal_at(simulation: Simulation, robot: Robot) -> Signal:
    """Return the signal where a robot stands now; in the simulation's thread."""
    config, antenna = robot.config.radio, simulation.scene.antenna
    if antenna is None:
        start = simulation.scene.start
        antenna = (start.x, start.y, start.ground + config.antenna_height)
    x, y, z = robot.body.base_pose()[0]
    place = (x, y, z + config.robot_height)
    robots = {each.body.uid for each in simulation.robots}
    walls = thicknesses_between(simulation.world.client, antenna, place, robots)
    return signal_of(config, math.dist(antenna, place), walls)
