"""A battery that runs down, and the power that a robot takes from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, NamedTuple, Tuple

from telex_control.common.params import require_range
from telex_control.common.stateful import Stateful

from ..robot.drives import Drive

_HOUR = 3600.0
DRIVES, LAMPS, CAMERAS = "drives", "lamps", "cameras"
"""What an empty battery feeds no longer."""


@dataclass(frozen=True)
class BatteryConfig:
    """The battery of a robot, and what takes power beside its drives.

    Attributes
    ----------
    energy : float
        Of a full charge (Wh).
    voltage, empty_voltage : float
        Of a full and of an empty battery without load (V).
    resistance : float
        Ohm.
    base_power : float
        Of computers, radio and cameras (W).
    lamp_power : float
        Of each lamp at full level (W).
    efficiency : float
        Mechanical power over electrical power of a drive.
    holding_power : float
        Of a drive that gives its largest effort at rest (W); it grows with the effort's square.
    camera_reserve : float
        For how long the cameras' own cells feed them once the battery is empty (s).
    averaging : float
        Over which the power is averaged that the runtime is told by (s).
    """

    energy: float = 900.0
    voltage: float = 29.4
    empty_voltage: float = 21.0
    resistance: float = 0.05
    base_power: float = 90.0
    lamp_power: float = 12.0
    efficiency: float = 0.65
    holding_power: float = 60.0
    camera_reserve: float = 60.0
    averaging: float = 20.0

    def __post_init__(self) -> None:
        require_range(self, "energy", maximum=1.0e5, above=0.0)
        require_range(self, "empty_voltage", maximum=1.0e3, above=0.0)
        require_range(self, "voltage", self.empty_voltage, 1.0e3)
        for name in ("base_power", "lamp_power", "holding_power"):
            require_range(self, name, 0.0, 1.0e5)
        require_range(self, "resistance", 0.0, 10.0)
        require_range(self, "efficiency", 0.05, 1.0)
        require_range(self, "camera_reserve", 0.0, 3600.0)
        require_range(self, "averaging", 0.1, 3600.0)

    def drive_power(self, drives: Iterable[Drive]) -> float:
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


class Battery(Stateful):
    """A battery that runs down.

    Parameters
    ----------
    config : BatteryConfig
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
