"""Load on each belt and centre of rotation: measured, and compared with `quasi_static`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import pybullet

from telex_control.common.file_catalog import package_yaml
from telex_sim.engine.contacts import contacts
from telex_sim.engine.simulation import Simulation
from telex_sim.engine.world import GRAVITY
from telex_training.operators.port import NotManagedError
from telex_training.operators.robot_size import AXLE_HEIGHT
from telex_training.operators.scripted_operator import TICK
from telex_training.operators.terrain.slope import Slope

from ..offline import OfflineTrial
from . import quasi_static
from .quasi_static import Turning

ARMS: Dict[str, Dict[str, float]] = {
    "folded": {
        "turret": 0.0,
        "shoulder": -2.897,
        "elbow": 2.906,
        "wrist_pitch": -2.199,
        "gripper_roll": -1.571,
    },
    "ahead": {"turret": 0.0, "shoulder": -1.2, "elbow": 1.2, "wrist_pitch": 0.0},
    "aside": {"turret": 1.57, "shoulder": -1.2, "elbow": 1.2, "wrist_pitch": 0.0},
}
"""Arm; ahead, the tool is 1.17 m before base_link."""
LOADS = (0.0, 2.0, 5.0)
"""Held in the gripper (kg)."""
FLAT, RAISED = (0.0, 0.0), (1.2, 1.2)
GROUNDS = ("plane", "slope", "edge")
CENTRED = 0.02
"""From base_link to the middle of a load that counts as centred, at most (m)."""
_SLOPE = Slope(math.radians(15.0))
_PLATE = 0.02
"""Height of the plate on which one half stands, across its edge (m)."""
_CRATES = [
    {"type": "crate", "name": f"crate_{number}", "position": [-3.0, 2.0 + number, 0.0]}
    for number in range(2)
]
_SETTLING = 1.6
"""After which loads and joints rest (s)."""


@dataclass(frozen=True)
class StartPose:
    """How a robot comes to stand where it stands.

    Attributes
    ----------
    heading : float
        Uphill or onto the plate is 0; at the edge it counts twice (rad).
    aside : float
        Of base_link, along x and y alike (m).
    drop : float
        Height over the ground (m).
    tilt : float
        Of roll and pitch (rad); with enough of a drop, it falls on a corner.
    lowered : float
        How far the flippers come down then (rad).
    driven : float
        How far it drives then (m).
    crates : bool
        Whether loose things were in the world before the ground.
    """

    heading: float = 0.0
    aside: float = 0.0
    drop: float = 0.0
    tilt: float = 0.0
    lowered: float = 0.0
    driven: float = 0.0
    crates: bool = False


STARTS = (
    StartPose(),
    StartPose(heading=0.5 * math.pi - 0.1, aside=0.01, drop=0.03, crates=True),
    StartPose(heading=math.pi + 0.1, aside=-0.02, drop=0.03, tilt=0.03),
    StartPose(heading=-0.5 * math.pi, lowered=0.25),
    StartPose(heading=0.1, aside=-0.05, driven=0.1, crates=True),
)


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

    @staticmethod
    def of(measured: np.ndarray, spots: np.ndarray, loads: np.ndarray) -> Bearing:
        """Take the belts' loads (N) and those of springs in places."""
        return Bearing(measured / loads.sum(), _halves(spots, loads) / loads.sum())

    @property
    def error(self) -> float:
        """Of the half that is furthest off."""
        return float(np.abs(self.measured - self.expected).max())

    @property
    def total_error(self) -> float:
        """Of the sum of all."""
        return float(abs(self.measured.sum() / self.expected.sum() - 1.0))


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

    def __str__(self) -> str:
        """Say it in a line."""
        theory = "" if self.theory is None else f" (theory {self.theory.farthest(self.turned):.3f})"
        return f"{self.farthest:.3f} m{theory} after {self.turned:.2f} rad"

    @property
    def error(self) -> float:
        """Of the farthest place, beside theory's (m)."""
        assert self.theory is not None
        return abs(self.farthest - self.theory.farthest(self.turned))


