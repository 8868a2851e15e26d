"""Exposure of one robot in a simulation to radiation, and its doses."""

from __future__ import annotations

import logging
import math
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.stateful import Stateful

from ..radiation.dosimetry import ROBOT, Doses, DosimetryConfig
from ..robot.robot import Robot
from ..scene.objects.irradiation import SceneField
from .simulation import Simulation

_log = logging.getLogger("rosout")


class ComponentReading(NamedTuple):
    """Of one part: dose rate (Gy/h), dose (Gy), and whether it has died of it."""

    name: str
    dose_rate: float
    dose: float
    failed: bool


class Readings(NamedTuple):
    """What a dosimeter and the parts of a robot would tell.

    Attributes
    ----------
    hull_rate, tool_rate : float
        Gy/h; that of the tool is nan where the robot has none that measures.
    detector : str
        Link of the shielded detector that measures the tool's rate; empty: it has no shield.
    total : float
        Of the hull (Gy).
    alarm : bool
        A rate or the total is above what the dosimeter warns of.
    """

    hull_rate: float
    tool_rate: float
    detector: str
    total: float
    alarm: bool
    cameras: Tuple[ComponentReading, ...]
    electronics: Tuple[ComponentReading, ...]

    @property
    def components(self) -> Tuple[ComponentReading, ...]:
        """All parts whose dose is known: the hull, cameras, electronics."""
        hull = ComponentReading(ROBOT, self.hull_rate, self.total, False)
        return (hull, *self.cameras, *self.electronics)


