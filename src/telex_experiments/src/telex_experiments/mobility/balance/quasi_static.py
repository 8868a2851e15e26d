"""Statics of a robot on belts: its loads, and its centre of rotation, without the simulation.

Loads: every place that a belt can bear in is a spring of the same stiffness, and the robot a rigid
body on them, in balance of force and moment. Turning: each place slips with the whole of Coulomb's
friction within an ellipse, against the direction of slip that dissipates most, and forces and
moment are in balance, however slowly or fast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, List, Sequence, Tuple

import numpy as np

from telex_training.operators.robot_size import (
    AXLE_HEIGHT,
    BELT_INNER,
    BELT_OUTER,
    FLIPPER_LENGTH,
    PIVOT,
    TIP_RADIUS,
)

_BELT = 0.5 * (BELT_INNER + BELT_OUTER)
_DROP = AXLE_HEIGHT - TIP_RADIUS
_REACH = math.sqrt(FLIPPER_LENGTH**2 - _DROP**2)
"""From a hub to the tip, along the floor."""
_BETWEEN = 0.5 * (PIVOT + PIVOT + _REACH)
ON_FLAT_FLIPPERS = (PIVOT, _BETWEEN, PIVOT + _REACH)
ON_HUBS = (PIVOT,)
"""Where belts bear, from base_link to either side along x (m): hubs, runs, tips."""

_UPRIGHT = FLIPPER_LENGTH + TIP_RADIUS
"""Height of axles on upright flippers (m)."""


def places(flat: bool) -> np.ndarray:
    """Places in which belts bear, in base_link (n, 3), with the flippers flat or raised."""
    ends = ON_FLAT_FLIPPERS if flat else ON_HUBS
    return np.array(
        [(end * x, side * _BELT, -AXLE_HEIGHT) for end in (1, -1) for side in (1, -1) for x in ends]
    )


def spring_loads(
    spots: np.ndarray,
    stiffness: float,
    weight: float,
    center: Sequence[float],
    ground: Callable[[float, float], float] = lambda x, y: 0.0,
    gravity: Sequence[float] = (0.0, 0.0, -1.0),
) -> np.ndarray:
    """Loads of equal springs under a rigid body (N).

    Parameters
    ----------
    spots : ndarray, shape (n, 3)
        In the body (m).
    stiffness : float
        Of each (N/m).
    weight : float
        N.
    center : sequence of 3 floats
        Centre of mass, in the body (m).
    ground : callable
        Height (m) under a place of the body (m, along x and y), where it is not level.
    gravity : sequence of 3 floats
        Its direction in the body before that leans as ground and springs let it.

    Raises
    ------
    ValueError
        It tips over.
    """
    x, y, z = spots.T
    heights = np.array([ground(*place) for place in zip(x, y)]) - z + z.mean()
    shape = np.stack([np.ones_like(x), x, y])
    bearing = np.ones(len(x), dtype=bool)
    lean = np.zeros(2)
    for _ in range(100):
        # Where the line of the weight meets the ground.
        down = np.array([gravity[0] + lean[0], gravity[1] + lean[1], gravity[2]])
        aim = np.array(center) - (center[2] - z.mean()) / down[2] * down
        wanted = -weight * gravity[2] * np.array([1.0, aim[0], aim[1]])
        some = shape[:, bearing]
        if np.linalg.matrix_rank(some) < 3:
            break
        # Loads are stiffness * (heights + what the body sinks in and leans there).
        sunk = np.linalg.solve(
            stiffness * some @ some.T, wanted - stiffness * some @ heights[bearing]
        )
        loads = stiffness * (heights + shape.T @ sunk)
        settled = float(np.abs(sunk[1:] - lean).max()) < 1e-6
        if settled and ((loads > 0.0) == bearing).all():
            return np.where(bearing, loads, 0.0)
        bearing, lean = loads > 0.0, sunk[1:]
    raise ValueError("it tips over")


@dataclass(frozen=True)
class Turning:
    """A steady turn in place.

    Attributes
    ----------
    x, y : float
        Centre of rotation, in the body (m).
    belts : float
        Speed of the belts over the yaw rate (m).
    """

    x: float
    y: float
    belts: float

    def farthest(self, angle: float) -> float:
        """Farthest that the body's origin comes from where it was, in a turn (rad) up to pi (m)."""
        return 2.0 * math.hypot(self.x, self.y) * math.sin(0.5 * abs(angle))


