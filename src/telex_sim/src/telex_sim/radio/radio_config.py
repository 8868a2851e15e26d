"""Parameters of the radio signal."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import Declared, number, rate_or_never


@dataclass(frozen=True)
class RadioConfig(Declared):
    """The radio between robot and operator; see config/simulator.yaml.

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    rate: float = rate_or_never(
        4.0,
        "How often it is computed while somebody listens (Hz of sim time); 0: never.",
        50.0,
    )
    antenna_height: float = number(
        1.5,
        "Of the operator's antenna above the robot's start, in scenes that have no `antenna` (m).",
        0.0,
        100.0,
    )
    robot_height: float = number(0.6, "Of the robot's antenna above its root link (m).", 0.0, 10.0)
    power: float = number(-40.0, "Received at a distance of 1 m (dBm).", -120.0, 30.0)
    exponent: float = number(
        2.5, "Of the path loss: 2 in free space, up to 4 among walls.", 1.0, 6.0
    )
    wall_loss: float = number(
        3.0, "Of each body that stands in between (dB), however thin.", 0.0, 1000.0
    )
    wall_loss_per_metre: float = number(25.0, "Of its thickness, besides (dB/m).", 0.0, 1000.0)
    most_wall_loss: float = number(
        25.0, "Of one body (dB): waves find ways around it.", 0.0, 1000.0
    )
    lost: float = number(-90.0, "Power at which the quality is 0 (dBm).", -150.0, 30.0)
    good: float = number(
        -60.0, "Power at which the quality is 1 (dBm).", above=lambda own: own.lost
    )
