"""Plan of a step response: joints, start and target positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from ..common.params import (
    ConfigError,
    Declared,
    number,
    parameter,
    read_struct,
    require,
    required,
    word,
)

CURRENT = "current"
"""The posture in which the robot is."""


@dataclass(frozen=True)
class PostureConfig(Declared):
    """Where a robot's joints are stepped."""

    pose: str = word(required, "A named pose.")
    steps: Dict[str, float] = parameter(required, "By joint (rad, m), not 0.")
    positions: Dict[str, float] = parameter(dict, "By joint, in place of the pose's (rad, m).")

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        for joint, step in self.steps.items():
            require(step != 0.0, f"steps/{joint} is 0; a step is needed")


@dataclass(frozen=True)
class PlanConfig(Declared):
    """The file ``step_response.yaml``."""

    groups: Dict[str, List[str]] = parameter(required, "Joints that share a figure.")
    via: str = word(required, "The named pose through which postures are entered and left.")
    postures: Dict[str, PostureConfig] = parameter(required)
    record_time: float = number(2.5, "After a step (s).", 1.0, 60.0)
    rest_time: float = number(1.0, "Before a step (s).", 0.1, 60.0)
    speed: float = number(
        0.5,
        "Of moves between postures, as a share of the URDF's velocity limits.",
        maximum=1.0,
        above=0.0,
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(bool(self.postures), "postures is empty; at least one is needed")
        require(CURRENT not in self.postures, f"postures/{CURRENT} is no free name")


class Plan:
    """A configuration and the named poses that it refers to.

    Parameters
    ----------
    config
        Content of ``step_response.yaml``.
    poses : mapping
        Named poses: joint positions (rad, m) by joint.

    Raises
    ------
    ConfigError
    """

    def __init__(self, config: Any, poses: Mapping[str, Mapping[str, float]]) -> None:
        self.config = read_struct(PlanConfig, config)
        named = [("via", self.config.via)]
        named += [(f"postures/{key}/pose", value.pose) for key, value in self._postures()]
        for key, name in named:
            if name not in poses:
                raise ConfigError(f"{key} is '{name}'; there are: {', '.join(sorted(poses))}")
        self._poses = poses

    def _postures(self) -> List[Tuple[str, PostureConfig]]:
        return list(self.config.postures.items())

    def postures(self) -> List[str]:
        """Names of the postures."""
        return list(self.config.postures)

    def via(self) -> Dict[str, float]:
        """Positions on the way to and from postures."""
        return dict(self._poses[self.config.via])

    def positions(self, posture: str) -> Dict[str, float]:
        """Positions of a posture (rad, m)."""
        config = self.config.postures[posture]
        return {**self._poses[config.pose], **config.positions}

    def step(self, posture: str, joint: str) -> float:
        """Step of a joint; where the robot is at present, that of the first posture.

        Raises
        ------
        ConfigError
            There is none for this joint.
        """
        name = self.postures()[0] if posture == CURRENT else posture
        steps = self.config.postures[name].steps
        if joint not in steps:
            raise ConfigError(
                f"postures/{name}/steps has no '{joint}'; there are: {', '.join(steps)}"
            )
        return steps[joint]

    def select(self, names: Sequence[str]) -> List[str]:
        """Joints of a list of joints and groups, each once; all for an empty list."""
        groups = self.config.groups
        found: Dict[str, None] = {}
        for name in names or groups:
            found.update(dict.fromkeys(groups.get(name, [name])))
        return list(found)

    def group(self, joint: str) -> str:
        """Group of a joint; one that has none is its own."""
        for name, joints in self.config.groups.items():
            if joint in joints:
                return name
        return joint
