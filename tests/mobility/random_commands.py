"""Random commands over rough ground: whatever happens, the simulation has to stay sane."""

from __future__ import annotations

import math
import random
import time
from dataclasses import dataclass
from typing import Any, Dict, List

import numpy as np

from .offline import Trial
from .scripted_operator import FRONT_FLIPPERS, REAR_FLIPPERS, TICK, NotManagedError

_COMMAND = 1.0
"""How long a command stands (s)."""
_LOOK = 5
"""Steps from one look at the contacts to the next."""
_LYING, _RAISED = 4.0, (0.5, 0.5)
"""How long the robot lies before it is put on its tracks (s); by then its flippers are up."""
_EDGE = 4.0
"""From the middle to the walls (m)."""


@dataclass(frozen=True)
class Behaviour:
    """What a run has shown.

    Attributes
    ----------
    finite : bool
        Whether every state was a number.
    jump : float
        Farthest that the hull came in a step beyond what its velocity explains (m).
    fastest : float
        m/s.
    deepest : float
        Penetration of the robot into anything (m).
    cpu : float
        CPU time per sim time.
    falls : int
        How often it lay on its side or back, and was put on its tracks again.
    """

    finite: bool
    jump: float
    fastest: float
    deepest: float
    cpu: float
    falls: int


def rough_ground() -> List[Dict[str, Any]]:
    """Walled yard with posts, ramps, a hurdle, stairs and loose things."""
    walls = [
        {"type": "wall", "position": [x, y, 0.0], "yaw": yaw, "length": 8.2, "height": 1.0}
        for x, y, yaw in (
            (0.0, _EDGE, 0.0),
            (0.0, -_EDGE, 0.0),
            (_EDGE, 0.0, 0.5 * math.pi),
            (-_EDGE, 0.0, 0.5 * math.pi),
        )
    ]
    flight = {"steps": 3, "landing": 0.6, "form": "up_and_down", "railings": "none"}
    ground: List[Dict[str, Any]] = [
        {"type": "stepfield", "position": [1.6, 0.0, 0.0], "pattern": "flat", "seed": 3},
        {"type": "stepfield", "position": [1.6, 1.3, 0.0], "pattern": "hill", "seed": 5},
        {"type": "crossing_ramps", "position": [-1.9, 0.0, 0.0], "rows": 2, "length": 0.9},
        {"type": "hurdle", "position": [0.0, 1.6, 0.0], "height": 0.2},
        {"type": "hurdle", "position": [0.0, -1.6, 0.0], "height": 0.1, "edge": "pipe"},
        {"type": "stairs", "position": [2.4, -2.2, 0.0], **flight},
        {"type": "pallet", "position": [-2.0, 2.2, 0.0]},
        {"type": "crate", "position": [-2.0, -2.2, 0.0]},
        {"type": "pipe", "position": [0.0, -0.7, 0.0]},
    ]
    return [*walls, *ground]


def run(seed: int, seconds: float, step_size: float = 0.002) -> Behaviour:
    """Send random commands, a new one every second.

    A robot that has fallen is put on its tracks in the middle of the yard.

    Parameters
    ----------
    seed : int
    seconds : float
        Of sim time.
    """
    numbers = random.Random(seed)
    with Trial(
        rough_ground(), {"x": 0.0, "y": 0.0, "yaw": 6.28 * numbers.random()}, step_size=step_size
    ) as trial:
        watch = _Watch(trial)
        operator = trial.operator
        began = time.process_time()
        falls, lain = 0, 0.0
        for tick in range(round(seconds / TICK)):
            if lain == 0.0 and tick % round(_COMMAND / TICK) == 0:
                operator.drive(numbers.uniform(-1.2, 1.2), numbers.uniform(-1.0, 1.0))
                for name in (*FRONT_FLIPPERS, *REAR_FLIPPERS):
                    operator.move(**{name: numbers.uniform(-1.9, 1.9)})
            if lain:
                lain += TICK
            try:
                operator.tick()
            except NotManagedError:
                lain = lain or TICK
                operator.stop()
                operator.flippers(*_RAISED)
            if lain > _LYING:
                falls, lain = falls + 1, 0.0
                trial.place((0.0, 0.0, 0.35), (0.0, 0.0, 0.0, 1.0))
                watch.restart()
        cpu = (time.process_time() - began - watch.cost) / seconds
        return Behaviour(watch.finite, watch.jump, watch.fastest, watch.deepest, cpu, falls)


class _Watch:
    """Looks at every step of a trial."""

    def __init__(self, trial: Trial) -> None:
        self._trial = trial
        self._last = trial.center()
        self._steps = 0
        self.finite = True
        self.jump = self.fastest = self.deepest = self.cost = 0.0
        trial.each_step.append(self._look)

    def restart(self) -> None:
        """Take the present place for granted."""
        self._last = self._trial.center()

    def _look(self) -> None:
        began = time.process_time()
        trial = self._trial
        center, (velocity, turning) = trial.center(), trial.velocity()
        numbers = np.concatenate([center, velocity, turning])
        self.finite = self.finite and bool(np.isfinite(numbers).all())
        explained = trial.step_size * velocity
        self.jump = max(self.jump, float(np.linalg.norm(center - self._last - explained)))
        self.fastest = max(self.fastest, float(np.linalg.norm(velocity)))
        self._last = center
        self._steps += 1
        if self._steps % _LOOK == 0:
            self.deepest = max(self.deepest, trial.penetration())
        self.cost += time.process_time() - began
