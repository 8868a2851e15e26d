"""Configuration of a gripper's pads, and of the speed at which a grasp counts as slipping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Tuple

from telex_control.common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    rate_or_never,
    require,
)


@dataclass(frozen=True)
class GripperContactConfig(Declared):
    """What is told of a gripper's contacts."""

    rate: float = rate_or_never(
        50.0,
        "How often they are taken while somebody listens (Hz of sim time); 0: never.",
        1000.0,
    )
    pads: Tuple[str, ...] = parameter((), "The links of both pads; none: there is no gripper.")
    slip_speed: float = number(
        3e-3,
        "Of what is held along a pad, from which it counts as slipping (m/s).",
        maximum=1.0,
        above=0.0,
    )
    stick_speed: float = number(
        1e-3, "Below which it no longer does (m/s).", 0.0, lambda own: own.slip_speed
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            len(self.pads) in (0, 2) and len(set(self.pads)) == len(self.pads),
            f"pads names {', '.join(self.pads)}; two links are needed, or none",
        )

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
