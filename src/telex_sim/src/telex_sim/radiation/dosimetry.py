"""Doses that places on a robot receive, and how much its cameras and electronics bear."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Collection, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from telex_control.common.params import LEAST_RATE, Declared, number, parameter, require, required
from telex_control.common.stateful import Stateful

ROBOT = "robot"
"""Name of the hull's place among those with a history of dose."""
MOST_GRAYS = 1.0e5
_HOUR = 3600.0


def require_history(history: Mapping[str, float]) -> None:
    """Raise a `ConfigError` unless all doses (Gy) of a history are possible."""
    for name, dose in history.items():
        require(
            0.0 <= dose <= MOST_GRAYS,
            f"history/{name} is {dose} Gy; 0 to {MOST_GRAYS:g} is possible",
        )


@dataclass(frozen=True)
class Collimator(Declared):
    """Shield around a detector, open along an axis.

    What comes at the angle a from the axis counts by leak + (1 - leak) 2^-(a / half_angle)^2.
    """

    half_angle: float = number(
        0.35, "From the axis, at which the opening passes half (rad).", 0.01, 3.2
    )
    leak: float = number(0.05, "Share that passes the shield from all around.", 0.0, 1.0)

    def response(self, ways: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Share that counts of what comes from sources.

        Parameters
        ----------
        ways : numpy.ndarray
            From the detector to the sources, shape (S, 3) (m).
        axis : numpy.ndarray
            Unit vector, shape (3,).

        Returns
        -------
        numpy.ndarray
            Shape (S,).
        """
        along = ways @ axis
        across = np.linalg.norm(ways - along[:, None] * axis, axis=1)
        angles = np.arctan2(across, along)
        opening: np.ndarray = (1.0 - self.leak) * 2.0 ** -((angles / self.half_angle) ** 2)
        return self.leak + opening


@dataclass(frozen=True)
class Electronics(Declared):
    """Electronics that die of dose, and with them the drives of joints."""

    link: str = parameter(required, "In whose origin they receive it.")
    joints: Tuple[str, ...] = parameter(required, "Whose brakes hold from then on.")
    life: float = number(
        300.0, "Dose at which they die, in the mean (Gy).", maximum=MOST_GRAYS, above=0.0
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(bool(self.link), "link is ''; a link is needed")


@dataclass(frozen=True)
class DosimetryConfig(Declared):
    """Where a robot's dose is measured, and what it does."""

    rate: float = number(
        10.0,
        "How often the field is computed, in scenes with sources (Hz of sim time); every second "
        "time it is told.",
        LEAST_RATE,
        100.0,
    )
    hull: str = parameter(
        "",
        "Link in whose origin the dosimeter measures; empty, or of another robot: the root link.",
    )
    tool: str = parameter("", "Another one; empty, or of another robot: none.")
    detector: str = parameter(
        "",
        "Link of a shielded detector, which measures along its x axis, by `Collimator`; on a robot "
        "that has it, it takes the tool's place, and the dosimeter is read everywhere.",
    )
    collimator: Collimator = parameter(Collimator, "Shield of the detector.")
    alarm_rate: float = number(
        1.0,
        "Dose rate of hull or tool from which the dosimeter warns (Gy/h).",
        0.0,
        MOST_GRAYS,
    )
    alarm_dose: float = number(10.0, "Dose of the hull from which it warns (Gy).", 0.0, MOST_GRAYS)
    history: Dict[str, float] = parameter(
        dict,
        "Doses received before (Gy), by the name of a camera, or ``robot``; a scene may say more.",
    )
    camera_life: float = number(
        88.0, "Dose at which a camera dies, in the mean (Gy).", maximum=MOST_GRAYS, above=0.0
    )
    electronics: Dict[str, Electronics] = parameter(
        dict, "By name; those whose link a robot lacks are left out."
    )
    spread: float = number(
        0.3,
        "Share of a life by which lives differ at most, evenly spread: each camera's and each "
        "electronics' is by its name and the seed.",
        0.0,
        0.99,
    )
    seed: int = number(0, "See `spread`.", 0)

    def check(self) -> None:
        """Check what concerns single ones in a way of its own; see `Declared.check`."""
        require_history(self.history)
        require(
            ROBOT not in self.electronics,
            f"electronics has '{ROBOT}', which is the hull's name; another one is needed",
        )

    def lacking(self, links: Collection[str]) -> List[str]:
        """Name the links in which it is to measure and which are not among those of a robot."""
        return [link for link in (self.hull, self.tool) if link and link not in links]

    def life(self, component: str, electronics: bool = False) -> float:
        """Dose (Gy) at which a camera, or electronics, die."""
        mean = self.electronics[component].life if electronics else self.camera_life
        generator = np.random.default_rng((self.seed, zlib.crc32(component.encode())))
        return mean * (1.0 + self.spread * float(generator.uniform(-1.0, 1.0)))


class Doses(Stateful):
    """Doses of several places, summed up over time.

    Parameters
    ----------
    received : sequence of float
        Before (Gy), one for each place.

    Attributes
    ----------
    rates : numpy.ndarray
        Those of the last look (Gy/h).
    doses : numpy.ndarray
        Until then (Gy).
    """

    SAVED = ("doses", "rates")
    SAVED_TIMES = ("_time",)

    def __init__(self, received: Sequence[float]) -> None:
        self.doses = np.array(received, dtype=float)
        self.rates = np.zeros(len(self.doses))
        self._time: Optional[float] = None

    def receive(self, rates: np.ndarray, time: float) -> None:
        """Take note of the rates (Gy/h) at a sim time (s); between looks they change evenly."""
        if self._time is not None:
            hours = max(time - self._time, 0.0) / _HOUR
            self.doses += 0.5 * hours * (self.rates + rates)
        self.rates, self._time = rates, time
