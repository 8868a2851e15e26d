"""Parameters that every teleoperation node has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from telex_control.common.params import Declared, number
from telex_teleop.motion.speed import SpeedScale


@dataclass(frozen=True)
class TeleopSettings(Declared):
    """What the joint nodes and the track node have in common.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is out of range.
    """

    command_timeout: float = number(
        0.28, "Age (s) at which a command that is not repeated ends.", maximum=0.3, above=0.0
    )
    longest_step: float = number(
        0.5,
        "Joint states further apart than this (s of sim time) start everything anew.",
        above=0.0,
    )
    status_rate: float = number(
        10.0, "Status messages per second of wall time.", maximum=100.0, above=0.0
    )
    min_speed_scale: float = number(
        0.05, "Least that the operator's speed can be.", maximum=1.0, above=0.0
    )
    max_speed_scale: float = number(
        1.0, "Most that it can be.", lambda own: own.min_speed_scale, 1.0
    )
    initial_speed_scale: Optional[float] = number(
        None,
        "First value of it; None for the largest.",
        lambda own: own.min_speed_scale,
        lambda own: own.max_speed_scale,
    )

    def speed_scale(self) -> SpeedScale:
        """Return the operator's speed as it is at first."""
        initial = self.initial_speed_scale
        return SpeedScale(
            self.max_speed_scale if initial is None else initial,
            self.min_speed_scale,
            self.max_speed_scale,
        )
