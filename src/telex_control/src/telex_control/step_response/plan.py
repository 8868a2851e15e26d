"""Plan of a step response: joints, start and target positions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from ..common.params import ConfigError, read_struct, require, require_range, require_text

CURRENT = "current"
"""The posture in which the robot is."""


@dataclass(frozen=True)
class PostureConfig:
    """Where a robot's joints are stepped.

    Attributes
    ----------
    pose : str
        A named pose.
    positions : dict of str to float
        By joint, in place of the pose's (rad, m).
    steps : dict of str to float
        By joint (rad, m), not 0.
    """

    pose: str
    steps: Dict[str, float]
    positions: Dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_text(self, "pose")
        for joint, step in self.steps.items():
            require(step != 0.0, f"steps/{joint} is 0; a step is needed")


@dataclass(frozen=True)
class PlanConfig:
    """The file ``step_response.yaml``.

    Attributes
    ----------
    record_time, rest_time : float
        After a step, and before it (s).
    speed : float
        Of moves between postures, as a share of the URDF's velocity limits.
    groups : dict of str to list of str
        Joints that share a figure.
    via : str
        The named pose through which postures are entered and left.
    """

    groups: Dict[str, List[str]]
    via: str
    postures: Dict[str, PostureConfig]
    record_time: float = 2.5
    rest_time: float = 1.0
    speed: float = 0.5

    def __post_init__(self) -> None:
        require_range(self, "record_time", 1.0, 60.0)
        require_range(self, "rest_time", 0.1, 60.0)
        require_range(self, "speed", maximum=1.0, above=0.0)
        require_text(self, "via")
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
