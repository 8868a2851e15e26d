"""Configuration of the watched distances between a robot's arm and its surroundings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Iterator, Set, Tuple

from telex_control.common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    rate_or_never,
    require,
)


@dataclass(frozen=True)
class ProximityConfig(Declared):
    """Which distances are watched."""

    rate: float = rate_or_never(
        30.0,
        "How often they are taken while somebody listens (Hz of sim time); 0: never.",
        1000.0,
    )
    near: float = number(
        0.04,
        "Distance within which a pair is told also when the arm rests (m).",
        maximum=2.0,
        above=0.0,
    )
    horizon: float = number(
        0.25,
        "A pair that the arm's present velocities could bring together within this time (s) is "
        "told from further away.",
        0.0,
        5.0,
    )
    range: float = number(0.2, "What is further away is never told (m).", lambda own: own.near, 2.0)
    most_pairs: int = number(32, "The nearest that are told.", 1, 1000)
    joints: Tuple[str, ...] = parameter(
        (), "The arm's joints, from its base outwards; none: nothing is watched."
    )
    fingers: Tuple[Tuple[str, ...], ...] = parameter(
        (),
        "The joints of each finger. Fingers may touch what is not the robot's own, and what they "
        "hold between them belongs to the arm.",
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        seen: Set[str] = set()
        for name in (*self.joints, *(name for finger in self.fingers for name in finger)):
            require(name not in seen, f"joint '{name}' is named twice in joints and fingers")
            seen.add(name)

    def check_joints(self, joints: Collection[str], optional: Collection[str]) -> None:
        """Refuse joints that are not there.

        Parameters
        ----------
        joints : collection of str
            Those of the robot that can move.
        optional : collection of str
            Those that a variant may lack.

        Raises
        ------
        ConfigError
        """
        for key, names in (("joints", self.joints), *self._named_fingers()):
            for name in names:
                if name not in joints and name not in optional:
                    raise ConfigError(
                        f"proximity/{key}: the robot has no movable joint '{name}'; one that only "
                        "some variants have belongs into hardware/optional_joints"
                    )

    def _named_fingers(self) -> Iterator[Tuple[str, Tuple[str, ...]]]:
        for index, finger in enumerate(self.fingers):
            yield f"fingers[{index}]", finger