class Standing:
    """A robot that has come to rest; close it when done.

    Parameters
    ----------
    arm : str
        Of `ARMS`.
    load : float
        kg.
    flippers : sequence of 2 floats
        Front and rear (rad): `FLAT` or `RAISED`.
    ground : str
        Of `GROUNDS`; the slope has 15 degrees.
    **options
        See `Trial`.

    Raises
    ------
    ValueError
        It tips over, say statics.
    NotManagedError
        It tips over.
    """

    def __init__(
        self,
        arm: str,
        load: float,
        flippers: Sequence[float],
        ground: str = "plane",
        start: StartPose = STARTS[0],
        **options: Any,
    ) -> None:
        self._flat, self._ground = tuple(flippers) == FLAT, ground
        poses = _poses(arm, tuple(angle + start.lowered for angle in flippers))
        self.trial = trial = OfflineTrial(
            [*(_CRATES if start.crates else ()), *ground_objects(ground)],
            {"x": -3.0},
            pose=arm,
            load=load,
            start__poses=poses,
            **options,
        )
        try:
            trial.place(*_pose(ground, start))
            self.springs()
            self._come_to_rest(start, flippers)
        except (NotManagedError, ValueError):
            trial.simulation.close()
            raise

    def _come_to_rest(self, start: StartPose, flippers: Sequence[float]) -> None:
        operator = self.trial.operator
        if start.lowered:
            operator.wait(0.4)
            operator.flippers(*flippers)
            operator.wait(start.lowered)
        if start.driven:
            operator.wait(0.4)
            operator.drive(0.25)
            operator.wait(start.driven / 0.25)
            operator.stop()
        operator.wait(_SETTLING)

    def __enter__(self) -> Standing:
        return self

    def __exit__(self, *exception: object) -> None:
        """Release PyBullet."""
        self.trial.simulation.close()

    def contacts(self) -> Tuple[np.ndarray, np.ndarray]:
        """Places in which something touches it, in base_link (n, 3), and their loads (N)."""
        return touched(self.trial.simulation)

    def springs(self, spots: Optional[np.ndarray] = None) -> Tuple[np.ndarray, np.ndarray]:
        """Loads (N) of springs in places (n, 3), which are returned first.

        Parameters
        ----------
        spots : ndarray, shape (n, 3), optional
            In base_link; by default hubs, runs and tips.

        Raises
        ------
        ValueError
            It tips over.
        """
        if spots is None:
            spots = quasi_static.places(self._flat)
        simulation = self.trial.simulation
        stiffness = simulation.config.tracks.contact_stiffness
        held = [] if self.trial.load is None else [self.trial.load]
        return spots, springs(simulation, spots, stiffness, self._ground, held)

    @property
    def centred(self) -> bool:
        """Whether the middle of the load is near to base_link."""
        spots, loads = self.springs()
        return float(np.linalg.norm(loads @ spots[:, :2] / loads.sum())) <= CENTRED

    def at_rest(self) -> Tuple[Bearing, Bearing]:
        """Loads over a second of rest.

        Returns
        -------
        Bearing
            Beside springs where the belts have contacts: a hub that was set down on its belt's
            edge may have two or three.
        Bearing
            Beside one spring each in hubs, runs and tips.

        Raises
        ------
        ValueError
            It tips over, say statics.
        """
        touched, placed = self.springs(self.contacts()[0]), self.springs()
        scales = _Scales(self)
        self.trial.operator.wait(1.0)
        found = scales.mean()
        return Bearing.of(found, *touched), Bearing.of(found, *placed)

    def quarter_turn(self, rate: float) -> Quarter:
        """Turn in place by 90 degrees on level ground, at a yaw rate (rad/s), and stop."""
        trial = self.trial
        operator, tracks = trial.operator, trial.simulation.config.tracks
        spots, loads = self.springs()
        try:
            theory: Optional[Turning] = quasi_static.turning(
                spots, loads, tracks.friction, tracks.lateral_friction
            )
        except ValueError:
            theory = None
        scales, begin = _Scales(self), trial.position()
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
        bearing = Bearing.of(scales.mean(), spots, loads)
        operator.stop()
        operator.wait(0.6)
        return Quarter(turned, farthest, theory, bearing)


def touched(simulation: Simulation) -> Tuple[np.ndarray, np.ndarray]:
    """Places in which something touches a robot, in its root link (n, 3), and their loads (N)."""
    body = simulation.body
    inverse = pybullet.invertTransform(*body.base_pose())
    found = list(contacts(body))
    spots = [
        pybullet.multiplyTransforms(*inverse, contact.point, (0.0, 0.0, 0.0, 1.0))[0]
        for contact in found
    ]
    return np.array(spots), np.array([contact.force for contact in found])


