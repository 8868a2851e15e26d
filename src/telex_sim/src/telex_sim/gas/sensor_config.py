"""Parameters of a robot's gas sensor."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import require_range


@dataclass(frozen=True)
class GasSensorConfig:
    """The gas sensor of a robot; see config/simulator.yaml.

    Attributes
    ----------
    rate : float
        How often it is read, in scenes with leaks (Hz of sim time).
    link : str
        In whose origin it sits; a robot without that link has none.
    response : float
        Time constant with which its reading follows the gas (s).
    """

    rate: float = 5.0
    link: str = ""
    response: float = 1.0

    def __post_init__(self) -> None:
        require_range(self, "rate", maximum=50.0, above=0.0)
        require_range(self, "response", 0.0, 1000.0)