def share_needed_at_edge(height: float, friction: float, edge_grip: float = 1.2) -> float:
    """Share of the weight that the front hubs must bear for the rear ones to climb a step's edge.

    The rear stands on upright flippers as high as it can be, and leaves the floor: only belts on
    the top pull, and the edge meets the hubs below their axles, or above on a step (m) that is
    higher. `edge_grip` is the factor on the friction of belts at an edge.
    """
    steepest = math.asin((_UPRIGHT - height) / AXLE_HEIGHT) + math.atan(edge_grip * friction)
    return 1.0 / (1.0 + friction * math.tan(steepest))


def share_at_edge(height: float, center: Sequence[float]) -> float:
    """Share of the weight that the front hubs bear there, by the centre of mass (m)."""
    rise = math.asin((height + AXLE_HEIGHT - _UPRIGHT) / (2.0 * PIVOT))
    back = math.sqrt(AXLE_HEIGHT**2 - (_UPRIGHT - height) ** 2)
    over = (PIVOT + center[0]) * math.cos(rise) - center[2] * math.sin(rise) - back
    return over / (2.0 * PIVOT * math.cos(rise) - back)


def turning(spots: np.ndarray, loads: np.ndarray, along: float, across: float) -> Turning:
    """Where a robot turns whose belts run against each other; friction `along`, `across` them.

    Raises
    ------
    ValueError
        It cannot turn: one side bears so much that the other only pushes.
    """

    def left_over(unknown: np.ndarray) -> np.ndarray:
        forward, sideways, belts = unknown
        slip = forward - spots[:, 1] + belts * np.sign(spots[:, 1])
        drift = sideways + spots[:, 0]
        size = np.sqrt((along * slip) ** 2 + (across * drift) ** 2 + 1e-12)
        push, pull = -loads * along**2 * slip / size, -loads * across**2 * drift / size
        moment = spots[:, 0] * pull - spots[:, 1] * push
        return np.array([push.sum(), pull.sum(), moment.sum()]) / loads.sum()

    center = loads @ spots[:, :2] / loads.sum()
    candidates: List[Tuple[float, np.ndarray]] = []
    for begin in (0.0, -center[0], -2.0 * center[0]):
        for belts in (0.3, 0.6, 1.0):
            candidates.append(_root(left_over, np.array([0.0, begin, belts])))
    error, best = min(candidates, key=lambda each: each[0])
    if error > 1e-6 or best[2] > 3.0:
        raise ValueError("it cannot turn in place")
    return Turning(-float(best[1]), float(best[0]), float(best[2]))


def _root(
    function: Callable[[np.ndarray], np.ndarray], start: np.ndarray
) -> Tuple[float, np.ndarray]:
    """Newton's method with steps that lessen the error; the error that is left, and where."""
    where, value = start, function(start)
    for _ in range(200):
        slopes = np.stack(
            [(function(where + d) - function(where - d)) / 2e-6 for d in 1e-6 * np.eye(3)], axis=1
        )
        step = np.linalg.lstsq(slopes, -value, rcond=None)[0]
        share = min(1.0, 0.2 / max(1e-12, np.abs(step).max()))
        while share > 1e-6:
            there = function(where + share * step)
            if np.linalg.norm(there) < np.linalg.norm(value):
                break
            share *= 0.5
        else:
            break
        where, value = where + share * step, there
    return float(np.linalg.norm(value)), where
