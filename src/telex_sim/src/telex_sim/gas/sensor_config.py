"""Parameters of a robot's gas sensor."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import LEAST_RATE, Declared, number, parameter


@dataclass(frozen=True)
class GasSensorConfig(Declared):
    """The gas sensor of a robot; see config/simulator.yaml."""

    rate: float = number(
        5.0, "How often it is read, in scenes with leaks (Hz of sim time).", LEAST_RATE, 50.0
    )
    link: str = parameter("", "In whose origin it sits; a robot without that link has none.")
    response: float = number(
        1.0, "Time constant with which its reading follows the gas (s).", 0.0, 1000.0
    )
