"""Driving by preset keys alone: one is held at a time, and no flipper is moved by hand."""

from __future__ import annotations

import abc
import math
from typing import Any, Callable, NamedTuple

from .scripted_operator import Operator
from .terrain.stairs import SLOW, SPEED, Stairs, stand_on_landing
from .terrain.step import Step, beyond, stand_on_top

STEADY = 0.25  # m/s
_PATIENCE = 1.5
"""How long somebody looks at a robot that does not come on (s)."""
_FREED = 0.10
"""How far a robot has come that no longer hangs on an edge (m)."""


class Stage(NamedTuple):
    """What is to be reached, within which time (s), and what it is called."""

    reached: Callable[[], bool]
    timeout: float
    what: str


class PresetKeys(abc.ABC):
    """Holds one preset key at a time.

    Parameters
    ----------
    operator : Operator
        Drives; the key is held at each of its looks.
    """

    def __init__(self, operator: Operator) -> None:
        self.operator = operator

    @abc.abstractmethod
    def hold(self, preset: str) -> None:
        """Hold a preset's key from now on; empty: let go of it."""

    @abc.abstractmethod
    def look(self) -> None:
        """Repeat the key that is held."""

    def until(self, reached: Any, timeout: float, what: str) -> None:
        """Go on until something is reached; see `Operator.until`."""
        self.operator.until(reached, timeout, what, self.look)

    def wait(self, seconds: float) -> None:
        """Go on for so much sim time (s)."""
        end = self.operator.time + seconds
        self.until(lambda: self.operator.time >= end, 2.0 * seconds, "the time")

    def work_on(
        self, reached: Any, timeout: float, what: str, *presets: str, freed: float = math.inf
    ) -> None:
        """Go on with the first of some presets, and with the next where the robot hangs.

        Once it has come on by `freed` (m) since, with the first again.
        """
        operator, turn = self.operator, 0
        best, since = operator.pose.x, operator.time
        hung = best

        def look_on() -> None:
            nonlocal best, since, turn, hung
            if operator.pose.x > best + 0.02:
                best, since = operator.pose.x, operator.time
            elif operator.time - since > _PATIENCE:
                turn, since, hung = turn + 1, operator.time, best
            if turn and best > hung + freed:
                turn = 0
            self.hold(presets[turn % len(presets)])
            self.look()

        operator.until(reached, timeout, what, look_on)


def climb_step(keys: PresetKeys, step: Step) -> None:
    """Climb a step of 50 cm by presets.

    Raises
    ------
    NotManagedError
    """
    operator = keys.operator
    _climb(
        keys,
        STEADY,
        Stage(lambda: operator.pose.rise > 0.35, 20.0, "the nose up by 20 deg"),
        Stage(lambda: beyond(operator, step) > -0.15, 15.0, "the front over the edge"),
        Stage(
            lambda: beyond(operator, step) > 0.35 and abs(operator.pose.rise) < 0.3,
            20.0,
            "the rear up",
        ),
    )
    stand_on_top(operator, step, keys.look)


def climb_stairs(keys: PresetKeys, stairs: Stairs) -> None:
    """Climb stairs onto the landing by presets.

    Raises
    ------
    NotManagedError
    """
    operator = keys.operator
    _climb(
        keys,
        SPEED,
        Stage(lambda: operator.pose.rise > 0.25, 20.0, "the front on the first step"),
        Stage(lambda: operator.pose.x > stairs.crest - 0.32, 40.0, "the crest"),
        Stage(
            lambda: operator.pose.x > stairs.crest + 0.3 and abs(operator.pose.rise) < 0.2,
            25.0,
            "over the crest",
        ),
    )
    stand_on_landing(operator, stairs, keys.look)


def _climb(
    keys: PresetKeys, speed: float, front_up: Stage, at_the_edge: Stage, over: Stage
) -> None:
    """Put the front up, drive flat to the edge, lift the rear after it, and drive on."""
    keys.operator.keep_lane(speed)
    keys.work_on(*front_up, "approach", "drive")
    keys.hold("flat")
    keys.until(*at_the_edge)
    keys.work_on(*over, "climb", "flat")
    keys.hold("drive")


def descend_stairs(keys: PresetKeys, stairs: Stairs) -> None:
    """Go on from the landing down to the floor by presets.

    Raises
    ------
    NotManagedError
    """
    operator = keys.operator
    operator.keep_lane(SLOW)
    keys.work_on(
        lambda: operator.pose.x > stairs.edge + 0.4,
        40.0,
        "over the edge",
        "descend",
        "climb",
        freed=_FREED,
    )
    keys.hold("descend")
    operator.keep_lane(SPEED)
    keys.until(lambda: operator.pose.x > stairs.end, 40.0, "the last steps")
    keys.hold("drive")
    keys.until(
        lambda: operator.pose.x > stairs.end + 0.7 and abs(operator.pose.rise) < 0.15,
        15.0,
        "on the floor",
    )
    operator.stop()
    keys.wait(0.4)
