"""A battery that runs down, and the power that a robot takes from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable, NamedTuple, Sequence, Tuple

from telex_control.common.params import Declared, number
from telex_control.common.stateful import Stateful

from ..robot.drives import JointDrive

_HOUR = 3600.0
_SLOWEST, _FASTEST = 0.02, 5.0
"""Speeds (m/s) of driving: what is slower stands, and what is faster was put there."""
_LEAST_CONSUMPTION = 1e-3
"""Of a robot that moves (J/m), where what it takes is not reckoned with or too little to tell."""
DRIVES, LAMPS, CAMERAS = "drives", "lamps", "cameras"
"""What an empty battery feeds no longer."""


@dataclass(frozen=True)
class BatteryConfig(Declared):
    """The battery of a robot, and what takes power beside its drives."""

    energy: float = number(900.0, "Of a full charge (Wh).", maximum=1.0e5, above=0.0)
    voltage: float = number(
        29.4,
        "Of a full battery without load (V).",
        lambda own: own.empty_voltage,
        1.0e3,
    )
    empty_voltage: float = number(
        21.0, "Of an empty battery without load (V).", maximum=1.0e3, above=0.0
    )
    resistance: float = number(0.05, "Ohm.", 0.0, 10.0)
    base_power: float = number(90.0, "Of computers, radio and cameras (W).", 0.0, 1.0e5)
    lamp_power: float = number(12.0, "Of each lamp at full level (W).", 0.0, 1.0e5)
    efficiency: float = number(
        0.65, "Mechanical power over electrical power of a drive.", 0.05, 1.0
    )
    holding_power: float = number(
        60.0,
        "Of a drive that gives its largest effort at rest (W); it grows with the effort's square.",
        0.0,
        1.0e5,
    )
    camera_reserve: float = number(
        60.0,
        "For how long the cameras' own cells feed them once the battery is empty (s).",
        0.0,
        3600.0,
    )
    averaging: float = number(
        20.0, "Over which the power is averaged that the runtime is told by (s).", 0.1, 3600.0
    )
    consumption: float = number(
        500.0,
        "By which the range is told before the robot has driven (J/m).",
        maximum=1.0e6,
        above=0.0,
    )
    averaging_way: float = number(
        20.0, "Over which the consumption is averaged that the range is told by (m).", 0.1, 1.0e4
    )

    def drive_power(self, drives: Iterable[JointDrive]) -> float:
        """Power that drives take now (W); what turns them back gives none."""
        total = 0.0
        for drive in drives:
            if drive.braked:
                continue
            effort, strongest = drive.state.effort, drive.rated_effort
            total += max(0.0, effort * drive.state.velocity) / self.efficiency
            if strongest > 0.0:
                total += self.holding_power * min(1.0, (effort / strongest) ** 2)
        return total


class Charge(NamedTuple):
    """What a battery tells.

    Attributes
    ----------
    share : float
        Of a full charge, 0 to 1.
    voltage : float
        V.
    current : float
        That it gives (A).
    capacity : float
        Of a full charge (A h).
    """

    share: float
    voltage: float
    current: float
    capacity: float


def charge_of(config: BatteryConfig, share: float, power: float) -> Charge:
    """Return what a battery tells at a share of its charge and a power (W)."""
    rest = config.empty_voltage + share * (config.voltage - config.empty_voltage)
    # One step from the voltage without load is near enough: its resistance is small.
    voltage = max(0.5 * config.empty_voltage, rest - config.resistance * power / rest)
    middle = 0.5 * (config.voltage + config.empty_voltage)
    return Charge(share, voltage, power / voltage, config.energy / middle)


class Reach(Stateful):
    """How far a charge lasts, by what the robot has taken for each metre of late."""

    SAVED = ("_consumption", "_place")
    SAVED_TIMES = ("_time",)

    def __init__(self, config: BatteryConfig) -> None:
        self._config = config
        self._consumption = config.consumption
        self._place: Tuple[float, ...] = ()
        self._time = 0.0

    def be_at(self, place: Sequence[float], power: float, time: float) -> None:
        """Take note of the robot's place (m) and of the power that it takes (W) at a time (s)."""
        before, self._place = self._place, tuple(place)
        period, self._time = time - self._time, time
        if period <= 0.0 or not before:
            return
        way = math.dist(before, self._place)
        if _SLOWEST * period <= way <= _FASTEST * period:
            weight = min(1.0, way / self._config.averaging_way)
            self._consumption += weight * (power * period / way - self._consumption)

    def of(self, share: float) -> float:
        """Way (m) that a share of a full charge is enough for."""
        return share * self._config.energy * _HOUR / max(self._consumption, _LEAST_CONSUMPTION)


class Battery(Stateful):
    """A battery that runs down.

    Parameters
    ----------
    share : float
        Of a full charge that it begins with.
    """

    SAVED = ("_empty_for", "_energy", "power")

    def __init__(self, config: BatteryConfig, share: float) -> None:
        self._config = config
        self._energy = share * config.energy * _HOUR
        self._empty_for = 0.0
        self.power = config.base_power

    @property
    def share(self) -> float:
        """Of a full charge."""
        return self._energy / (self._config.energy * _HOUR)

    def drain(self, power: float, period: float) -> None:
        """Give a power (W) for a period (s)."""
        if self._energy <= 0.0:
            self.power = 0.0
            self._empty_for += period
            return
        self.power += min(1.0, period / self._config.averaging) * (power - self.power)
        self._energy = max(0.0, self._energy - power * period)

    @property
    def unpowered(self) -> Tuple[str, ...]:
        """What gets no power."""
        if self._energy > 0.0:
            return ()
        spent = self._empty_for >= self._config.camera_reserve
        return (DRIVES, LAMPS, CAMERAS) if spent else (DRIVES, LAMPS)