def springs(
    simulation: Simulation,
    spots: np.ndarray,
    stiffness: float,
    ground: str,
    held: Sequence[int] = (),
) -> np.ndarray:
    """Loads (N) of springs under a robot that stands on one of the grounds.

    Parameters
    ----------
    spots : ndarray, shape (n, 3)
        Of the springs, in the root link (m).
    stiffness : float
        Of each (N/m).
    ground : str
        Of `GROUNDS`.
    held : sequence of int
        Further bodies that it carries (PyBullet's numbers).

    Raises
    ------
    ValueError
        It tips over.
    """
    mass, center = _center_of_mass(simulation, held)
    (x, _, _), orientation = simulation.body.base_pose()
    rotation = np.reshape(pybullet.getMatrixFromQuaternion(orientation), (3, 3))
    steepness = _SLOPE.angle if ground == "slope" else 0.0
    uphill = np.array([math.cos(steepness), 0.0, math.sin(steepness)])
    # Heading within the ground, whatever the body's lean.
    cosine, sine = uphill @ rotation[:, 0], rotation[1, 0]
    length = math.hypot(cosine, sine)
    cosine, sine = cosine / length, sine / length
    along = -math.sin(steepness)
    plate = _PLATE if ground == "edge" else 0.0
    return quasi_static.spring_loads(
        spots,
        stiffness,
        mass * GRAVITY,
        center,
        lambda ahead, left: plate if x + cosine * ahead - sine * left > 0.0 else 0.0,
        (along * cosine, -along * sine, -math.cos(steepness)),
    )


def _center_of_mass(simulation: Simulation, held: Sequence[int]) -> Tuple[float, np.ndarray]:
    """Mass (kg) and centre (m, in the root link) of the robot with its load, from their links."""
    body = simulation.body
    client = body.client
    total, moment = 0.0, np.zeros(3)
    for uid in (body.uid, *held):
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


def _shipped_poses() -> Dict[str, Dict[str, float]]:
    poses: Dict[str, Dict[str, float]] = package_yaml("telex_description", "config", "poses.yaml")[
        "poses"
    ]
    return poses


def _poses(arm: str, flippers: Sequence[float]) -> Dict[str, Dict[str, float]]:
    """Named poses, with one of this arm and these flippers (rad, front and rear)."""
    pose = dict(_shipped_poses()["look_front"])
    pose.update({f"{joint}_joint": angle for joint, angle in ARMS[arm].items()})
    for end, angle in zip(("front", "rear"), flippers):
        pose.update({f"{end}_{side}_flipper_joint": angle for side in ("left", "right")})
    return {**_shipped_poses(), arm: pose}


def ground_objects(ground: str) -> List[Dict[str, Any]]:
    """Entries of a scene file."""
    if ground == "slope":
        return _SLOPE.objects()
    if ground == "edge":
        size = {"length": 3.0, "width": 4.0, "height": _PLATE}
        return [{"type": "platform", "name": "plate", "position": [1.5, 0.0, 0.0], **size}]
    return []


def _pose(ground: str, start: StartPose) -> Tuple[Sequence[float], Sequence[float]]:
    """Of base_link: position (m) and quaternion (x, y, z, w)."""
    if ground == "slope":
        origin = _SLOPE.pose(4.0, start.heading)
    else:
        height = AXLE_HEIGHT + (_PLATE if ground == "edge" else 0.0)
        # Twice the heading at the edge, which no belt stands along then.
        half = start.heading if ground == "edge" else 0.5 * start.heading
        origin = [0.0, 0.0, height], [0.0, 0.0, math.sin(half), math.cos(half)]
    tilt = pybullet.getQuaternionFromEuler((start.tilt, start.tilt, 0.0))
    pose: Tuple[Sequence[float], Sequence[float]] = pybullet.multiplyTransforms(
        *origin, (start.aside, start.aside, start.drop), tilt
    )
    return pose


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

    def __init__(self, standing: Standing) -> None:
        self._standing = standing
        self._sum, self._steps = np.zeros(8), 0
        standing.trial.each_step.append(self._look)

    def _look(self) -> None:
        self._sum += _halves(*self._standing.contacts())
        self._steps += 1

    def mean(self) -> np.ndarray:
        """End, and return them (N)."""
        self._standing.trial.each_step.remove(self._look)
        return self._sum / self._steps
