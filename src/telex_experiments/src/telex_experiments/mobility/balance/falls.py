"""Falls, and how long before them the simulator warns: slow ones, and those of random commands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import process_time
from typing import Any, Dict, List, Optional, Tuple

from telex_sim.stability.monitor import Margin, StabilityMonitor
from telex_training.operators.port import NotManagedError
from telex_training.operators.robot_size import AXLE_HEIGHT
from telex_training.operators.scripted_operator import TICK, Operator
from telex_training.operators.terrain.slope import Slope

from ..offline import OfflineTrial

LOOK = 0.05
"""Time from one look at the robot's stability to the next (s), as the simulator's node has it."""
SUDDEN = 0.6
"""A fall is sudden where all of the tipping angle is lost in less than this (s)."""
WHOLE = math.radians(30.0)
"""Tipping angle from which all of it is still there; the robot on level ground has 38 degrees."""
_TIPPING = 1.2
"""Tilt (rad) beyond which a robot that has tipped over no longer comes back."""
_AWAY = -6.0
"""Where a robot starts that is put somewhere else at once (m)."""
_PLACE = 3.0
"""Where on a slope the robot is put (m)."""


@dataclass(frozen=True)
class Fall:
    """A fall, as it was seen.

    Attributes
    ----------
    time : float
        At which the centre of mass passed over the edge that the robot fell over (s).
    loss : float
        How long it took from the last moment with the whole tipping angle (s).
    warning : float
        How long before it there was a warning that stayed (s); 0 without one.
    """

    time: float
    loss: float
    warning: float


class FallWatch:
    """Looks at a trial's robot as the simulator's node does.

    Attributes
    ----------
    warned : float
        Time with a warning so far (s).
    cost : float
        CPU time that the looking itself took (s).
    """

    def __init__(self, trial: OfflineTrial) -> None:
        self._trial = trial
        self._monitor = StabilityMonitor(trial.simulation.robots[0])
        self._looks: List[Tuple[float, float, bool, float]] = []
        self._every = round(LOOK / trial.step_size)
        self._steps = 0
        self.warned = self.cost = 0.0
        trial.each_step.append(self._step)

    def _step(self) -> None:
        self._steps += 1
        if self._steps % self._every == 0:
            self._look()

    def _look(self) -> None:
        began = process_time()
        monitor, time = self._monitor, self._trial.simulation.time
        monitor.observe(time)
        angle, warned = _least(monitor.margin(time)), monitor.warning.warned
        self._looks.append((time, angle, warned, monitor.attitude.tilt))
        self.warned += LOOK * warned
        self.cost += process_time() - began

    @property
    def tipped(self) -> bool:
        """Whether the robot lies on its side or back."""
        return self._monitor.tipped

    def restart(self) -> None:
        """Begin anew, after the robot was put somewhere else."""
        self._looks.clear()

    def fall(self) -> Optional[Fall]:
        """Look back from a robot that has tipped over; None if it has not."""
        if not self.tipped:
            return None
        looks = self._looks
        end = len(looks) - 1
        while end > 0 and looks[end][3] > _TIPPING:
            end -= 1
        while end > 0 and looks[end][1] <= 0.0:
            end -= 1
        tip, begin = looks[end][0], end
        while begin > 0 and looks[begin][2]:
            begin -= 1
        whole = next((time for time, angle, _, _ in looks[end::-1] if angle >= WHOLE), -math.inf)
        return Fall(tip, tip - whole, tip - looks[begin + 1][0] if begin < end else 0.0)


def _least(margin: Margin) -> float:
    return (
        -math.inf if margin.tipping is None else min(margin.tipping.ahead, margin.tipping.sideways)
    )


@dataclass(frozen=True)
class SlowFall:
    """Something that slowly leads to a fall.

    Attributes
    ----------
    objects : list of dict
        Entries of a scene file.
    place : tuple, optional
        Position and quaternion of base_link; without it, the scene's start.
    load : float
        Mass in the gripper (kg).
    pose : str
        Named pose that the robot starts in.
    flippers : tuple of 2 floats
        Front and rear (rad).
    ways : dict of str to tuple of 3 floats
        Joints that move: from, to, and how fast (rad, rad/s).
    speed : float
        m/s.
    """

    objects: List[Dict[str, Any]]
    place: Optional[Tuple[List[float], List[float]]] = None
    load: float = 0.0
    pose: str = "look_front"
    flippers: Tuple[float, float] = (0.7, 0.7)
    ways: Dict[str, Tuple[float, float, float]] = field(default_factory=dict)
    speed: float = 0.0
    friction: float = 1.4

    def run(self, seconds: float = 25.0) -> Optional[Fall]:
        """Go on until the robot has fallen; None if it has not."""
        with OfflineTrial(self.objects, {"x": _AWAY}, self.friction, self.pose) as trial:
            if self.place is not None:
                trial.place(*self.place)
            if self.load:
                trial.hold(self.load)
            watch, operator = FallWatch(trial), trial.operator
            operator.flippers(*self.flippers)
            _go_on(operator, 1.0)
            operator.drive(self.speed)
            began = operator.time
            while operator.time - began < seconds and not watch.tipped:
                for joint, (start, end, rate) in self.ways.items():
                    way = min(abs(end - start), rate * (operator.time - began))
                    operator.move(**{joint: start + math.copysign(way, end - start)})
                _go_on(operator, TICK)
            return watch.fall()


def _go_on(operator: Operator, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        try:
            operator.tick()
        except NotManagedError:
            # A fall is what this is about.
            continue


def _on_slope(degrees: float, heading: float, **further: Any) -> SlowFall:
    slope = Slope(math.radians(degrees), friction=1.4)
    return SlowFall(slope.objects(), slope.pose(_PLACE, heading), **further)


def _over_side(height: float, yaw: float, y: float) -> SlowFall:
    """Drive so close along an edge that one belt leaves it."""
    wall = {
        "type": "wall",
        "position": [-1.0, 0.0, 0.0],
        "length": 2.4,
        "height": height,
        "thickness": 2.0,
    }
    turned = [0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)]
    place = ([-2.0, y, height + AXLE_HEIGHT + 0.005], turned)
    return SlowFall([wall], place, speed=0.12, pose="drive", flippers=(0.6, 0.6), friction=1.0)


_BACKWARDS = {"turret": (0.0, 3.1, 0.4), "shoulder": (-2.24, -1.6, 0.3), "elbow": (1.71, 1.6, 0.3)}
_FORWARDS = {"shoulder": (-2.9, -0.6, 0.35), "elbow": (2.9, 0.9, 0.3)}


def _sideways(side: float) -> Dict[str, Tuple[float, float, float]]:
    return {
        "turret": (0.0, 1.57 * side, 0.25),
        "shoulder": (-2.24, -1.1, 0.3),
        "elbow": (1.71, 1.3, 0.3),
    }


def slow_falls() -> Dict[str, SlowFall]:
    """Twelve of them: slopes, an arm far out, edges."""
    nothing: List[Dict[str, Any]] = []
    high = (-1.2, -1.2)
    return {
        "uphill 35 deg, 10 kg to the rear": _on_slope(35.0, 0.0, load=10.0, ways=_BACKWARDS),
        "uphill 38 deg, 8 kg to the rear": _on_slope(38.0, 0.0, load=8.0, ways=_BACKWARDS),
        "uphill 30 deg, 20 kg to the rear": _on_slope(30.0, 0.0, load=20.0, ways=_BACKWARDS),
        "downhill 35 deg, 10 kg ahead": _on_slope(
            35.0, math.pi, load=10.0, pose="drive", ways=_FORWARDS
        ),
        "downhill 30 deg, 15 kg ahead": _on_slope(
            30.0, math.pi, load=15.0, pose="drive", ways=_FORWARDS
        ),
        "across 20 deg, 20 kg downhill": _on_slope(
            20.0, 0.5 * math.pi, load=20.0, ways=_sideways(1.0)
        ),
        "across 20 deg, 20 kg downhill, other way": _on_slope(
            20.0, -0.5 * math.pi, load=20.0, ways=_sideways(-1.0)
        ),
        "on four tips, 25 kg to the left": SlowFall(
            nothing, load=25.0, flippers=high, ways=_sideways(1.0)
        ),
        "on four tips, 30 kg to the right": SlowFall(
            nothing, load=30.0, flippers=high, ways=_sideways(-1.0)
        ),
        "over an edge of 0.5 m, left belt first": _over_side(0.5, 0.25, 0.6),
        "over an edge of 0.5 m, right belt first": _over_side(0.5, -0.25, -0.6),
        "over an edge of 0.4 m, left belt first": _over_side(0.4, 0.2, 0.65),
    }
