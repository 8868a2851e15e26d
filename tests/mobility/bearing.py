"""What each belt bears, and where the robot turns: measured, and beside `quasi_static`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import pybullet

from telex_sim.contacts import contacts
from telex_sim.world import GRAVITY

from . import quasi_static
from .offline import Trial
from .quasi_static import Turning
from .scripted_operator import TICK

ARMS: Dict[str, Dict[str, float]] = {
    "folded": {"turret": 0.0, "shoulder": -2.897, "elbow": 2.906, "wrist_pitch": -2.199},
    "ahead": {"turret": 0.0, "shoulder": -1.2, "elbow": 1.2, "wrist_pitch": 0.0},
    "aside": {"turret": 1.57, "shoulder": -1.2, "elbow": 1.2, "wrist_pitch": 0.0},
}
"""Arm; ahead, the tool is 1.17 m before base_link."""
LOADS = (0.0, 2.0, 5.0)
"""Held in the gripper (kg)."""
FLAT, RAISED = (0.0, 0.0), (1.2, 1.2)
GROUNDS = ("plane", "slope", "edge")
_SLOPE = math.radians(15.0)
_PLATE = 0.02
"""Height of the plate on which the front half stands, across its edge (m)."""


@dataclass(frozen=True)
class Bearing:
    """Loads of the belts' halves over the robot's weight.

    Attributes
    ----------
    measured, expected : ndarray, shape (8,)
        Of each belt, front left to rear right: its half at the hub, then all four at the tip.
    """

    measured: np.ndarray
    expected: np.ndarray

    @property
    def error(self) -> float:
        """Of the half that is furthest off."""
        return float(np.abs(self.measured - self.expected).max())

    @property
    def total_error(self) -> float:
        """Of the sum of all."""
        return float(abs(self.measured.sum() / self.expected.sum() - 1.0))


def stand(
    arm: str, load: float, flippers: Sequence[float], ground: str = "plane", **options: Any
) -> Trial:
    """A robot that has come to rest; close it when done.

    Parameters
    ----------
    arm : str
        Of `ARMS`.
    load : float
        kg.
    flippers : sequence of 2 floats
        Front and rear (rad).
    ground : str
        Of `GROUNDS`; a slope of 15 degrees uphill.
    **options
        See `Trial`.
    """
    objects: List[Dict[str, Any]] = []
    if ground == "edge":
        objects = [
            {
                "type": "platform",
                "name": "plate",
                "position": [1.5, 0.0, 0.0],
                "length": 3.0,
                "width": 2.0,
                "height": _PLATE,
            }
        ]
    trial = Trial(objects, {"x": -1.2}, pose="look_front", load=load, **options)
    operator = trial.operator
    if ground == "edge":
        # Onto it until its edge is under the belly.
        operator.flippers(0.3, 0.0)
        operator.wait(1.0)
        operator.drive(0.3)
        operator.until(lambda: operator.pose.x > -0.05, 10.0, "half onto the plate")
        operator.stop()
    if ground == "slope":
        gravity = [GRAVITY * part for part in _uphill()]
        pybullet.setGravity(*gravity, physicsClientId=trial.simulation.body.client)
    operator.move(**ARMS[arm])
    operator.flippers(*flippers)
    operator.wait(6.0)
    return trial


def _uphill() -> Tuple[float, float, float]:
    """Direction of gravity on the slope, seen by a robot that looks uphill."""
    return -math.sin(_SLOPE), 0.0, -math.cos(_SLOPE)


def center_of_mass(trial: Trial) -> Tuple[float, np.ndarray]:
    """Mass (kg) and centre (m, in base_link) of the robot with its load, from their links."""
    body, client = trial.simulation.body, trial.simulation.body.client
    total, moment = 0.0, np.zeros(3)
    for uid in trial.simulation.world.bodies():
        for index in range(-1, pybullet.getNumJoints(uid, physicsClientId=client)):
            mass = pybullet.getDynamicsInfo(uid, index, physicsClientId=client)[0]
            if index < 0:
                at = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)[0]
            else:
                at = pybullet.getLinkState(uid, index, physicsClientId=client)[0]
            total += mass
            moment += mass * np.array(at)
    inverse = pybullet.invertTransform(*body.base_pose())
    return total, np.array(
        pybullet.multiplyTransforms(*inverse, moment / total, (0.0, 0.0, 0.0, 1.0))[0]
    )


def expected(trial: Trial, flat: bool, ground: str = "plane") -> Tuple[np.ndarray, np.ndarray]:
    """Places where it bears (n, 3) and their loads (N), from springs alone."""
    mass, center = center_of_mass(trial)
    spots = quasi_static.places(flat)
    down = _uphill() if ground == "slope" else (0.0, 0.0, -1.0)
    plate = _PLATE if ground == "edge" else 0.0
    loads = quasi_static.spring_loads(
        spots,
        trial.simulation.config.tracks.contact_stiffness,
        mass * GRAVITY,
        center,
        lambda x: plate if x > 0.0 else 0.0,
        down,
    )
    return spots, loads


def _halves(spots: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Sum up loads at places (m) by the belts' halves; what is between counts to both."""
    found = np.zeros(8)
    between = quasi_static.ON_FLAT_FLIPPERS[1]
    for (x, y, *_), load in zip(spots, loads):
        belt = (0 if x > 0.0 else 2) + (0 if y > 0.0 else 1)
        away = abs(x) - between
        tip = 0.5 if abs(away) < 0.05 else float(away > 0.0)
        found[belt] += (1.0 - tip) * load
        found[belt + 4] += tip * load
    return found


