"""Random commands over rough ground: whatever happens, the simulation has to stay sane."""

from __future__ import annotations

import math
import random
import time
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

from telex_training.operators.port import NotManagedError
from telex_training.operators.scripted_operator import FRONT_FLIPPERS, REAR_FLIPPERS, TICK

from .balance.falls import Fall, FallWatch
from .offline import OfflineTrial
from .watch import RunWatch

_COMMAND = 1.0
"""How long a command stands (s)."""
_LYING, _RAISED = 4.0, (0.5, 0.5)
"""How long the robot lies before it is put on its tracks (s); by then its flippers are up."""
_EDGE = 4.0
"""From the middle to the walls (m)."""


@dataclass(frozen=True)
class Behaviour:
    """What a run has shown.

    Attributes
    ----------
    jump, gain, fastest, deepest : float
        See `watch.Watch`.
    rated : float
        Most that the drives could add to the energy in a step (J).
    cpu : float
        CPU time per sim time, in the worst second.
    falls : int
        How often it lay on its side or back, and was put on its tracks again.
    seen : tuple of Fall
        Those of them that began on its tracks.
    """

    finite: bool
    jump: float
    gain: float
    rated: float
    fastest: float
    deepest: float
    cpu: float
    falls: int
    seen: Tuple[Fall, ...]


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
    seconds : float
        Of sim time.
    """
    numbers = random.Random(seed)
    with OfflineTrial(
        rough_ground(), {"x": 0.0, "y": 0.0, "yaw": 6.28 * numbers.random()}, step_size=step_size
    ) as trial:
        watch, fall_watch = RunWatch(trial), FallWatch(trial)
        seen: List[Fall] = []
        operator = trial.operator
        falls, lain, worst = 0, 0.0, 0.0
        began = time.process_time() - watch.cost - fall_watch.cost
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
                fall = fall_watch.fall()
                if fall is not None:
                    seen.append(fall)
                trial.place((0.0, 0.0, 0.35), (0.0, 0.0, 0.0, 1.0))
                watch.restart()
                fall_watch.restart()
            if (tick + 1) % round(1.0 / TICK) == 0:
                now = time.process_time() - watch.cost - fall_watch.cost
                worst, began = max(worst, now - began), now
        return Behaviour(
            watch.finite,
            watch.jump,
            watch.gain,
            rated_power(trial) * step_size,
            watch.fastest,
            watch.deepest,
            worst,
            falls,
            tuple(seen),
        )


def rated_power(trial: OfflineTrial) -> float:
    """Of all drives together (W)."""
    simulation = trial.simulation
    tracks = simulation.config.tracks
    hw = simulation.hw
    joints = [hw.drive(name) for name in hw.joint_positions() if name not in tracks.belts]
    of_joints = sum(drive.max_effort * drive.max_velocity for drive in joints)
    return of_joints + len(tracks.drives) * tracks.drive.power
