"""Stopping at full speed: how soon, how far, and how near to tipping over."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple

import numpy as np
import pybullet

from telex_sim.engine.world import GRAVITY
from telex_sim.stability.monitor import StabilityMonitor
from telex_training.operators.port import NotManagedError
from telex_training.operators.terrain.slope import Slope
from telex_training.operators.terrain.stairs import Stairs, start_climb, start_descent

from ..flat import FLAT
from ..offline import OfflineTrial
from .load import POSE, hold_forward

STANDS = 0.02
"""Speed (m/s) below which the robot is at rest."""
WATCHED = 2.0
"""Time (s) that a stop is looked at."""
LOOK, WINDOW = 0.02, 0.1
"""How often the margin is taken, and the time of which forces of inertia in it are the means (s).

Single impacts, as of hubs on stairs, tip nothing over; ``sim/stability`` smooths them away, too.
"""
LOAD = 5.0
"""kg."""

SLOPE = Slope(math.radians(30.0), length=10.0)
LOW, HIGH = 2.0, 6.0
"""Where on the slope a drive up, and one down begin (m)."""
RUN_UP = 1.6
"""Time (s) of the drive before."""

BELTS = ("left", "right")


@dataclass(frozen=True)
class Stop:
    """What a stop was like; times (s) and the way (m) count from the last command.

    Attributes
    ----------
    braked : float
        Until the belts were told to run slower.
    stood : float
        Until the hull was at rest, and stayed so.
    way : float
        Of base_link.
    margin : float
        Least tip-over margin.
    rest : float
        Tip-over margin in the end, at rest.
    """

    braked: float
    stood: float
    way: float
    margin: float
    rest: float


class _Monitor(StabilityMonitor):
    """Counts a load that is fixed to the gripper, and touches nothing, as one that is gripped."""

    def __init__(self, trial: OfflineTrial) -> None:
        super().__init__(trial.simulation.robots[0])
        self._trial = trial
        self._load_moves: Optional[Tuple[float, np.ndarray]] = None

    def _contacts(
        self, centers: np.ndarray, rotations: np.ndarray
    ) -> Tuple[List, List[Tuple[np.ndarray, np.ndarray]]]:
        supports, pushes = super()._contacts(centers, rotations)
        trial = self._trial
        if trial.load is None:
            return supports, pushes
        client, time = trial.simulation.body.client, trial.simulation.time
        place = pybullet.getBasePositionAndOrientation(trial.load, physicsClientId=client)[0]
        velocity = np.array(pybullet.getBaseVelocity(trial.load, physicsClientId=client)[0])
        force = np.array([0.0, 0.0, -GRAVITY])
        if self._load_moves is not None:
            before, last = self._load_moves
            force -= (velocity - last) / (time - before)
        self._load_moves = (time, velocity)
        mass = pybullet.getDynamicsInfo(trial.load, -1, physicsClientId=client)[0]
        return supports, [*pushes, (np.array(place), mass * force)]


class StoppingWatch:
    """Looks at a trial from now on.

    Parameters
    ----------
    trial : OfflineTrial
        With the robot level, in its start pose.
    """

    def __init__(self, trial: OfflineTrial) -> None:
        self._trial = trial
        # In turn: each gives the mean since it was asked last.
        self._monitors = [_Monitor(trial) for _ in range(round(WINDOW / LOOK))]
        self._looks = 0

    def stop(self, end: Callable[[OfflineTrial], None]) -> Stop:
        """Look at a stop.

        Parameters
        ----------
        end : callable
            Sends the last command, and lets a moment pass.

        Raises
        ------
        NotManagedError
            The robot does not stand in the end, or lies.
        """
        trial = self._trial
        began, place = trial.simulation.time, trial.position()
        speeds = self._belt_speeds()
        self._margins: List[float] = []
        self._moved = began
        self._braked = math.inf

        def look() -> None:
            now = trial.simulation.time
            if float(np.linalg.norm(trial.velocity()[0])) >= STANDS:
                self._moved = now
            if math.isinf(self._braked) and np.any(np.abs(self._belt_speeds() - speeds) > 1e-6):
                self._braked = now
            if round(now / trial.step_size) % round(LOOK / trial.step_size) == 0:
                monitor = self._monitors[self._looks % len(self._monitors)]
                self._looks += 1
                monitor.observe(now)
                self._margins.append(monitor.margin(now).margin)

        trial.each_step.append(look)
        end(trial)
        trial.operator.say_nothing(WATCHED)
        trial.each_step.remove(look)
        if self._monitors[0].tipped or trial.simulation.time - self._moved < 0.1:
            raise NotManagedError(f"does not stand; {trial.operator.where()}")
        return Stop(
            self._braked - began,
            self._moved - began,
            float(np.linalg.norm(trial.position() - place)),
            # The first ones are of what was before.
            min(self._margins[len(self._monitors) :]),
            self._margins[-1],
        )

    def _belt_speeds(self) -> np.ndarray:
        hw = self._trial.simulation.hw
        return np.array([hw.drive(f"front_{side}_track_joint").handle.command for side in BELTS])


def fall_silent(trial: OfflineTrial) -> None:
    """Send the speed a last time, and then nothing."""
    trial.operator.tick()


def close(trial: OfflineTrial) -> None:
    """Send the stop that stands for a closed connection, once."""
    trial.operator.stop()
    trial.operator.tick()


def on_level(
    pose: str, speed: float, end: Callable[[OfflineTrial], None] = fall_silent, rate: float = 0.0
) -> Stop:
    """Stop on level ground from a speed (m/s), or a turn (rad/s)."""
    with OfflineTrial(start={"x": math.copysign(2.0, -speed)}, pose=pose) as trial:
        watch = StoppingWatch(trial)
        trial.operator.drive(speed, rate)
        trial.operator.wait(RUN_UP)
        return watch.stop(end)


def with_load(speed: float, flippers: Tuple[float, float]) -> Stop:
    """Stop on level ground, the arm stretched out with 5 kg."""
    with OfflineTrial(start={"x": math.copysign(2.0, -speed)}, pose=POSE, load=LOAD) as trial:
        watch = StoppingWatch(trial)
        hold_forward(trial.operator)
        trial.operator.flippers(*flippers)
        trial.operator.wait(1.0)
        trial.operator.drive(speed)
        trial.operator.wait(RUN_UP)
        return watch.stop(fall_silent)


def on_slope(
    heading: float, speed: float, flippers: Optional[Tuple[float, float]], loaded: bool = False
) -> Stop:
    """Stop on a slope of 30 degrees, with 5 kg far out or empty; see `Slope.pose`.

    None leaves the flippers as in `drive`.
    """
    pose, load = (POSE, LOAD) if loaded else ("drive", 0.0)
    with OfflineTrial(SLOPE.objects(), {"x": -2.0}, pose=pose, load=load) as trial:
        watch = StoppingWatch(trial)
        if loaded:
            hold_forward(trial.operator)
        if flippers is not None:
            trial.operator.flippers(*flippers)
            trial.operator.wait(0.8)
        up = speed * math.cos(heading)
        position, orientation = SLOPE.pose(LOW if up > 0.0 else HIGH, heading)
        # So that its whole way is on the slope.
        position[1] -= math.copysign(1.5 * math.sin(heading), speed)
        trial.place(position, orientation)
        trial.operator.wait(0.6)
        trial.operator.drive(speed)
        trial.operator.wait(RUN_UP)
        return watch.stop(fall_silent)


def up_stairs(speed: float, stairs: Stairs) -> Stop:
    """Stop half-way on stairs, going up, or backwards down again."""
    with OfflineTrial(stairs.objects(), {"x": stairs.foot - 1.2}, stairs.friction) as trial:
        watch, operator = StoppingWatch(trial), trial.operator
        start_climb(operator)
        operator.flippers(0.02, -0.03)
        middle = 0.5 * (stairs.foot + stairs.crest)
        operator.until(lambda: operator.pose.x > middle, 20.0, "half-way")
        operator.keep_lane(speed)
        operator.wait(0.8)
        return watch.stop(fall_silent)


def down_stairs(speed: float, stairs: Stairs) -> Stop:
    """Stop on stairs, going down forwards."""
    start = {"x": stairs.edge - 1.2, "ground": stairs.height}
    with OfflineTrial(stairs.objects(), start, stairs.friction) as trial:
        watch, operator = StoppingWatch(trial), trial.operator
        start_descent(operator, stairs)
        middle = 0.5 * (stairs.edge + stairs.end)
        operator.until(lambda: operator.pose.x > middle, 20.0, "half-way")
        operator.keep_lane(speed)
        operator.wait(0.8)
        return watch.stop(fall_silent)


FLIGHT = Stairs(0.18, 0.28)
RAISED = (0.60, 0.35)
HARD: Dict[str, Callable[[], Stop]] = {
    **{
        f"30 deg, {way}, {name}": lambda heading=heading, speed=speed, flippers=flippers: on_slope(
            heading, speed, flippers
        )
        for name, flippers in (("flippers flat", FLAT), ("flippers raised", None))
        for way, heading, speed in (
            ("up", 0.0, 1.0),
            ("down", math.pi, 1.0),
            ("backwards up", math.pi, -1.0),
            ("backwards down", 0.0, -1.0),
            ("45 deg off uphill", 0.25 * math.pi, 1.0),
            ("45 deg off downhill", 0.75 * math.pi, 1.0),
        )
    },
    **{
        f"30 deg, {way}, flippers flat, arm out, 5 kg": lambda heading=heading: on_slope(
            heading, 1.0, FLAT, loaded=True
        )
        for way, heading in (
            ("up", 0.0),
            ("down", math.pi),
            ("45 deg off uphill", 0.25 * math.pi),
            ("45 deg off downhill", 0.75 * math.pi),
        )
    },
    "30 deg, across, flippers flat": lambda: on_slope(0.5 * math.pi, 1.0, FLAT),
    "stairs 18x28 cm, up, 0.35 m/s": lambda: up_stairs(0.35, FLIGHT),
    "stairs 18x28 cm, backwards down, 0.35 m/s": lambda: up_stairs(-0.35, FLIGHT),
    "stairs 18x28 cm, down, 0.35 m/s": lambda: down_stairs(0.35, FLIGHT),
    **{
        f"arm out, 5 kg, {name}, {way}": lambda speed=speed, flippers=flippers: with_load(
            speed, flippers
        )
        for name, flippers in (("flippers flat", FLAT), ("flippers raised", RAISED))
        for way, speed in (("forwards", 1.0), ("backwards", -1.0))
    },
}
"""Stops at 1 m/s unless the name says otherwise, by what is hard about them."""
