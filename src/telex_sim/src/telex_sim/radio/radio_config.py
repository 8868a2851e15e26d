"""Parameters of the radio signal."""

from __future__ import annotations

from dataclasses import dataclass

from telex_control.common.params import require_range


@dataclass(frozen=True)
class RadioConfig:
    """The radio between robot and operator; see config/simulator.yaml.

    Attributes
    ----------
    rate : float
        How often it is computed while somebody listens (Hz of sim time); 0: never.
    antenna_height : float
        Of the operator's antenna above the robot's start, in scenes that have no `antenna` (m).
    robot_height : float
        Of the robot's antenna above its root link (m).
    power : float
        Received at a distance of 1 m (dBm).
    exponent : float
        Of the path loss: 2 in free space, up to 4 among walls.
    wall_loss : float
        Of each body that stands in between (dB), however thin.
    wall_loss_per_metre : float
        Of its thickness, besides (dB/m).
    most_wall_loss : float
        Of one body (dB): waves find ways around it.
    lost, good : float
        Power at which the quality is 0 and 1 (dBm).

    Raises
    ------
    telex_control.common.params.ConfigError
    """

    rate: float = 4.0
    antenna_height: float = 1.5
    robot_height: float = 0.6
    power: float = -40.0
    exponent: float = 2.5
    wall_loss: float = 3.0
    wall_loss_per_metre: float = 25.0
    most_wall_loss: float = 25.0
    lost: float = -90.0
    good: float = -60.0

    def __post_init__(self) -> None:
        require_range(self, "rate", 0.0, 50.0)
        require_range(self, "antenna_height", 0.0, 100.0)
        require_range(self, "robot_height", 0.0, 10.0)
        require_range(self, "power", -120.0, 30.0)
        require_range(self, "exponent", 1.0, 6.0)
        for name in ("wall_loss", "wall_loss_per_metre", "most_wall_loss"):
            require_range(self, name, 0.0, 1000.0)
        require_range(self, "lost", -150.0, 30.0)
        require_range(self, "good", above=self.lost)
