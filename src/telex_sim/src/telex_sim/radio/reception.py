"""Strength of a radio signal by its distance and what stands in between."""

from __future__ import annotations

import math
from typing import Collection, Dict, NamedTuple, Sequence

import numpy as np
import pybullet

from .radio_config import RadioConfig

NEAREST = 1.0
"""Distance (m) below which the signal grows no stronger."""

MOST_WALLS = 8
"""Bodies that are looked for on the way; with so many nothing is left of any signal."""

_BEHIND = 1e-3
"""Way (m) past a surface from which the next one is looked for."""


class Signal(NamedTuple):
    """A radio signal as it is received.

    Attributes
    ----------
    distance : float
        m.
    walls : int
        Bodies on the way.
    power : float
        dBm.
    quality : float
        0 to 1.
    """

    distance: float
    walls: int
    power: float
    quality: float


def signal_of(config: RadioConfig, distance: float, thicknesses: Sequence[float]) -> Signal:
    """Return the signal at a distance, behind bodies.

    Parameters
    ----------
    distance : float
        m.
    thicknesses : sequence of float
        Of the bodies on the way (m).
    """
    power = config.power - 10.0 * config.exponent * math.log10(max(distance, NEAREST))
    for thickness in thicknesses:
        loss = config.wall_loss + config.wall_loss_per_metre * thickness
        power -= min(loss, config.most_wall_loss)
    quality = (power - config.lost) / (config.good - config.lost)
    return Signal(distance, len(thicknesses), power, min(max(quality, 0.0), 1.0))


def thicknesses_between(
    client: int, begin: Sequence[float], end: Sequence[float], ignored: Collection[int]
) -> Sequence[float]:
    """Return how thick the bodies are between two points (m), each from its first to last surface.

    Parameters
    ----------
    client : int
        Of PyBullet.
    begin, end : sequence of float
        In the world (m).
    ignored : collection of int
        Bodies that do not count.
    """
    way = float(np.linalg.norm(np.subtract(end, begin)))
    if way < _BEHIND:
        return ()
    entered = _first_surfaces(client, begin, end, ignored)
    left = _first_surfaces(client, end, begin, ignored)
    # One in which an end lies has no surface on that side.
    return [max(way - left.get(body, 0.0) - depth, 0.0) for body, depth in entered.items()]


def _first_surfaces(
    client: int, begin: Sequence[float], end: Sequence[float], ignored: Collection[int]
) -> Dict[int, float]:
    """Return the bodies on a ray, and how far from its begin (m) each is met first."""
    start, way = np.array(begin, dtype=float), np.subtract(end, begin)
    length = float(np.linalg.norm(way))
    ahead, depth = way / length, 0.0
    found: Dict[int, float] = {}
    # Each body has two surfaces on the way at least, and may have more.
    for _ in range(4 * MOST_WALLS):
        origin = start + depth * ahead
        ((body, _, share, _, _),) = pybullet.rayTest(origin, end, physicsClientId=client)
        if body < 0 or len(found) >= MOST_WALLS:
            break
        depth += share * (length - depth) + _BEHIND
        if body not in ignored:
            found.setdefault(body, depth - _BEHIND)
        if depth >= length:
            break
    return found