class _Scales:
    """Mean loads of the belts' halves over some steps."""

    def __init__(self, trial: Trial) -> None:
        self._trial = trial
        self._sum, self._steps = np.zeros(8), 0
        trial.each_step.append(self._look)

    def _look(self) -> None:
        body = self._trial.simulation.body
        inverse = pybullet.invertTransform(*body.base_pose())
        found = list(contacts(body))
        spots = [
            pybullet.multiplyTransforms(*inverse, contact.point, (0.0, 0.0, 0.0, 1.0))[0]
            for contact in found
        ]
        self._sum += _halves(np.array(spots), np.array([contact.force for contact in found]))
        self._steps += 1

    def mean(self) -> np.ndarray:
        """End, and return them (N)."""
        self._trial.each_step.remove(self._look)
        return self._sum / self._steps


def at_rest(trial: Trial, flat: bool, ground: str = "plane") -> Bearing:
    """Loads over a second of rest."""
    scales = _Scales(trial)
    trial.operator.wait(1.0)
    weight = center_of_mass(trial)[0] * GRAVITY
    if ground == "slope":
        weight *= math.cos(_SLOPE)
    return Bearing(scales.mean() / weight, _halves(*expected(trial, flat, ground)) / weight)


@dataclass(frozen=True)
class Quarter:
    """A quarter turn in place.

    Attributes
    ----------
    turned : float
        How far it came (rad).
    farthest : float
        base_link, from where it was (m).
    theory : Turning, optional
        None where statics say that it cannot turn.
    bearing : Bearing
        Over the turn.
    """

    turned: float
    farthest: float
    theory: Optional[Turning]
    bearing: Bearing

    @property
    def error(self) -> float:
        """Of the farthest place, beside theory's (m)."""
        assert self.theory is not None
        return abs(self.farthest - self.theory.farthest(self.turned))


def quarter_turn(trial: Trial, rate: float, flat: bool) -> Quarter:
    """Turn in place by 90 degrees, at a yaw rate (rad/s)."""
    operator, tracks = trial.operator, trial.simulation.config.tracks
    spots, loads = expected(trial, flat)
    try:
        theory: Optional[Turning] = quasi_static.turning(
            spots, loads, tracks.friction, tracks.lateral_friction
        )
    except ValueError:
        theory = None
    scales, begin = _Scales(trial), trial.position()
    turned = farthest = 0.0
    last = operator.pose.yaw
    operator.drive(0.0, rate)
    for _ in range(round(3.0 * 0.5 * math.pi / abs(rate) / TICK)):
        operator.tick()
        turned += math.remainder(operator.pose.yaw - last, 2.0 * math.pi)
        last = operator.pose.yaw
        farthest = max(farthest, float(np.linalg.norm((trial.position() - begin)[:2])))
        if abs(turned) >= 0.5 * math.pi:
            break
    weight = center_of_mass(trial)[0] * GRAVITY
    bearing = Bearing(scales.mean() / weight, _halves(spots, loads) / weight)
    return Quarter(turned, farthest, theory, bearing)
