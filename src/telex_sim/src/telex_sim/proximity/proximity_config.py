"""Configuration of the watched distances between a robot's arm and its surroundings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Iterator, Set, Tuple

from telex_control.common.params import ConfigError, require, require_range


@dataclass(frozen=True)
class ProximityConfig:
    """Which distances are watched.

    Attributes
    ----------
    rate : float
        How often they are taken while somebody listens (Hz of sim time); 0: never.
    near : float
        Distance within which a pair is told also when the arm rests (m).
    horizon : float
        A pair that the arm's present velocities could bring together within this time (s) is told
        from further away.
    range : float
        What is further away is never told (m).
    most_pairs : int
        The nearest that are told.
    joints : tuple of str
        The arm's joints, from its base outwards; none: nothing is watched.
    fingers : tuple of tuple of str
        The joints of each finger. Fingers may touch what is not the robot's own, and what they
        hold between them belongs to the arm.
    """

    rate: float = 30.0
    near: float = 0.04
    horizon: float = 0.25
    range: float = 0.2
    most_pairs: int = 32
    joints: Tuple[str, ...] = ()
    fingers: Tuple[Tuple[str, ...], ...] = ()

    def __post_init__(self) -> None:
        require_range(self, "rate", 0.0, 1000.0)
        require_range(self, "near", maximum=2.0, above=0.0)
        require_range(self, "horizon", 0.0, 5.0)
        require_range(self, "range", self.near, 2.0)
        require(
            1 <= self.most_pairs <= 1000,
            f"most_pairs is {self.most_pairs}; 1 to 1000 is possible",
        )
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
