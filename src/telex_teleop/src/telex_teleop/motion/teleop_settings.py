"""Parameters that every teleoperation node has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from telex_control.common.params import require_range
from telex_teleop.motion.speed import SpeedScale

__all__ = ["TeleopSettings"]


@dataclass(frozen=True)
class TeleopSettings:
    """What the joint nodes and the track node have in common.

    Attributes
    ----------
    command_timeout
        Age (s) at which a command that is not repeated ends.
    longest_step
        Joint states further apart than this (s of sim time) start everything anew.
    status_rate
        Status messages per second of wall time.
    min_speed_scale, max_speed_scale
        Bounds of the operator's speed.
    initial_speed_scale
        First value of it; None for the largest.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is out of range.
    """

    command_timeout: float = 0.28
    longest_step: float = 0.5
    status_rate: float = 10.0
    min_speed_scale: float = 0.05
    max_speed_scale: float = 1.0
    initial_speed_scale: Optional[float] = None

    def __post_init__(self) -> None:
        require_range(self, "command_timeout", above=0.0, maximum=0.3)
        require_range(self, "longest_step", above=0.0)
        require_range(self, "status_rate", above=0.0, maximum=100.0)
        require_range(self, "min_speed_scale", above=0.0, maximum=1.0)
        require_range(self, "max_speed_scale", self.min_speed_scale, 1.0)
        require_range(self, "initial_speed_scale", self.min_speed_scale, self.max_speed_scale)

    def speed_scale(self) -> SpeedScale:
        """Return the operator's speed as it is at first."""
        initial = self.initial_speed_scale
        return SpeedScale(
            self.max_speed_scale if initial is None else initial,
            self.min_speed_scale,
            self.max_speed_scale,
        )
