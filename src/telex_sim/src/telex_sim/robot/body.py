"""The body of a robot as plain data, which other processes can be given."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Callable, Dict

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import joints, parse_urdf

from ..engine.simulator_config import RobotConfig
from ..engine.world import Body, World
from ..scene.model import Start
from .self_collision import disable_pairs

_log = logging.getLogger("rosout")


@dataclass(frozen=True)
class RobotBody:
    """A robot's looks to physics.

    Attributes
    ----------
    model : str
        Name in the scene.
    """

    model: str
    urdf: str
    config: RobotConfig

    @classmethod
    def of(cls, urdf: str, config: RobotConfig, namespace: str) -> RobotBody:
        """That of a robot in `namespace`, which gives its name where the configuration does not."""
        return cls(config.model or namespace.rsplit("/", 1)[-1], urdf, config)

    def start_positions(self, asked: str) -> Dict[str, float]:
        """Where the joints start, without those of the pose that only variants have.

        Parameters
        ----------
        asked : str
            Named pose that the scene asks for; empty for none.

        Returns
        -------
        dict of str to float
            By joint (rad, m).

        Raises
        ------
        ConfigError
            A joint of the pose is unknown, or beyond its limits.
        """
        start, described = self.config.start, joints(parse_urdf(self.urdf))
        positions = {}
        for joint, position in start.joint_positions(asked).items():
            where = f"start/poses/{start.pose_name(asked)}/{joint}"
            if joint not in described and joint in self.config.hardware.optional_joints:
                _log.info("%s: left out, for this robot has no such joint", where)
                continue
            if joint not in described:
                raise ConfigError(
                    f"{where}: the robot has no joint '{joint}'; one that only some variants have "
                    "belongs into hardware/optional_joints"
                )
            limits = described[joint]
            if limits.mimic is not None:
                raise ConfigError(
                    f"{where}: the joint follows '{limits.mimic.joint}'; give that one alone"
                )
            if not limits.lower <= position <= limits.upper:
                raise ConfigError(
                    f"{where} is {position}; its limits are {limits.lower} to {limits.upper}"
                )
            positions[joint] = position
        return positions

    def load(
        self,
        world: World,
        scene_start: Start,
        positions: Dict[str, float],
        resolve: Callable[[str], str],
    ) -> Body:
        """Put it into `world`, where its configuration or else the scene says.

        Parameters
        ----------
        positions : dict of str to float
            Of the joints (rad, m).
        resolve : callable
            Turns a mesh address (``package://…``) into a path.

        Raises
        ------
        WorldError
            PyBullet refuses the URDF.
        """
        config, start = self.config, self.config.start
        ground = scene_start.ground + start.height
        x, y, z, yaw = start.place or (scene_start.x, scene_start.y, ground, scene_start.yaw)
        followers = {
            name: each.mimic.position(positions.get(each.mimic.joint, 0.0))
            for name, each in joints(parse_urdf(self.urdf)).items()
            if each.mimic is not None
        }
        body = world.load_robot(
            self.urdf,
            resolve,
            (x, y, z),
            yaw,
            {**positions, **followers},
            config.fixed_base,
            config.self_collision.enabled,
            config.tracks.belts,
        )
        disable_pairs(body, config.self_collision)
        return body