class Exposure(Stateful):
    """Sums up what a robot receives; in the simulation's thread.

    As a watcher of the robot it goes back to a bookmark with it: doses are of the world's history.

    The brakes of drives whose electronics have died of it hold until the doses are set back.

    Nothing is computed in scenes that have neither sources nor a history of dose, but for a robot
    with a detector, whose dosimeter is read everywhere.

    Parameters
    ----------
    find_cameras : callable
        Gives the parameters of the robot's cameras by name, as those of the ``cameras`` node: their
        optical frames are what counts. It is asked whenever a scene begins that needs them.
    """

    def __init__(self, robot: Robot, find_cameras: Callable[[], Any]) -> None:
        self._robot = robot
        self._find_cameras = find_cameras
        self._begun = -1
        self._cameras: List[str] = []
        self._electronics: List[str] = []
        self._lives: Dict[str, float] = {}
        self._links: List[str] = []
        self._doses: Optional[Doses] = None
        self._detector = ""
        self._dead: List[str] = []

    def save_state(self) -> Any:
        """Return the present state; None before the first look, and where nothing is told."""
        doses = self._doses
        if doses is None:
            return None
        # What is taken up is replaced, never changed; `_dead` grows.
        parts = self._cameras, self._electronics, self._lives, self._links, self._detector
        return parts, list(self._dead), doses.save_state()

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again; see `Stateful.restore_state`."""
        self._doses, self._begun = None, -1  # it begins anew, with what was received before
        if saved is None:
            return
        self._begun = self._robot.starts
        parts, dead, doses = saved
        self._cameras, self._electronics, self._lives, self._links, self._detector = parts
        self._dead = list(dead)
        self._doses = Doses([0.0] * len(self._links))
        self._doses.restore_state(doses, elapsed)

    def observe(self, simulation: Simulation) -> Optional[Readings]:
        """Expose the robot to the field until now.

        Returns
        -------
        Readings, optional
            None where there is nothing to tell; when that begins, all is told as 0 once.
        """
        field = simulation.radiation
        if self._begun != self._robot.starts:
            before = self._doses
            self._begin(simulation, field)
            if self._doses is None and before is not None:
                return self._told(Doses([0.0] * len(self._links)))
        if self._doses is None:
            if field is None:
                return None
            self._take_up({})
        assert self._doses is not None
        self._doses.receive(self._rates(field), simulation.time)
        return self._told(self._doses)

    def _told(self, doses: Doses) -> Readings:
        """Make the readings of doses, and let what has died be dead."""
        readings = self._readings(doses)
        self._tell_of_dead(readings)
        self._robot.hw.set_dead(dead_joints(readings, self._robot.config.dosimetry))
        return readings

    def _begin(self, simulation: Simulation, field: Optional[SceneField]) -> None:
        """Set the doses back to what configuration and scene say of before."""
        self._begun = self._robot.starts
        history = {**self._robot.config.dosimetry.history, **simulation.scene.history}
        self._doses = None
        detector = self._robot.config.dosimetry.detector
        if field is not None or history or detector in self._robot.body.link_names():
            self._take_up(history)

    def _take_up(self, history: Mapping[str, float]) -> None:
        robot, dosimetry = self._robot, self._robot.config.dosimetry
        links = set(robot.body.link_names())
        cameras = _frames(self._find_cameras())
        electronics = {name: each.link for name, each in dosimetry.electronics.items()}
        self._cameras = [name for name, frame in cameras.items() if frame in links]
        self._electronics = [
            name
            for name, link in electronics.items()
            if link in links and name not in self._cameras
        ]
        mortal = [*self._cameras, *self._electronics]
        places = {**electronics, **{name: cameras[name] for name in self._cameras}}
        self._lives = {name: dosimetry.life(name, name in self._electronics) for name in mortal}
        hull = dosimetry.hull if dosimetry.hull in links else robot.body.base_link
        self._links = [hull, *(places[name] for name in mortal)]
        received = [history.get(name, 0.0) for name in (ROBOT, *mortal)]
        self._detector = dosimetry.detector if dosimetry.detector in links else ""
        if self._detector or dosimetry.tool in links:
            self._links.append(self._detector or dosimetry.tool)
            received.append(0.0)
        self._doses, self._dead = Doses(received), []
        for name in self._cameras:
            if electronics.get(name) in links:
                _log.warning(
                    "dosimetry: electronics '%s' of %s are left out; camera '%s' has their name, "
                    "and another one is needed",
                    name,
                    robot.model,
                    name,
                )
        for link in dosimetry.lacking(links):
            _log.warning(
                "dosimetry: %s has no link '%s'; the root link counts, and no tool",
                robot.model,
                link,
            )
        unknown = sorted(set(history) - {ROBOT, *mortal})
        if unknown:
            _log.warning(
                "%s: history has %s, which this robot lacks; it has %s",
                robot.model,
                ", ".join(unknown),
                ", ".join([ROBOT, *mortal]),
            )

    def _rates(self, field: Optional[SceneField]) -> np.ndarray:
        if field is None:
            return np.zeros(len(self._links))
        poses = [self._robot.body.pose(link) for link in self._links]
        rates = field.source_rates(np.array([position for position, _ in poses]))
        if self._detector:
            position, orientation = poses[-1]
            axis = rotation_matrix(orientation)[:, 0]
            ways = field.source_positions - np.array(position)
            rates[:, -1] *= self._robot.config.dosimetry.collimator.response(ways, axis)
        return rates.sum(axis=0)

    def _readings(self, doses: Doses) -> Readings:
        rates, received = doses.rates.tolist(), doses.doses.tolist()
        dosimetry, mortal = self._robot.config.dosimetry, list(self._lives)
        tool = rates[-1] if len(rates) > 1 + len(mortal) else math.nan
        # A tool that measures nothing is nan, which is above nothing.
        high = any(rate > dosimetry.alarm_rate for rate in (rates[0], tool))
        parts = [
            ComponentReading(name, rate, dose, dose >= self._lives[name])
            for name, rate, dose in zip(mortal, rates[1:], received[1:])
        ]
        return Readings(
            rates[0],
            tool,
            self._detector,
            received[0],
            high or received[0] > dosimetry.alarm_dose,
            tuple(parts[: len(self._cameras)]),
            tuple(parts[len(self._cameras) :]),
        )

    def _tell_of_dead(self, readings: Readings) -> None:
        for kind, parts in (("camera", readings.cameras), ("electronics", readings.electronics)):
            for part in parts:
                if part.failed and part.name not in self._dead:
                    self._dead.append(part.name)
                    _log.warning(
                        "%s: %s %s has died, of %.1f Gy",
                        self._robot.model,
                        kind,
                        part.name,
                        part.dose,
                    )


def dead_joints(readings: Readings, config: DosimetryConfig) -> List[str]:
    """Name the joints whose electronics have died."""
    return [
        joint
        for part in readings.electronics
        if part.failed
        for joint in config.electronics[part.name].joints
    ]


def _frames(described: Any) -> Dict[str, str]:
    """Optical frames by the cameras' names, in alphabetical order, of all that is described so."""
    if not isinstance(described, Mapping):
        return {}
    return {
        name: camera["frame"]
        for name, camera in sorted(described.items())
        if isinstance(camera, Mapping) and isinstance(camera.get("frame"), str)
    }
