"""The obstacles that the robot has to pass, and the script for each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional, Tuple, Union

from telex_training.operators.port import NotManagedError
from telex_training.operators.scripted_operator import Operator
from telex_training.operators.terrain import gap, hurdle, rough, slope, stairs, step

from .balance import load
from .offline import OfflineTrial


@dataclass(frozen=True)
class Obstacle:
    """One obstacle.

    Attributes
    ----------
    objects : list of dict
        Entries of a scene file.
    script : callable
        Drives over it; raises `NotManagedError`.
    start : dict
        Of the scene file.
    friction : float
        Of the floor.
    prepare : callable, optional
        What the operator does before the time counts.
    pose : str
        Named pose to start in.
    load : float
        Mass in the gripper (kg).
    within : float, optional
        Time that is allowed (s).
    """

    name: str
    objects: List[Dict[str, Any]]
    script: Callable[[Operator], None]
    start: Dict[str, float]
    friction: float = 1.0
    prepare: Optional[Callable[[Operator], None]] = None
    pose: str = "drive"
    load: float = 0.0
    within: Optional[float] = None

    def trial(self, **changes: Any) -> OfflineTrial:
        """Put the robot before it."""
        return OfflineTrial(
            self.objects, self.start, self.friction, pose=self.pose, load=self.load, **changes
        )


@dataclass(frozen=True)
class Attempted:
    """How it went.

    Attributes
    ----------
    time : float
        Sim time that it took, or until it was given up (s).
    message : str
        Why it was not passed.
    """

    passed: bool
    time: float
    message: str = ""


def attempt(obstacle: Obstacle, operator: Operator) -> Attempted:
    """Let an operator try an obstacle."""
    began = operator.time
    try:
        if obstacle.prepare is not None:
            obstacle.prepare(operator)
            began = operator.time
        obstacle.script(operator)
    except NotManagedError as error:
        return Attempted(False, operator.time - began, str(error))
    taken = operator.time - began
    if obstacle.within is not None and taken > obstacle.within:
        return Attempted(False, taken, f"took {taken:.1f} s of {obstacle.within:g} s")
    return Attempted(True, taken)


def up_and_down(flight: stairs.Stairs, name: str) -> Obstacle:
    """Stairs up, over the landing, and down."""

    def script(operator: Operator) -> None:
        stairs.climb(operator, flight)
        stairs.descend(operator, flight)

    start = {"x": flight.foot - 1.2}
    return Obstacle(name, flight.objects(), script, start, flight.friction)


def step_up(
    block: step.Step, name: str, load_mass: float = 0.0, arm_forward: bool = False
) -> Obstacle:
    """A step, perhaps with the arm, or a load, held forward."""
    forward = arm_forward or load_mass > 0.0
    return Obstacle(
        name,
        block.objects(),
        lambda operator: step.climb(operator, block),
        {"x": block.edge - 1.0},
        block.friction,
        prepare=load.hold_forward if forward else None,
        pose=load.POSE if forward else "drive",
        load=load_mass,
        within=20.0,
    )


def _over(barrier: hurdle.Hurdle) -> Obstacle:
    name = f"hurdle {100 * barrier.height:.0f} cm"
    if barrier.length < hurdle.Hurdle.length:
        name += f", {100 * barrier.length:.0f} cm long"
    return Obstacle(
        name,
        barrier.objects(),
        lambda operator: hurdle.cross(operator, barrier),
        {"x": barrier.edge - 1.0},
        barrier.friction,
    )


def _ramp(degrees: float, friction: float) -> Obstacle:
    plane = slope.Slope(math.radians(degrees), friction=friction)

    def script(operator: Operator) -> None:
        slope.drive_up(operator, plane, 0.5, 1.5)

    return Obstacle(f"ramp {degrees:.0f} deg", plane.objects(), script, {}, friction)


def _rough(name: str, ground: Union[rough.CrossingRamps, rough.Stepfield]) -> Obstacle:
    def script(operator: Operator) -> None:
        rough.cross(operator, ground.height, ground.end)

    return Obstacle(name, ground.objects(), script, {"x": rough.START - 1.2}, ground.friction)


STEPFIELDS = tuple(
    rough.Stepfield(pattern, seed=seed)
    for pattern, seeds in (("flat", (1, 2, 3)), ("hill", (1, 2, 5)), ("diagonal", (1, 2, 8)))
    for seed in seeds
)
"""Three fields of each pattern; the last seeds are those of the scene ``mobility_lane``."""

RAMPS = (rough.CrossingRamps(rows=4), rough.CrossingRamps(rows=6))
"""As the library has them by default, and those of the scene ``mobility_lane``."""


def all_obstacles() -> List[Obstacle]:
    """All of them, in the order of the table."""
    platforms = gap.Gap()
    flights = [
        ("stairs 17x28 cm", stairs.Stairs(0.17, 0.28)),
        ("stairs 18x28 cm", stairs.Stairs(0.18, 0.28)),
        ("stairs 20x25 cm", stairs.Stairs(0.20, 0.25)),
        ("stairs 45 deg, mu 1.1", stairs.Stairs(0.20, 0.20, friction=1.1)),
    ]
    blocks: List[Tuple[str, step.Step]] = [
        ("step 50 cm, mu 1.0", step.Step()),
        ("step 50 cm, mu 0.8", step.Step(friction=0.8)),
        ("4 loose pallets, 50 cm", step.Step(pallets=4)),
    ]
    return [
        _ramp(30.0, 1.0),
        _ramp(45.0, 1.2),
        *(up_and_down(flight, name) for name, flight in flights),
        *(step_up(block, name) for name, block in blocks),
        *(step_up(block, f"{name}, 10 kg forward", load.MASS) for name, block in blocks),
        step_up(step.Step(0.45, 0.6), "step 45 cm, mu 0.6"),
        step_up(step.Step(0.55), "step 55 cm, arm forward", arm_forward=True),
        *(_over(hurdle.Hurdle(height)) for height in (0.1, 0.2, 0.3, 0.4, 0.5)),
        *(_over(hurdle.Hurdle(height, 0.2)) for height in (0.25, 0.5)),
        Obstacle("gap 40 cm", platforms.objects(), lambda op: gap.cross(op, platforms), {}),
        *(_rough(f"crossing ramps, {ramps.rows} rows", ramps) for ramps in RAMPS),
        *(_rough(f"stepfield {field.pattern}, seed {field.seed}", field) for field in STEPFIELDS),
    ]
