"""Configuration of a gripper's pads, and of the speed at which a grasp counts as slipping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Tuple

from telex_control.common.params import ConfigError, require, require_range


@dataclass(frozen=True)
class GripperContactConfig:
    """What is told of a gripper's contacts.

    Attributes
    ----------
    rate : float
        How often they are taken while somebody listens (Hz of sim time); 0: never.
    pads : tuple of str
        The links of both pads; none: there is no gripper.
    slip_speed : float
        Of what is held along a pad, from which it counts as slipping (m/s).
    stick_speed : float
        Below which it no longer does (m/s).
    """

    rate: float = 50.0
    pads: Tuple[str, ...] = ()
    slip_speed: float = 3e-3
    stick_speed: float = 1e-3

    def __post_init__(self) -> None:
        require_range(self, "rate", 0.0, 1000.0)
        require(
            len(self.pads) in (0, 2) and len(set(self.pads)) == len(self.pads),
            f"pads names {', '.join(self.pads)}; two links are needed, or none",
        )
        require_range(self, "slip_speed", maximum=1.0, above=0.0)
        require_range(self, "stick_speed", 0.0, self.slip_speed)

    def present(self, links: Collection[str], optional: Collection[str]) -> bool:
        """Whether a robot has this gripper.

        Parameters
        ----------
        links : collection of str
            Those of the robot.
        optional : collection of str
            Those that a variant may lack.

        Raises
        ------
        ConfigError
            It lacks a pad that no variant may lack.
        """
        for name in self.pads:
            if name not in links and name not in optional:
                raise ConfigError(
                    f"gripper_contact/pads: the robot has no link '{name}'; one that only some "
                    "variants have belongs into hardware/optional_links"
                )
        return bool(self.pads) and all(name in links for name in self.pads)
